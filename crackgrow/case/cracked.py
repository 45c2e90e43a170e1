"""Cracked parts of interfaces: between two of its places a boundary follows a law of contact, the rest is bonded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.ops import substring

from crackgrow.arrays import Floats
from crackgrow.case.layout import SMALLEST, Scene
from crackgrow.case.segments import line_length
from crackgrow.case.shapes import Resolved, frozen
from crackgrow.vectors import cross

STRAIGHT = np.deg2rad(0.5)
"""rad: a boundary that turns less at a tip is straight there."""


def opened(lines: tuple[Floats, ...], ends: Sequence[Sequence[float]]) -> tuple[Floats, ...]:
    """The lines of a boundary; of one all round a body, which comes in halves, one line that ends far from a crack.

    The crack is the shorter way between its `ends`.
    """
    if len(lines) != 2 or any((one[-1] != other[0]).any() for one, other in (lines, lines[::-1])):
        return lines
    ring = shapely.LineString(np.concatenate([lines[0], lines[1][1:]]))
    first, last = (ring.project(shapely.Point(end)) for end in ends)
    over = (last - first) % ring.length
    at = (first + 0.5 * over + (0.5 * ring.length if over <= 0.5 * ring.length else 0.0)) % ring.length
    parts = [shapely.get_coordinates(substring(ring, *part)) for part in ((at, ring.length), (0.0, at))]
    return (frozen(np.concatenate([parts[0], parts[1][1:]])),)


def parted(
    lines: Sequence[Floats], ends: Sequence[Sequence[float]], reach: float
) -> tuple[Floats, tuple[Floats, ...]] | None:
    """The cracked part (n, 2) m of a boundary between two places on one of its lines, and the lines that are left.

    None where no line has both. An end within `reach` (m) of a corner is there.
    """
    places = [shapely.Point(end) for end in ends]
    for number, line in enumerate(lines):
        shape = shapely.LineString(line)
        if all(shape.dwithin(place, reach) for place in places):
            corners = [shape.project(shapely.Point(corner)) for corner in line]
            first, last = sorted(_snapped(shape.project(place), corners, reach) for place in places)
            pieces = [(start, end) for start, end in ((0.0, first), (last, shape.length)) if end > start]
            left = [frozen(shapely.get_coordinates(substring(shape, *piece))) for piece in pieces]
            crack = frozen(shapely.get_coordinates(substring(shape, first, last)))
            return crack, (*left, *lines[:number], *lines[number + 1 :])
    return None


def _snapped(at: float, corners: Sequence[float], reach: float) -> float:
    """A place along a line (m), moved onto a corner of it that is within reach."""
    nearest = min(corners, key=lambda corner: abs(corner - at))
    return nearest if abs(nearest - at) <= reach else at


def fault_of_crack(scene: Scene, interface: Resolved) -> str:
    """What is wrong with the cracked part of an interface, in words; empty where nothing is."""
    if interface["contact"] == "bonded":
        return "the interface is bonded, so that its cracked part has no law; give it a law of contact"
    ends, reach = interface["cracked"], scene.reach
    lines = opened(scene.lines_between(*interface["between"]), ends)
    whole = shapely.MultiLineString(list(lines))
    for end in ends:
        line = shapely.shortest_line(whole, shapely.Point(end))
        apart = float(shapely.length(line))
        if apart > reach:
            where = f"{scene.exact_point(np.array(end))} is {scene.units.show(apart, 'length', 3)} from the interface"
            return f"{where}; the nearest point of it is {scene.exact_point(shapely.get_coordinates(line)[0])}"
    found = parted(lines, ends, reach)
    if found is None:
        return "its ends lie on different lines of the interface; wanted: both on one of them"
    crack, left = found
    if line_length(crack) <= max(SMALLEST * (scene.get("numerics", "spacing") or 0.0), reach):
        return f"the cracked part has a length of {scene.length(line_length(crack))}; wanted: two places apart"
    if not left:
        return "the cracked part is the whole interface; leave `cracked` out"
    for line in left:
        for before, behind in ((crack, line), (line, crack)):
            if np.hypot(*(before[-1] - behind[0])) <= scene.tolerance:
                step, next_step = before[-1] - before[-2], behind[1] - behind[0]
                if abs(np.arctan2(cross(step, next_step), step @ next_step)) > STRAIGHT:
                    where = scene.point(behind[0])
                    return f"an end of the cracked part {where} lies on a corner of the interface; wanted: beside it"
    return ""


def fault_of_toughness(scene: Scene, interface: Resolved) -> str:
    """What is wrong with the toughness of an interface, in words; empty where nothing is."""
    if interface["contact"] == "bonded":
        return "lets a bond part, and the interface is bonded, so that this has no law; give it a law of contact"
    if (law := scene.get("growth", "law")) not in (None, "critical"):
        return f"lets a tip grow at G = G_c, not at a rate; wanted with growth.law: {law}: leave it out"
    return ""
