"""Lines brought together: parts that run along others are taken out, ends are put onto what they nearly end on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from shapely import LineString, Point
from shapely.ops import substring

from crackgrow.arrays import Floats, frozen
from crackgrow.case.model import Move
from crackgrow.case.shapes import BodyShape
from crackgrow.case.touching import round_off

ALONG: Final = 10.0  # tolerances: a line that is beside another one for longer runs along it; below 6 degrees at an end
MOST_ROUNDS: Final = 20  # ends that end on each other; each round leaves a part of what the last one moved


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """What a line may end on, or run along."""

    words: str  # such as "crack 'joint'"
    vertex: str  # what a vertex of it is called
    shape: LineString
    is_rim: bool = False  # of a body: nothing touches it but with an end


def crack_thing(name: str, points: Floats) -> Thing:
    """A crack (n, 2) m."""
    return Thing(f"crack '{name}'", f"a vertex of crack '{name}'", LineString(points))


def rims_of(bodies: Iterable[BodyShape]) -> list[Thing]:
    """The outlines and holes of bodies."""
    rings = [(f"body '{its.name}'", LineString([*ring.points, ring.points[0]])) for its in bodies for ring in its.rings]
    return [Thing(f"the boundary of {body}", f"a corner of {body}", ring, is_rim=True) for body, ring in rings]


def unstacked(
    line: LineString, things: Iterable[Thing], tolerance: float
) -> tuple[list[LineString], list[tuple[LineString, str]]]:
    """What is left of a line without its parts that run along others within the tolerance (m); these, and along what.

    Parts that are shorter than the tolerance are not left.
    """
    left, out = [line], []
    for thing in things:
        for part in [part for part in left if part.dwithin(thing.shape, tolerance)]:
            kept = _clear_of(part, thing, tolerance)
            if kept == [(0.0, part.length)]:
                continue
            at, ends = left.index(part), [0.0, *(end for pair in kept for end in pair), part.length]
            left[at : at + 1] = [substring(part, *pair) for pair in kept]
            least = round_off(shapely.get_coordinates(part))
            lost = [pair for pair in zip(ends[::2], ends[1::2], strict=True) if pair[1] - pair[0] > least]
            out += [(substring(part, *pair), thing.words) for pair in lost]
    return left, out


def _clear_of(line: LineString, thing: Thing, tolerance: float) -> list[tuple[float, float]]:
    """The parts of a line, from one arc length (m) to another, that are left of it beside something."""
    beside = _parts(line, thing.shape.buffer(tolerance))
    along = [ends for ends in beside if _runs_along(line, ends, thing, tolerance)] + _parts(line, thing.shape)
    close, begin, kept = thing.shape.buffer(2.0 * tolerance), 0.0, []
    for start, end in [*sorted(along), (line.length, line.length)]:
        if start - begin > tolerance and not close.covers(substring(line, begin, start)):  # its ends would be on it
            kept.append((begin, start))
        begin = max(begin, end)
    return kept


def _parts(line: LineString, other: shapely.Geometry) -> list[tuple[float, float]]:
    """The parts of a line, from one arc length (m) to another, that lie in or on something, in order."""
    found = shapely.get_parts(shapely.line_merge(line.intersection(other)))
    ends = [sorted(line.project(Point(part.coords[end])) for end in (0, -1)) for part in found if part.length > 0.0]
    return sorted((start, end) for start, end in ends)


def _runs_along(line: LineString, part: tuple[float, float], thing: Thing, tolerance: float) -> bool:
    """Whether a part of a line beside something runs along it, and does not just end there, pass by or cross it."""
    start, end = part
    at_start, at_end = start <= 0.0, end >= line.length
    if at_start or at_end:
        return end - start > ALONG * tolerance
    if thing.is_rim or end - start <= ALONG * tolerance:
        return thing.is_rim
    here, other = substring(line, start, end), thing.shape
    places = [other.project(Point(here.coords[k])) for k in (0, -1)]
    is_beside = all(0.0 < place < other.length for place in places)
    return not (is_beside and here.crosses(other) and here.intersection(other).geom_type == "Point")


def joined(
    cracks: Mapping[str, Floats], tolerances: Mapping[str, tuple[float, float]], fixed: Sequence[Thing], same: float
) -> tuple[dict[str, Floats], list[Move]]:
    """Cracks (n, 2) m whose ends lie on what they come near to; a move, perhaps by nothing, of each such end.

    tolerances: how near (m), of start and end
    same: m, what is nearer lies there already
    fixed: rims and cracks that stay as they are

    An end comes to lie on the nearest rim, or else on a crack beside it, else on the end of another crack; there on a
    vertex that is hardly farther than the nearest place. What sticks out beyond is cut off.
    """
    lines = {name: np.array(points) for name, points in cracks.items() if len(points) > 1}
    things = [*(crack_thing(name, points) for name, points in lines.items()), *fixed]
    names = list(lines)
    ends = [(number, end) for number in range(len(names)) for end in ("start", "end")]
    if not ends:
        return dict(cracks), []
    reach = np.concatenate([tolerances[name] for name in names])
    points = shapely.points(np.concatenate([lines[name][[0, -1]] for name in names]))
    near: list[list[int]] = [[] for _ in ends]
    tree = shapely.STRtree([thing.shape for thing in things])
    for end, other in tree.query(points, predicate="dwithin", distance=3.0 * reach).T.tolist():  # both may move
        if other != ends[end][0]:
            near[end].append(other)
    found: dict[tuple[str, str], str] = {}
    for _ in range(MOST_ROUNDS):
        moved = False
        for (number, which), others, tolerance in zip(ends, near, reach.tolist(), strict=True):
            name, line = names[number], lines[names[number]]
            new = _ended(line if which == "end" else line[::-1], [things[other] for other in others], tolerance, same)
            if new is None:
                continue
            ended, found[name, which] = new
            ended = ended if which == "end" else ended[::-1]
            if ended.shape != line.shape or not np.allclose(ended, line, rtol=0.0, atol=round_off(line)):
                moved, lines[name], things[number] = True, ended, crack_thing(name, ended)
        if not moved:
            break
    moves = []
    for (name, which), onto in found.items():
        place, before = (of[name][0 if which == "start" else -1] for of in (lines, cracks))
        what = f"the {which} of crack '{name}'"
        moves.append(Move(what, onto, float(np.hypot(*(place - before))), tuple(place.tolist()), (name, which)))
    return {name: frozen(lines.get(name, points)) for name, points in cracks.items()}, moves


def _ended(line: Floats, near: Sequence[Thing], tolerance: float, same: float) -> tuple[Floats, str] | None:
    """A line (n, 2) m that ends on what its end is near to, and what that is; None where it is near to nothing."""
    end, shape = Point(line[-1]), LineString(line)
    found: list[tuple[bool, bool, bool, float, Thing]] = []
    for thing in near:
        distance, at = thing.shape.distance(end), thing.shape.project(end)
        if distance <= tolerance:
            is_beside = thing.is_rim or 0.0 < at < thing.shape.length
            found.append((not is_beside, distance > same, not thing.is_rim, distance, thing))
    if not found:
        return None
    _, is_off, _, distance, host = min(found, key=lambda item: item[:4])
    place = shapely.get_coordinates(host.shape.interpolate(host.shape.project(end)))[0]
    if not is_off:
        return (line if distance <= round_off(line) else np.vstack([line[:-1], place])), host.words
    words, start = host.words, _last(shape, host.shape, tolerance)
    vertices = [
        (float(np.hypot(*(corner - line[-1]))), tuple(corner), thing.vertex)
        for *_, thing in found
        for corner in shapely.get_coordinates(thing.shape)
        if host.shape.dwithin(Point(corner), same)
    ]
    crossings = shapely.get_coordinates(substring(shape, start, shape.length).intersection(host.shape))
    at = host.shape.project(shape.interpolate(start))
    if not host.is_rim and not 0.0 < at < host.shape.length:  # the end goes on beside the end of the other one
        place, words = shapely.get_coordinates(host.shape.interpolate(at))[0], host.vertex
    elif min(vertices, default=(np.inf,))[0] <= min(tolerance, np.sqrt(2.0) * distance):  # hardly farther
        _, corner, words = min(vertices)
        place, start = np.array(corner), _last(shape, Point(corner), tolerance)
    elif len(crossings):
        place = crossings[np.argmin(shapely.line_locate_point(shape, shapely.points(crossings)))]
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    ended = np.vstack([line[:1], line[1:-1][lengths[1:-1] < start], place])
    if len(ended) == 2 and np.hypot(*(place - line[0])) <= tolerance:
        return None  # it would be too short
    onto = [host, *(thing for thing in near if thing.is_rim)]
    return None if any(_is_amiss(ended, thing, tolerance, same) for thing in onto) else (ended, words)


def _is_amiss(ended: Floats, thing: Thing, tolerance: float, same: float) -> bool:
    """Whether the last segment of a line (n, 2) m that ends on something runs along it, or crosses it though a rim."""
    last = LineString(ended[-2:])
    on_it = last.intersection(thing.shape.buffer(same))
    ends = shapely.points(ended[[-1, -2]])  # the other one may be an end that has not moved yet
    off = shapely.distance(shapely.get_parts(on_it)[:, None], ends) > [same, tolerance]
    return bool(on_it.length > 0.5 * last.length or (thing.is_rim and off.all(axis=1).any()))


def _last(line: LineString, other: shapely.Geometry, tolerance: float) -> float:
    """The arc length (m) from which on the end of a line lies within the tolerance of something."""
    parts = _parts(line, other.buffer((1.0 + 1e-6) * tolerance))
    return max(parts, key=lambda part: part[1])[0] if parts else line.length
