"""Bringing together what nearly touches: corners of bodies.

How near that is follows from the size of the scene alone, so that a scene is the same at every lattice spacing. Lengths
typed with six digits meet.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.model import Move
from crackgrow.case.shapes import BodyShape, DrawnRing, body_shape, frozen

SNAP: Final = 1e-5  # parts of the scene's size: what comes nearer touches
ITS_OWN: Final = 0.01  # the same, of the sides or segments that move with a point: they turn by less than half a degree
ROUND_OFF: Final = 4.0 * np.finfo(float).eps  # of the largest coordinate: nearer places are one already


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


def _move(what: str, onto: str, distance: float, place: Floats) -> Move:
    return Move(what, onto, float(distance), (float(place[0]), float(place[1])))


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
