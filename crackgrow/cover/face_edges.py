"""Edges of the arrangement along the lines that bound rock: cracks, interfaces and the rims of bodies.

They know the elements on their two sides; nothing else decides on which side of a line a point lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.regions import EdgeRegion
from crackgrow.case.surface import end_word
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry, body_index
from crackgrow.errors import GeometryError
from crackgrow.geometry.arrangement import Edges
from crackgrow.geometry.polyline import arc_lengths, segment_directions
from crackgrow.geometry.tolerance import ON_LINE

NEAR_BY = 2.0
"""Spacings: edges whose middles are further from the box of a line are not on it, nor end at its corners."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceEdges:
    """Edges of the arrangement along a line with rock on its left, in order of arc length from its start."""

    s: Floats  # (n, 2) arc length at both ends, spacings
    points: Floats  # (n, 2, 2) both ends
    segment: Ints  # (n,) segment of the polyline
    plus: Ints  # (n,) element on the left of the direction from start to end
    minus: Ints  # (n,) element on the right, -1 where there is none
    edge: Ints  # (n,) number of the edge of the arrangement

    def beside(self, at_end: bool) -> tuple[int, int]:
        """The elements on the left and on the right of the line's end, or of its start."""
        last = -1 if at_end else 0
        return int(self.plus[last]), int(self.minus[last])

    def parts(self, edge: Ints, limits: Floats) -> FaceEdges:
        """Parts of edges (k,), each between two fractions `limits` (k, 2) of its length, as edges of their own."""
        start, step = self.points[edge, 0], self.points[edge, 1] - self.points[edge, 0]
        s = self.s[edge, :1] + limits * np.diff(self.s[edge], axis=1)
        points = start[:, None] + limits[:, :, None] * step[:, None]
        return FaceEdges(s, points, self.segment[edge], self.plus[edge], self.minus[edge], self.edge[edge])


@dataclass(frozen=True, slots=True, eq=False)
class OutlineEdges:
    """Edges of the arrangement along the rims of all bodies; two entries where two bodies touch."""

    points: Floats  # (n, 2, 2) both ends, the body on the left
    body: Ints  # (n,)
    side: Ints  # (n,) side of the body
    element: Ints  # (n,) element inside
    edge: Ints  # (n,) number of the edge of the arrangement


def edges_on_lines(
    lines: Sequence[CrackGeometry], traces: Sequence[tuple[Ints, Ints]], vertices: Floats, edges: Edges, n_whole: int
) -> tuple[tuple[FaceEdges, ...], Bools]:
    """The edges along each crack or interface, sorted and turned along it, and which of all edges they are.

    `traces` are, line by line, the edges (p,) on its pieces, in order and -1 where a piece is no edge but several, and
    the segments (p,) they lie on.
    """
    is_crack = np.zeros(len(edges.a), dtype=bool)
    found = []
    for line, (edge, segment) in zip(lines, traces, strict=True):
        if len(edge) == 0 or not np.all((edge >= 0) & (edges.right[edge] >= 0)):
            edge, segment = _searched(line, vertices, edges, n_whole)
        is_crack[edge] = True
        found.append(_along(line, edge, segment, vertices, edges))
    return tuple(found), is_crack


def _along(line: CrackGeometry, edge: Ints, segment: Ints, vertices: Floats, edges: Edges) -> FaceEdges:
    """Edges (n,) on segments (n,) of a line, turned along it."""
    along = segment_directions(line.points)[segment]
    forward = np.sum((vertices[edges.b[edge]] - vertices[edges.a[edge]]) * along, axis=1) > 0
    start = vertices[np.where(forward, edges.a[edge], edges.b[edge])]
    end = vertices[np.where(forward, edges.b[edge], edges.a[edge])]
    offset = np.sum((start - line.points[segment]) * along, axis=1)
    lengths = np.sum((end - start) * along, axis=1)
    s = arc_lengths(line.points)[segment] + offset
    return FaceEdges(
        s=np.stack([s, s + lengths], axis=1),
        points=np.stack([start, end], axis=1),
        segment=segment,
        plus=np.where(forward, edges.left[edge], edges.right[edge]),
        minus=np.where(forward, edges.right[edge], edges.left[edge]),
        edge=edge,
    )


