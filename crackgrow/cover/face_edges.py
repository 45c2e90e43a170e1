"""Edges of the arrangement along the lines that bound rock: cracks, interfaces and the rims of bodies.

They know the elements on their two sides; nothing else decides on which side of a line a point lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.regions import EdgeRegion
from crackgrow.cover.pieces import Pieces
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry, body_index
from crackgrow.errors import GeometryError
from crackgrow.geometry.arrangement import Edges, as_complex
from crackgrow.geometry.polyline import arc_lengths, segment_directions
from crackgrow.geometry.tolerance import GRID
from crackgrow.ragged import found_in
from crackgrow.vectors import cross


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


def edges_along(pieces: Pieces, n: int, vertices: Floats, edges: Edges) -> tuple[Ints, Ints]:
    """The edges (k,) along the pieces of the first n segments, in order, and the segments (k,) that they lie on.

    A piece that the extension of a tip crosses, or that passes a vertex within rounding, leads through that, and is
    several edges; -1 stands for what is none.
    """
    number = found_in(as_complex(vertices), as_complex(pieces.points))
    first = pieces.first[pieces.segment < n]
    start, end = number[first], number[first + 1]
    edge = edges.between(start, end)
    broken = np.flatnonzero(edge < 0).tolist()
    chains = [_chain(int(start[k]), int(end[k]), vertices, edges) for k in broken]
    counts = np.ones(len(edge), dtype=np.int64)
    counts[broken] = [len(chain) for chain in chains]
    piece = np.repeat(np.arange(len(edge)), counts)
    edge = edge[piece]
    if chains:
        edge[edge < 0] = np.concatenate(chains)
    return edge, pieces.segment[piece]


def _chain(start: int, end: int, vertices: Floats, edges: Edges) -> Ints:
    """The edges (k,) from one vertex to another through those within rounding of the straight way; -1 for no way.

    Vertices beside the way that no edge leads to are passed by.
    """
    if min(start, end) < 0:  # outside of the bodies
        return np.array([-1])
    way = vertices[end] - vertices[start]
    way /= np.hypot(*way)
    along, across = (vertices - vertices[start]) @ way, cross(way, vertices - vertices[start])
    near = np.flatnonzero((np.abs(across) < GRID) & (along > 0.0) & (along < along[end]))
    passed = [start]
    for vertex in (*near[np.argsort(along[near])].tolist(), end):
        if edges.between(np.array(passed[-1:]), np.array([vertex]))[0] >= 0:
            passed.append(vertex)
    chain = np.array(passed if passed[-1] == end else [-1, -1])
    return edges.between(chain[:-1], chain[1:])


def edges_on_lines(
    lines: Sequence[CrackGeometry], traces: Sequence[tuple[Ints, Ints]], vertices: Floats, edges: Edges
) -> tuple[FaceEdges, ...]:
    """The edges along each crack or interface, sorted and turned along it.

    `traces` are, line by line, the edges (p,) on its pieces, in order, and the segments (p,) they lie on. Raises
    GeometryError where a piece is no edge between two elements.
    """
    for line, (edge, _) in zip(lines, traces, strict=True):
        if len(edge) == 0 or not np.all((edge >= 0) & (edges.right[edge] >= 0)):
            length = f"{arc_lengths(line.points)[-1]:.6g} spacings"
            raise GeometryError(f"'{line.name}' could not be cut along all of its {length}; use another spacing")
    return tuple(_along(line, *trace, vertices, edges) for line, trace in zip(lines, traces, strict=True))


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


def edges_on_outlines(traces: Sequence[tuple[Ints, Ints]], vertices: Floats, edges: Edges, body: Ints) -> OutlineEdges:
    """Return the edges of elements on the boundaries of all bodies, with the side that each lies on.

    An edge between two bodies is there for each. `body` (elements,) is the body of each element; `traces` are, body
    by body, the edges (p,) on its boundary, -1 for a piece that is no edge, and their sides (p,). Raises GeometryError
    where an edge has no side.
    """
    shared = np.flatnonzero((edges.right >= 0) & (body[edges.left] != body[edges.right]))
    between = np.flatnonzero((edges.right < 0) | np.isin(np.arange(len(edges.a)), shared))
    number = np.concatenate([between, shared])
    start, end, element = (
        np.concatenate([one[between], other[shared]])
        for one, other in ((edges.a, edges.b), (edges.b, edges.a), (edges.left, edges.right))
    )
    side = np.full(len(element), -1, dtype=np.int64)
    for index, (edge, on_side) in enumerate(traces):
        known = np.full(len(edges.a), -1, dtype=np.int64)
        known[edge[edge >= 0]] = on_side[edge >= 0]
        mine = body[element] == index
        side[mine] = known[number[mine]]
    if (side < 0).any():
        raise GeometryError("an element has a side that is neither shared nor on an outline")
    return OutlineEdges(np.stack([vertices[start], vertices[end]], axis=1), body[element], side, element, number)


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
