"""Sites: places where a crack can go on or start, each with the sector of rock that it may go into.

A tip is one, with all of the rock but what is beside its own faces. Others are the corners of rock between cracks and
rims that leave one place: behind a kink, beside a wing, across a crack that another one ends on, at a point of a rim.
A point within the rock has no corner: a crack that starts there goes both ways.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats
from crackgrow.case.sizing import SHARP
from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import BodyGeometry
from crackgrow.cover.tips import Tip
from crackgrow.geometry.polyline import kink_angles
from crackgrow.geometry.tolerance import SAME_PLACE

LARGEST_KINK = np.deg2rad(110.0)
"""Rays further back than this run along the crack's own faces, whose stress says nothing of growth."""

BESIDE = np.deg2rad(30.0)
"""A new crack leaves others, and rims, at this angle at least: closer to a face it would split off a sliver."""

NARROWEST = np.deg2rad(10.0)
"""Sectors of rock to look into, half of their width: narrower ones are none."""

Kind = Literal["tip", "crack", "rim", "rock"]


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """A place where a crack can go on (a tip) or start, in lattice coordinates."""

    kind: Kind
    point: Floats  # (2,)
    direction: float  # rad from +x: outward direction of a tip; the middle of the sector
    half_width: float  # rad, of the sector to either side
    body: int
    crack: int | None  # number of the crack that it lies on
    in_shear: bool = False  # of a tip: whether its crack has started in shear

    @property
    def both_ways(self) -> bool:
        """Whether a crack that starts here goes to both sides."""
        return self.kind == "rock"


@dataclass(frozen=True, slots=True, eq=False)
class StartRegions:
    """Where cracks may start, besides where others began to grow."""

    on_cracks: bool
    on_rims: bool
    in_rock: bool
    spacing: float  # of points on rims and in the rock, lattice units
    apart: tuple[float | None, ...]  # body by body, lattice units: from cracks and rims; None: nothing starts there


def tip_site(tip: Tip, in_shear: bool = False) -> Site:
    """The site of a tip, whose crack may have started in shear."""
    direction = float(np.arctan2(tip.rotation[0, 1], tip.rotation[0, 0]))
    return Site("tip", tip.point, direction, LARGEST_KINK, tip.body, tip.crack, in_shear)


def start_sites(
    cover: Cover, crack_bodies: Sequence[int], began: Sequence[Floats], regions: StartRegions
) -> list[Site]:
    """Sites other than tips. `began` are places (2,) where cracks went on from what was given of them."""
    found: list[Site] = []
    for place in _corners_of_cracks(cover, began, regions.on_cracks):
        found += _on_cracks(cover, crack_bodies, place, regions)
    if regions.on_rims:
        found += _on_rims(cover, regions)
    if regions.in_rock:
        found += _in_rock(cover, regions)
    return found


def _corners_of_cracks(cover: Cover, began: Sequence[Floats], everywhere: bool) -> list[Floats]:
    """Where growth began, and `everywhere` sharp kinks and meetings of cracks, each once."""
    places = list(began)
    for crack in cover.cracks if everywhere else ():
        sharp = np.zeros(len(crack.points), dtype=bool)
        sharp[1:-1] = np.abs(kink_angles(crack.points)) > SHARP
        places += list(crack.points[sharp | crack.junctions])
    once: list[Floats] = []
    for place in places:
        if all(np.hypot(*(place - other)) > SAME_PLACE for other in once):
            once.append(place)
    return once


def _on_cracks(cover: Cover, crack_bodies: Sequence[int], place: Floats, regions: StartRegions) -> Iterator[Site]:
    """The sites between the cracks at a place, unless it lies on a rim or is nothing but a tip."""
    arms, owner = [], None
    for number in np.sort(cover.crack_tree.query(shapely.Point(place), "dwithin", distance=SAME_PLACE)).tolist():
        here = _arms(cover.cracks[number].points, place)
        if len(here) and (owner is None or len(here) == 1):
            owner = number  # a crack that ends here goes on, before one that passes
        arms += here
    if len(arms) < 2 or owner is None or regions.apart[crack_bodies[owner]] is None:
        return
    region = cover.bodies[crack_bodies[owner]].region
    if not shapely.dwithin(region.boundary, shapely.Point(place), SAME_PLACE):
        for direction, half_width in _sectors(arms):
            yield Site("crack", place, direction, half_width, crack_bodies[owner], owner)


def _arms(points: Floats, place: Floats) -> list[float]:
    """Directions (rad) in which a polyline (n, 2) leaves one of its vertices."""
    found = []
    for vertex in np.flatnonzero(np.hypot(*(points - place).T) <= SAME_PLACE).tolist():
        for other in (vertex - 1, vertex + 1):
            if 0 <= other < len(points):
                found.append(float(np.arctan2(*(points[other] - place)[::-1])))
    return found