def _searched(line: CrackGeometry, vertices: Floats, edges: Edges, n_whole: int) -> tuple[Ints, Ints]:
    """Edges (n,) along a line, in order, and the segments (n,) they lie on, where pieces have been cut again."""
    candidates = np.flatnonzero((edges.right >= n_whole) & (edges.left >= n_whole))
    middles = 0.5 * (vertices[edges.a[candidates]] + vertices[edges.b[candidates]])
    low, high = line.points.min(axis=0) - NEAR_BY, line.points.max(axis=0) + NEAR_BY
    beside = np.all((middles >= low) & (middles <= high), axis=1)
    candidates, middles = candidates[beside], shapely.points(middles[beside])
    segments = shapely.linestrings(np.stack([line.points[:-1], line.points[1:]], axis=1))
    segment, hit = shapely.STRtree(middles).query(segments, predicate="dwithin", distance=ON_LINE)
    used = np.unique(np.concatenate([edges.a[candidates], edges.b[candidates]]))
    corners = used[shapely.STRtree(shapely.points(vertices[used])).nearest(shapely.points(line.points))]
    chain = _chain(vertices, corners, edges.a[candidates[hit]], edges.b[candidates[hit]], segment, line)
    return candidates[hit[chain]], segment[chain]


def _off(vertices: Floats, crack: CrackGeometry, at_end: bool) -> str:
    """An end of a line, and how far from it the nearest vertex is."""
    distance = float(np.hypot(*(vertices - crack.seen_from(at_end)[0]).T).min())
    return f"{end_word(at_end)} (the nearest vertex is {distance:.2g} spacings from it)"


def _chain(vertices: Floats, corners: Ints, a: Ints, b: Ints, segment: Ints, crack: CrackGeometry) -> Ints:
    """The edges (a, b), of those that lie on a `segment` of a crack within rounding, that lead along it, in order.

    A lattice line closer to the crack than rounding gives more than one way; the shortest is taken. From one segment to
    the next it leads through their common vertex only, that of their corner: a crack may come back to itself.
    """
    from scipy.sparse import coo_array  # here: loading SciPy takes longer than many a check of a case
    from scipy.sparse.csgraph import dijkstra

    keys = np.stack([np.concatenate([a, b]), 2 * np.tile(segment, 2) + 1])  # (vertex, 2 segment + 1), even at corners
    for shift in (0, 1):
        keys[1, keys[0] == corners[np.tile(segment, 2) + shift]] += 2 * shift - 1
    used, ends = np.unique(keys, axis=1, return_inverse=True)
    ends = ends.reshape(2, -1)
    n = used.shape[1]
    lengths = np.hypot(*(vertices[b] - vertices[a]).T)
    graph = coo_array((lengths, tuple(ends)), shape=(n, n)).tocsr()
    number = coo_array((np.arange(1, len(a) + 1), tuple(ends)), shape=(n, n)).tocsr()
    is_end = [(used[0] == corners[corner]) & (used[1] == 2 * corner) for corner in (0, len(corners) - 1)]
    if not all(found.any() for found in is_end):
        missed = " and ".join(_off(vertices, crack, at_end) for at_end in (False, True))
        raise GeometryError(
            f"'{crack.name}' could not be cut along all of its {arc_lengths(crack.points)[-1]:.6g} spacings: no edge "
            f"of the cut lattice ends at its {missed}; use another spacing"
        )
    first, last = (int(np.argmax(found)) for found in is_end)
    length, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    total = arc_lengths(crack.points)[-1]
    if abs(length[last] - total) > 1e-6 * max(total, 1.0):
        raise GeometryError(f"'{crack.name}' could not be cut along all of its {total:g} spacings")
    chain = []
    while last != first:
        chain.append(number[before[last], last] + number[last, before[last]] - 1)
        last = int(before[last])
    return np.array(chain[::-1], dtype=np.int64)


