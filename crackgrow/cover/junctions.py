"""Junctions: places where cracks and interfaces cross, touch or end on each other.

Lines that meet get a common vertex there, the same point to the last bit, so that three lines through one place enclose
no speck of rock and a line that ends on another one leaves no gap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.arrangement import connected, on_grid
from crackgrow.geometry.tolerance import ON_LINE, TOUCH

REACH = 3.0 * TOUCH
"""A junction stands for points up to this far from it."""


def with_junctions(cracks: Sequence[CrackGeometry], interfaces: Sequence[CrackGeometry] = ()) -> list[CrackGeometry]:
    """The cracks, then the interfaces, with a vertex at every junction; an end at a junction is no tip.

    All in lattice coordinates. Junctions on interfaces lie exactly on these, so that they stay on the rims of bodies.
    """
    lines = [*cracks, *interfaces]
    places = _on_interfaces(_meeting_places(lines), interfaces)
    if len(places) == 0:
        return lines
    tree = shapely.STRtree(shapely.points(places))
    return [_joined(line, places, tree) for line in lines]


def sides_through_junctions(sides: Floats, lines: Sequence[CrackGeometry]) -> tuple[Floats, Ints]:
    """Sides (n, 2, 2) of a body, cut in two wherever a junction, or an end that is no tip, lies on them.

    Returns the parts (m, 2, 2), and the side (m,) that each belongs to.
    A side and an interface along it that do not share their vertices would enclose slivers, by rounding to the grid;
    and a crack would end beside a slanting side, not on it.
    """
    found = [np.empty((0, 2))]
    for line in lines:
        some = line.junctions.copy()
        some[0] |= not line.tip_at_start
        some[-1] |= not line.tip_at_end
        found.append(line.points[some])
    places = np.concatenate(found)
    every = np.arange(len(sides))
    if len(places) == 0:
        return sides, every
    found, owner = [sides], [every]
    which, hit = shapely.STRtree(shapely.linestrings(sides)).query(shapely.points(places), "dwithin", ON_LINE)
    for side in np.unique(hit):
        start, step = sides[side, 0], np.diff(sides[side], axis=0)[0]
        along = np.unique(places[which[hit == side]], axis=0)
        along = along[np.argsort((along - start) @ step)]
        corners = np.concatenate([sides[side, :1], along, sides[side, 1:]])
        pieces = np.stack([corners[:-1], corners[1:]], axis=1)
        found.append(pieces[np.any(pieces[:, 0] != pieces[:, 1], axis=1)])
        owner.append(np.full(len(found[-1]), side))
    found[0], owner[0] = np.delete(sides, np.unique(hit), axis=0), np.delete(every, np.unique(hit))
    return np.concatenate(found), np.concatenate(owner)


def _on_interfaces(places: Floats, interfaces: Sequence[CrackGeometry]) -> Floats:
    """The places (n, 2), those at interfaces moved onto these: to a vertex where one is there."""
    if len(places) == 0 or len(interfaces) == 0:
        return places
    lines = shapely.multilinestrings([shapely.LineString(line.points) for line in interfaces])
    corners = shapely.multipoints(np.concatenate([line.points for line in interfaces]))
    moved = places.copy()
    for target in (lines, corners):
        near = np.flatnonzero(shapely.dwithin(target, shapely.points(moved), REACH))
        ways = shapely.shortest_line(target, shapely.points(moved[near]))
        moved[near] = on_grid(shapely.get_coordinates(ways)[::2])
    return np.unique(moved, axis=0)


def _meeting_places(lines: Sequence[CrackGeometry]) -> Floats:
    """One point (n, 2) for every place where segments of different lines, or distant ones of one line, meet."""
    if not lines:
        return np.empty((0, 2))
    ends = np.concatenate([np.stack([line.points[:-1], line.points[1:]], axis=1) for line in lines])
    owner = np.repeat(np.arange(len(lines)), [len(line.points) - 1 for line in lines])
    segments = shapely.linestrings(ends)
    first, second = shapely.STRtree(segments).query(segments, predicate="dwithin", distance=TOUCH)
    neighbours = (owner[first] == owner[second]) & (second - first == 1)
    pairs = np.flatnonzero((first < second) & ~neighbours)
    if len(pairs) == 0:
        return np.empty((0, 2))
    found: list[Floats] = []  # vertices first: of the points of one place the first one stands for all
    crossings: list[Floats] = []
    for a, b in zip(first[pairs].tolist(), second[pairs].tolist(), strict=True):
        near = [_vertices_on(ends[a], segments[b]), _vertices_on(ends[b], segments[a])]
        found.extend(near)
        if not any(len(points) for points in near):
            crossings.append(shapely.get_coordinates(shapely.shortest_line(segments[a], segments[b]))[:1])
    points = on_grid(np.concatenate([np.empty((0, 2)), *found, *crossings]))
    one, other = shapely.STRtree(shapely.points(points)).query(
        shapely.points(points), predicate="dwithin", distance=2.0 * TOUCH
    )
    _, representative = np.unique(connected(len(points), one, other), return_index=True)
    return np.asarray(points[representative])


def _vertices_on(ends: Floats, segment: shapely.LineString) -> Floats:
    """Those of two points (2, 2) that lie on a segment."""
    return np.asarray(ends[shapely.dwithin(shapely.points(ends), segment, TOUCH)])


def _joined(line: CrackGeometry, places: Floats, tree: shapely.STRtree) -> CrackGeometry:
    """A line with the `places` (n, 2) on it as vertices; `tree` holds them."""
    points, joined = line.points[:1], np.zeros(1, dtype=bool)
    for start, end in zip(line.points[:-1], line.points[1:], strict=True):
        on_it = places[tree.query(shapely.linestrings([start, end]), predicate="dwithin", distance=REACH)]
        along = (on_it - start) @ (end - start)
        for place in on_it[np.argsort(along)]:
            points, joined = _with_vertex(points, joined, place)
        if np.hypot(*(points[-1] - end)) > REACH or not joined[-1]:
            points, joined = np.vstack([points, end]), np.append(joined, False)
    return replace(
        line,
        points=points,
        joined=joined,
        tip_at_start=line.tip_at_start and not joined[0],
        tip_at_end=line.tip_at_end and not joined[-1],
    )


def _with_vertex(points: Floats, joined: Bools, place: Floats) -> tuple[Floats, Bools]:
    """Vertices (n, 2) with a junction after the last one, or in its stead where that lies at the same place."""
    is_other = joined[-1] and np.any(points[-1] != place)
    if np.hypot(*(points[-1] - place)) <= REACH and not is_other:
        return np.vstack([points[:-1], place]), np.append(joined[:-1], True)
    return np.vstack([points, place]), np.append(joined, True)