def _sectors(arms: Sequence[float]) -> Iterator[tuple[float, float]]:
    """Middle and half width (rad) of what new cracks can go into between lines that leave a place."""
    angles = np.sort(arms)
    for start, end in zip(angles, np.append(angles[1:], angles[0] + 2.0 * np.pi), strict=True):
        half_width = 0.5 * float(end - start) - BESIDE
        if half_width >= NARROWEST:
            yield 0.5 * float(start + end), half_width


def _on_rims(cover: Cover, regions: StartRegions) -> Iterator[Site]:
    """Sites along the rims of bodies and at their re-entrant corners, away from cracks."""
    for body, (geometry, apart) in enumerate(zip(cover.bodies, regions.apart, strict=True)):
        if apart is None:
            continue
        for ring in geometry.rings:
            turns = kink_angles(np.concatenate([ring[-1:], ring, ring[:1]]))
            places = np.concatenate([_along_rim(ring, np.abs(turns) > SHARP, regions.spacing), ring[turns < -SHARP]])
            for place in _free_of_cracks(cover, places, apart):
                yield from _at_rim(geometry, body, place)


def _along_rim(ring: Floats, corner: Bools, spacing: float) -> Floats:
    """Points (k, 2) on a ring (n, 2), at most a `spacing` apart, and more than half of one from its corners (n,).

    They divide each side between corners evenly, and a ring without any by four: turned and mirrored alike.
    """
    if not corner.any():
        line = shapely.LineString(np.concatenate([ring, ring[:1]]))
        n = 4 * int(np.ceil(line.length / (4.0 * spacing)))
        found = shapely.line_interpolate_point(line, np.arange(n) / n, normalized=True)
        return np.asarray(shapely.get_coordinates(found))
    first = int(np.flatnonzero(corner)[0])
    ring, ends = np.roll(ring, -first, axis=0), np.flatnonzero(np.roll(corner, -first))
    closed, sides = np.concatenate([ring, ring[:1]]), []
    for start, end in zip(ends, np.append(ends[1:], len(ring)), strict=True):
        side = shapely.LineString(closed[start : end + 1])
        n = int(np.ceil(side.length / spacing))
        between = shapely.line_interpolate_point(side, np.arange(1, n) / n, normalized=True)
        sides.append(shapely.get_coordinates(between))
    return _away(np.concatenate(sides), ring[ends], 0.5 * spacing)


def _away(places: Floats, corners: Floats, distance: float) -> Floats:
    """Those of some places (n, 2) that are farther than that from all corners (k, 2)."""
    off = np.hypot(*(places[:, None] - corners).transpose(2, 0, 1)).min(axis=1, initial=np.inf)
    return np.asarray(places[off > distance])


def _at_rim(geometry: BodyGeometry, body: int, place: Floats) -> Iterator[Site]:
    """The sites at a point (2,) of a rim."""
    sides = geometry.sides
    along = shapely.dwithin(shapely.linestrings(sides), shapely.Point(place), SAME_PLACE)
    ways = (sides[along] - place).reshape(-1, 2)
    ways = ways[np.hypot(*ways.T) > SAME_PLACE]
    for direction, half_width in _sectors(np.arctan2(ways[:, 1], ways[:, 0]).tolist()):
        inside = place + 1e3 * SAME_PLACE * np.array([np.cos(direction), np.sin(direction)])
        if shapely.contains_xy(geometry.region, *inside):
            yield Site("rim", place, direction, half_width, body, None)


def _in_rock(cover: Cover, regions: StartRegions) -> Iterator[Site]:
    """Sites on a square grid within bodies, away from cracks and rims."""
    for body, (geometry, apart) in enumerate(zip(cover.bodies, regions.apart, strict=True)):
        if apart is None:
            continue
        low, high = geometry.rings[0].min(axis=0), geometry.rings[0].max(axis=0)
        n = np.maximum(np.ceil((high - low) / regions.spacing).astype(int), 1)
        x, y = (lo + (np.arange(k) + 0.5) * (hi - lo) / k for lo, hi, k in zip(low, high, n, strict=True))
        places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        inside = shapely.contains_xy(shapely.buffer(geometry.region, -apart), *places.T)
        for place in _free_of_cracks(cover, places[inside], apart):
            yield Site("rock", place, 0.0, LARGEST_KINK, body, None)  # every axis is seen, some of them twice


def _free_of_cracks(cover: Cover, places: Floats, apart: float) -> Floats:
    """Those of some places (n, 2) that no crack comes close to."""
    if len(cover.cracks) == 0 or len(places) == 0:
        return places
    taken, _ = cover.crack_tree.query(shapely.points(places), "dwithin", distance=apart)
    return np.delete(places, np.unique(taken), axis=0)