def edges_on_outlines(
    sides: Sequence[Floats], traces: Sequence[tuple[Ints, Ints]], vertices: Floats, edges: Edges, body: Ints
) -> OutlineEdges:
    """The edges along the rims of the bodies (sides (n, 2, 2)), with the side that each lies on.

    `traces` are, body by body, the edges (p,) on the pieces of its sides, -1 where a piece is no edge but several, and
    the sides (p,).
    """
    inner = np.flatnonzero(edges.right >= 0)
    shared = inner[body[edges.left[inner]] != body[edges.right[inner]]]
    is_between = edges.right < 0
    is_between[shared] = True
    between = np.flatnonzero(is_between)
    points = np.concatenate(
        [
            np.stack([vertices[edges.a[between]], vertices[edges.b[between]]], axis=1),
            np.stack([vertices[edges.b[shared]], vertices[edges.a[shared]]], axis=1),
        ]
    )
    element = np.concatenate([edges.left[between], edges.right[shared]])
    number = np.concatenate([between, shared])
    side = np.full(len(element), -1, dtype=np.int64)
    known = np.full(len(edges.a), -1, dtype=np.int64)
    for index, (ends, (edge, on_side)) in enumerate(zip(sides, traces, strict=True)):
        known[edge[edge >= 0]] = on_side[edge >= 0]
        mine = body[element] == index
        side[mine] = known[number[mine]]
        known[edge] = -1
        _search_sides(side, np.flatnonzero(mine & (side < 0)), points, ends)
    return OutlineEdges(points, body[element], side, element, number)


def _search_sides(side: Ints, unknown: Ints, points: Floats, ends: Floats) -> None:
    """Fill in the nearest of the sides with `ends` (n, 2, 2) for the `unknown` ones of edges with ends `points`."""
    if len(unknown) == 0:
        return
    tree = shapely.STRtree(shapely.linestrings(ends))
    middles = shapely.points(points[unknown].mean(axis=1))
    (which, hit), distance = tree.query_nearest(middles, all_matches=False, return_distance=True)
    side[unknown[which]] = hit
    if distance.max(initial=0.0) > ON_LINE:
        raise GeometryError("an element has a side that is neither shared nor on an outline")


def edges_of_region(outlines: OutlineEdges, bodies: Sequence[BodyGeometry], region: EdgeRegion) -> FaceEdges:
    """The edges along a part of a body's rim, with nothing on their right. Those that reach out of it are cut off."""
    body = body_index(bodies, region.body)
    ends = bodies[body].sides
    found = []
    begin = 0.0  # arc length
    for side, (low, high) in zip(region.sides.tolist(), region.limits.tolist(), strict=True):
        mine = np.flatnonzero((outlines.body == body) & (outlines.side == side))
        corner, step = ends[side, 0], ends[side, 1] - ends[side, 0]
        fraction = (outlines.points[mine] - corner) @ step / (step @ step)
        clipped = np.clip(fraction, low, high)
        keep = np.flatnonzero(clipped[:, 1] > clipped[:, 0])
        keep = keep[np.argsort(clipped[keep, 0])]
        cut, length = clipped[keep], float(np.hypot(*step))
        found.append((begin + (cut - low) * length, corner + cut[:, :, None] * step, mine[keep]))
        begin += (high - low) * length
    chosen = np.concatenate([part[2] for part in found])
    return FaceEdges(
        s=np.concatenate([part[0] for part in found]),
        points=np.concatenate([part[1] for part in found]),
        segment=np.concatenate([np.full(len(part[2]), number) for number, part in enumerate(found)]),
        plus=outlines.element[chosen],
        minus=np.full(len(chosen), -1),
        edge=outlines.edge[chosen],
    )
