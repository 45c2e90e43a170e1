"""Bodies that touch: corners that nearly meet are brought together, then overlaps and common boundaries are found.

How near that is follows from the size of the scene alone, so that a scene is the same at every lattice spacing. Lengths
typed with six digits meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints, frozen
from crackgrow.case.model import Case, Move
from crackgrow.case.shapes import BodyShape, DrawnRing

SNAP: Final = 1e-5  # parts of the scene's size: what comes nearer touches
ITS_OWN: Final = 0.01  # the same, of the sides or segments that move with a point: they turn by less than half a degree
ROUND_OFF: Final = 4.0 * np.finfo(float).eps  # of the largest coordinate: nearer places are one already


def size_of(points: Floats) -> float:
    """Diameter (m) of the least circle round points (n, 2): however they are turned, it is the same."""
    return 2.0 * float(shapely.minimum_bounding_radius(shapely.MultiPoint(points)))


def scene_size(case: Case) -> float:
    """Diameter (m) of the least circle round all bodies."""
    return size_of(np.concatenate([body.outline for body in case.bodies]))


def round_off(points: Floats) -> float:
    """Distance (m) below which places with coordinates like those of `points` (n, 2) are one."""
    return float(ROUND_OFF * np.abs(points).max(initial=0.0))


def snapped_bodies(bodies: list[BodyShape], reach: float) -> tuple[list[BodyShape], list[Move]]:
    """The bodies with common corners where they touch, and the corners that moved.

    A corner moves onto one of an earlier body within `reach` (m). A side gets a corner where one of another body lies
    on it or within the reach of it: it moves there, and two bodies share their corners and sides to the last bit.
    """
    done: list[BodyShape] = []
    moves: list[Move] = []
    for body in bodies:
        done.append(_with_corners_on(body, done, reach, moves) if done else body)
    return [_with_corners_of(body, done, reach, moves) for body in done], moves


def _corners_of(bodies: Sequence[BodyShape]) -> tuple[Floats, NDArray[np.object_]]:
    """All corners (n, 2) of bodies, and the name (n,) of the body of each."""
    owners = [body.name for body in bodies for _ in body.corners]
    return np.concatenate([np.zeros((0, 2)), *(body.corners for body in bodies)]), np.array(owners, dtype=object)


def _move(what: str, onto: str, distance: float, place: Floats) -> Move:
    return Move(what, onto, float(distance), (float(place[0]), float(place[1])))


def _with_corners_on(body: BodyShape, bodies: list[BodyShape], reach: float, moves: list[Move]) -> BodyShape:
    """The body with those of its corners on corners of other bodies that are near to these."""
    known, owners = _corners_of(bodies)
    tree, rings = shapely.STRtree(shapely.points(known)), []
    for ring in body.rings:
        onto = tree.nearest(shapely.points(ring.points))
        distance = np.hypot(*(known[onto] - ring.points).T)
        sides = np.hypot(*(np.roll(ring.points, -1, axis=0) - ring.points).T)
        near = distance <= np.minimum(reach, ITS_OWN * np.minimum(sides, np.roll(sides, 1)))
        rings.append(replace(ring, points=frozen(np.where(near[:, None], known[onto], ring.points))))
        for k in np.flatnonzero(near):
            what = f"a corner of body '{body.name}'"
            moves.append(_move(what, f"one of body '{owners[onto[k]]}'", distance[k], known[onto[k]]))
    return BodyShape(body.name, tuple(rings))


def _with_corners_of(body: BodyShape, bodies: list[BodyShape], reach: float, moves: list[Move]) -> BodyShape:
    """The body with a corner wherever one of another body lies beside a side of it, not beside a corner of its own."""
    known, owners = _corners_of([other for other in bodies if other is not body])
    same = round_off(known)
    away = shapely.distance(shapely.multipoints(body.corners), shapely.points(known)) > same
    known, owners = known[away], owners[away]
    tree, rings = shapely.STRtree(shapely.points(known)), []
    for ring in body.rings:
        sides = ring.sides
        lines = shapely.linestrings(sides)
        which, corner = tree.query(lines, predicate="dwithin", distance=reach)
        distance = shapely.distance(lines[which], shapely.points(known[corner]))
        step = sides[which, 1] - sides[which, 0]
        along, length = np.sum((known[corner] - sides[which, 0]) * step, axis=1), np.hypot(*step.T)
        beside = (along > 0.0) & (along < length**2) & (distance < ITS_OWN * length)
        order = np.lexsort((along, which))
        order = order[beside[order]]
        rings.append(_with_corners(ring, which[order], known[corner[order]]))
        for k in order:
            what = f"a corner of body '{owners[corner[k]]}'"
            moves.append(_move(what, f"a side of body '{body.name}'", distance[k], known[corner[k]]))
    return BodyShape(body.name, tuple(rings))


def _with_corners(ring: DrawnRing, side: Ints, corners: Floats) -> DrawnRing:
    """A ring with corners (n, 2) more, on the sides (n,), in order along it; equal ones once."""
    new = np.ones(len(side), dtype=bool)
    new[1:] = (side[1:] != side[:-1]) | np.any(corners[1:] != corners[:-1], axis=1)
    side = side[new]
    names = np.array(ring.edge_names, dtype=object)
    return replace(
        ring,
        points=frozen(np.insert(ring.points, side + 1, corners[new], axis=0)),
        edge_names=tuple(np.insert(names, side + 1, names[side]).tolist()),
        drawn=np.insert(ring.drawn, side + 1, ring.drawn[side]),
    )


def overlap(first: BodyShape, second: BodyShape, tolerance: float) -> Floats | None:
    """Return a point `(2,) float` of a common part that is wider than the tolerance, None if there is none."""
    for part in shapely.get_parts(first.polygon.intersection(second.polygon)):
        if part.area > tolerance * part.length:  # of a thin part of width w and length l: w l > tolerance 2 (w + l)
            return np.array(part.representative_point().coords[0])
    return None


def shared_lines(first: BodyShape, second: BodyShape) -> tuple[Floats, ...]:
    """Return the boundary that two bodies share: open polylines `(n, 2) float`, the first body on their left.

    It is made of the sides that both have; a closed one comes as two.
    """
    theirs = {(*end, *start) for start, end in second.sides.tolist()}
    shared = [[side for side in ring.sides.tolist() if (*side[0], *side[1]) in theirs] for ring in first.rings]
    return tuple(frozen(line) for sides in shared for line in _chained(sides))


def sides_on(body: BodyShape, lines: Sequence[Floats]) -> list[int]:
    """The numbers of the sides of a body that it shares along such lines."""
    shared = {frozenset(map(tuple, side)) for line in lines for side in pairwise(line.tolist())}
    return [number for number, side in enumerate(body.sides.tolist()) if frozenset(map(tuple, side)) in shared]


def _chained(sides: list[list[list[float]]]) -> list[list[list[float]]]:
    """Join sides of one ring, in its order, to polylines; a closed one is halved."""
    chains: list[list[list[float]]] = []
    for start, end in sides:
        if chains and start == chains[-1][-1]:
            chains[-1].append(end)
        else:
            chains.append([start, end])
    if not chains or chains[-1][-1] != chains[0][0]:
        return chains
    if len(chains) > 1:  # the ring begins inside of a shared line
        return [chains[-1] + chains[0][1:], *chains[1:-1]]
    closed = chains[0]
    lengths = np.append(0.0, np.cumsum(np.hypot(*np.diff(np.array(closed), axis=0).T)))
    middle = int(np.argmin(np.abs(lengths - lengths[-1] / 2)))
    return [closed[: middle + 1], closed[middle:]]
