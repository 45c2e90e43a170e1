"""Bringing together what nearly touches: corners of bodies, and ends of cracks on what they end on.

How near that is follows from the size of the scene alone, so that a scene is the same at every lattice spacing. Lengths
typed with six digits meet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.model import Move
from crackgrow.case.segments import nearest_places
from crackgrow.case.shapes import BodyShape, DrawnRing, body_shape, frozen

SNAP: Final = 1e-5  # parts of the scene's size: what comes nearer touches
ITS_OWN: Final = 0.01  # the same, of the sides or segments that move with a point: they turn by less than half a degree
ROUND_OFF: Final = 4.0 * np.finfo(float).eps  # of the largest coordinate: nearer places are one already
MOST_ROUNDS: Final = 50  # ends of cracks that end on each other; each round leaves a part of what the last one moved


def size_of(points: Floats) -> float:
    """Diameter (m) of the least circle round points (n, 2): however they are turned, it is the same."""
    return 2.0 * float(shapely.minimum_bounding_radius(shapely.MultiPoint(points)))


def round_off(points: Floats) -> float:
    """Distance (m) below which places with coordinates like those of `points` (n, 2) are one."""
    return float(ROUND_OFF * np.abs(points).max(initial=0.0))


def snapped_bodies(bodies: list[BodyShape], reach: float) -> tuple[list[BodyShape], list[Move]]:
    """The bodies with common corners where they touch, and the corners that moved.

    A corner moves onto one of an earlier body within `reach` (m). A side gets a corner where one of another body lies
    within the reach of it: it moves there, and two bodies share their corners to the last bit.
    """
    done: list[BodyShape] = []
    moves: list[Move] = []
    for body in bodies:
        if done:
            known = np.concatenate([other.corners for other in done])
            owner = np.repeat([other.name for other in done], [len(other.corners) for other in done])
            rings = []
            for ring in body.rings:
                nearest = shapely.STRtree(shapely.points(known)).nearest(shapely.points(ring.points))
                distance = np.hypot(*(known[nearest] - ring.points).T)
                near = distance <= np.minimum(reach, ITS_OWN * _shorter_side(ring.points))
                rings.append(replace(ring, points=frozen(np.where(near[:, None], known[nearest], ring.points))))
                for k in np.flatnonzero(near):
                    what, onto = f"a corner of body '{body.name}'", f"one of body '{owner[nearest[k]]}'"
                    moves.append(_move(what, onto, distance[k], known[nearest[k]]))
            body = body_shape(body.name, rings)
        done.append(body)
    return [_with_corners_of(body, done, reach, moves) for body in done], moves


def _move(what: str, onto: str, distance: float, place: Floats, end: tuple[str, str] | None = None) -> Move:
    return Move(what, onto, float(distance), (float(place[0]), float(place[1])), end)


def _shorter_side(points: Floats) -> Floats:
    """The shorter (n,) of the two sides at each corner of a ring (n, 2)."""
    sides = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    return np.asarray(np.minimum(sides, np.roll(sides, 1)))


def _with_corners_of(body: BodyShape, bodies: list[BodyShape], reach: float, moves: list[Move]) -> BodyShape:
    """The body with a corner wherever one of another body lies beside a side of it, not beside a corner of its own."""
    others = [(other.name, other.corners) for other in bodies if other is not body]
    if not others:
        return body
    known = np.concatenate([corners for _, corners in others])
    owner = np.repeat([name for name, _ in others], [len(corners) for _, corners in others])
    same = round_off(known)
    own = shapely.multipoints(body.corners)
    away = shapely.distance(own, shapely.points(known)) > same
    known, owner = known[away], owner[away]
    tree, rings = shapely.STRtree(shapely.points(known)), []
    for ring in body.rings:
        sides = np.stack([ring.points, np.roll(ring.points, -1, axis=0)], axis=1)
        lines = shapely.linestrings(sides)
        which, corner = tree.query(lines, predicate="dwithin", distance=reach)
        distance = shapely.distance(lines[which], shapely.points(known[corner]))
        along = np.sum((known[corner] - sides[which, 0]) * (sides[which, 1] - sides[which, 0]), axis=1)
        length = np.hypot(*(sides[which, 1] - sides[which, 0]).T)
        beside = (along > 0.0) & (along < length**2) & (distance > same) & (distance < ITS_OWN * length)
        order = np.lexsort((along, which))
        order = order[beside[order]]
        rings.append(_with_corners(ring, which[order], known[corner[order]]))
        onto = f"a side of body '{body.name}'"
        moves += [_move(f"a corner of body '{owner[corner[k]]}'", onto, distance[k], known[corner[k]]) for k in order]
    return body_shape(body.name, rings)


def _with_corners(ring: DrawnRing, side: NDArray[np.int64], corners: Floats) -> DrawnRing:
    """A ring with corners (n, 2) more, on the sides (n,), in order along it; equal ones once."""
    if len(side) == 0:
        return ring
    new = np.ones(len(side), dtype=bool)
    new[1:] = (side[1:] != side[:-1]) | np.any(corners[1:] != corners[:-1], axis=1)
    side, corners = side[new], corners[new]
    points = np.insert(ring.points, side + 1, corners, axis=0)
    drawn = np.insert(ring.drawn, side + 1, ring.drawn[side])
    names = np.insert(np.array(ring.edge_names, dtype=object), side + 1, np.array(ring.edge_names, dtype=object)[side])
    return replace(ring, points=frozen(points), edge_names=tuple(names.tolist()), drawn=drawn)


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """One end of a crack, and what it may touch."""

    crack: str
    first: bool  # whether it is the start
    body: BodyShape | None  # in which the crack lies
    near: tuple[str, ...]  # other cracks, in order, that come near it
    earlier: frozenset[str]  # those of them whose ends are looked at before it

    @property
    def which(self) -> str:
        """The end in words, `start` or `end`."""
        return "start" if self.first else "end"


def snapped_cracks(
    cracks: dict[str, Floats], hosts: dict[str, BodyShape], reach: float
) -> tuple[dict[str, Floats], list[Move]]:
    """The cracks (n, 2) m with their ends on what they come within `reach` (m) of, and the ends that moved.

    First ends meet corners of their body, ends of earlier cracks and vertices of others; then sides of the body. Last,
    those that are left meet segments of other cracks: an end that lies on one moves with it.
    """
    lines = {name: np.array(points) for name, points in cracks.items()}
    ends = _ends_of(cracks, hosts, reach)
    found: dict[int, tuple[Floats, str]] = {}
    for index, end in enumerate(ends):
        place = _fixed_place(end, lines, reach)
        if place is not None:
            found[index] = place
            _at(lines, end)[:] = place[0]
    loose = [index for index in range(len(ends)) if index not in found]
    for _ in range(MOST_ROUNDS):
        before = {name: line.copy() for name, line in lines.items()}
        for index in loose:
            place = _place_on_cracks(ends[index], lines, reach)
            if place is not None:
                found[index] = place
                _at(lines, ends[index])[:] = place[0]
        if all(np.array_equal(line, lines[name]) for name, line in before.items()):
            break
    moves = []
    for index, (_, onto) in sorted(found.items()):
        end = ends[index]
        what, moved_to = f"the {end.which} of crack '{end.crack}'", _at(lines, end)
        distance = np.hypot(*(moved_to - _at(cracks, end)))
        moves.append(_move(what, onto, distance, moved_to, (end.crack, end.which)))
    return {name: frozen(points) for name, points in lines.items()}, moves


def _ends_of(cracks: dict[str, Floats], hosts: dict[str, BodyShape], reach: float) -> list[_End]:
    """Both ends of every crack that has a length."""
    names = [name for name, points in cracks.items() if len(points) > 1]
    if not names:
        return []
    tree = shapely.STRtree([shapely.LineString(cracks[name]) for name in names])
    points = shapely.points(np.concatenate([cracks[name][[0, -1]] for name in names]))
    near: list[set[int]] = [set() for _ in points]
    for end, line in tree.query(points, predicate="dwithin", distance=3.0 * reach).T.tolist():  # both may move
        near[end].add(line)
    return [
        _End(
            names[index // 2],
            index % 2 == 0,
            hosts.get(names[index // 2]),
            tuple(names[line] for line in sorted(others - {index // 2})),
            frozenset(names[line] for line in others if line < index // 2),
        )
        for index, others in enumerate(near)
    ]


def _at(lines: dict[str, Floats], end: _End) -> Floats:
    """The end of a line, a view (2,)."""
    return np.asarray(lines[end.crack][0 if end.first else -1])


def _reach_of(end: _End, lines: dict[str, Floats], reach: float) -> float:
    """How far (m) an end may move."""
    line = lines[end.crack]
    segment = line[1] - line[0] if end.first else line[-1] - line[-2]
    return min(reach, ITS_OWN * float(np.hypot(*segment)))


def _fixed_place(end: _End, lines: dict[str, Floats], reach: float) -> tuple[Floats, str] | None:
    """The corner, vertex or side of the body that an end comes near, and what that is; None if it stays."""
    point, reach = _at(lines, end), _reach_of(end, lines, reach)
    for places, what in _points_near(end, lines):
        distance = np.hypot(*(places - point).T)
        nearest = int(np.argmin(distance))
        if distance[nearest] <= reach:
            return places[nearest].copy(), what
    if end.body is None:
        return None
    return _on_lines(point, end.body.sides, f"the boundary of body '{end.body.name}'", reach)


def _points_near(end: _End, lines: dict[str, Floats]) -> Iterator[tuple[Floats, str]]:
    """Points (n, 2) that an end may move onto, and what they are; ends of earlier cracks have moved already."""
    if end.body is not None:
        yield end.body.corners, f"a corner of body '{end.body.name}'"
    for name in end.near:
        points = lines[name] if name in end.earlier else lines[name][1:-1]
        if len(points):
            yield points, f"a vertex of crack '{name}'"


def _place_on_cracks(end: _End, lines: dict[str, Floats], reach: float) -> tuple[Floats, str] | None:
    """The place on another crack that an end comes near, and what that is; None if it stays."""
    point, reach = _at(lines, end), _reach_of(end, lines, reach)
    segments = {name: np.stack([lines[name][:-1], lines[name][1:]], axis=1) for name in end.near}
    places = [_on_lines(point, segments[name], f"crack '{name}'", reach) for name in end.near]
    found = [place for place in places if place is not None]
    return min(found, key=lambda place: float(np.hypot(*(place[0] - point)))) if found else None


def _on_lines(point: Floats, segments: Floats, what: str, reach: float) -> tuple[Floats, str] | None:
    """The nearest place to a point on segments (n, 2, 2) within `reach` (m), the point itself if it lies on one."""
    places = nearest_places(point, segments)
    distance = np.hypot(*(places - point).T)
    nearest = int(np.argmin(distance))
    if distance[nearest] > reach:
        return None
    on_it = distance[nearest] <= round_off(segments.reshape(-1, 2))
    return (point if on_it else places[nearest]).copy(), what
