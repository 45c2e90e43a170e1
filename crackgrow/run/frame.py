"""The specimen as a mesh with its fields, for output: values at its nodes and in its cells.

Whole tiles are quads, other elements triangles, divided where they are large near a tip. A side is divided, or not, by
its own length and place, so the cells on both sides of it agree, and no corner of a cell lies in a side of another one.
Corners are double along cracks and between bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crackgrow.accuracy.energy_norm import ErrorEstimate
from crackgrow.approximation.basis import fields_at
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import Elements
from crackgrow.cover.tips import Tip
from crackgrow.geometry.arrangement import connected, vertex_ids
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.quadrature.elements import triangulate
from crackgrow.ragged import distinct, found_in, spans, starts_of
from crackgrow.run.result import Frame
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_of
from crackgrow.vectors import cross

LONGEST = 0.75
"""Sides of cells are no longer than this many times the distance of their middle from a tip."""

SHORTEST = 1.0 / 16.0
"""Sides shorter than this many sizes of the cells of the cover round a tip stay as they are."""


def make_frame(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, error: ErrorEstimate | None = None
) -> Frame:
    """The frame of displacements `u` (n_dofs,) m, and of their `error` if it is known."""
    elements, mesh = cover.elements, output_mesh(cover.elements, cover.tips)
    n, middles = len(mesh.points), [mesh.points[cells].mean(axis=1) for cells in (mesh.triangles, mesh.quads)]
    _, first = np.unique(mesh.place_node, return_index=True)  # all elements that meet at a node say the same
    at, element = np.concatenate([mesh.points, *middles]), np.append(mesh.place_element[first], mesh.element)
    value, *slopes = fields_at(cover, at, element, u)
    places, bodies = cover.lattice.to_metres(at), elements.body[element]
    stress = stress_of(materials, np.stack(slopes, axis=2), bodies, places)
    _away_from_tips(cover, mesh, stress[:n])
    zz = np.sum(np.array([material.zz for material in materials])[bodies] * stress, axis=1)
    return Frame(
        points=places[:n],
        triangles=mesh.triangles,
        quads=mesh.quads,
        displacement=value[:n],
        stress=stress[n:],
        stress_zz=zz[n:],
        point_stress=stress[:n],
        point_stress_zz=zz[:n],
        body=bodies[n:],
        error_density=None if error is None else _densities(elements, cover.lattice.spacing, error)[mesh.element],
    )


def _away_from_tips(cover: Cover, mesh: OutputMesh, stress: Floats) -> None:
    """Put the means of the neighbours into the stress (n, 3) at nodes at tips, where it is infinite."""
    tips, order = np.array([tip.point for tip in cover.tips]).reshape(-1, 2), np.argsort(mesh.points[:, 0])
    first, last = (np.searchsorted(mesh.points[order, 0], tips[:, 0] + off) for off in (-ON_LINE, ON_LINE))
    near, y = order[spans(first, last - first)], np.repeat(tips[:, 1], last - first)
    at_tip = np.zeros(len(mesh.points), dtype=bool)
    at_tip[near[np.abs(mesh.points[near, 1] - y) < ON_LINE]] = True
    ends = np.concatenate([mesh.sides, mesh.sides[:, ::-1]])
    ends = np.unique(ends[at_tip[ends[:, 0]] & ~at_tip[ends[:, 1]]], axis=0)
    nodes, index = np.unique(ends[:, 0], return_inverse=True)
    sums = [np.bincount(index, column, len(nodes)) for column in stress[ends[:, 1]].T]
    stress[nodes] = np.stack(sums, axis=1) / np.bincount(index, minlength=len(nodes))[:, None]


def _densities(elements: Elements, spacing: float, error: ErrorEstimate) -> Floats:
    """Root of the energy density of the error in each element (n,), by the mean density of the computed stress."""
    start, end = elements.vertices[elements.rings.start], elements.vertices[elements.rings.end]
    area = 0.5 * spacing**2 * np.bincount(elements.rings.face, cross(start, end), elements.n)
    mean = error.norm**2 / area.sum()
    there = area > 0.0  # slivers that the grid leaves no area hold no error
    density = np.divide(error.elements, area, out=np.zeros(elements.n), where=there)
    return np.sqrt(density / mean) if mean > 0.0 else np.zeros(elements.n)


@dataclass(frozen=True, slots=True, eq=False)
class OutputMesh:
    """Cells over all elements, triangles first, in lattice coordinates.

    A node is met by one element or by several: each such pair is a place where fields can be told.
    """

    points: Floats  # (n, 2) the nodes
    triangles: Ints  # (t, 3) nodes, counter-clockwise
    quads: Ints  # (q, 4)
    element: Ints  # (t + q,) element that each cell lies in
    sides: Ints  # (s, 2) nodes at the ends of the sides of cells, each side once for each of its cells
    place_node: Ints  # (p,)
    place_element: Ints  # (p,) ascending


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    """Cells by their vertices, of which there is one at each place."""

    vertices: Floats  # (v, 2)
    triangles: Ints  # (t, 3)
    owners: Ints  # (t,) element that each triangle lies in
    quads: Ints  # (q, 4)
    whole: Ints  # (q,) the element that each quad is
    closed: Ints  # (c, 2) ends of the sides along cracks and between bodies

    def keys(self, ends: Ints) -> Ints:
        """A number for each pair of vertices (..., 2), the same either way round."""
        a, b = ends[..., 0], ends[..., 1]
        return np.asarray(np.minimum(a, b) * len(self.vertices) + np.maximum(a, b))


def _cells_of(elements: Elements) -> _Cells:
    """Undivided cells; a whole tile with corners in its sides is a fan of triangles."""
    triangles, owner = triangulate(elements.polygons)
    counts = np.bincount(elements.rings.face, minlength=elements.n)[: elements.n_whole]
    square = np.flatnonzero(counts == 4)
    between = (elements.edges.right >= 0) & ~elements.passable
    n, ids = len(elements.vertices), vertex_ids(np.concatenate([elements.vertices, triangles.reshape(-1, 2)]))
    vertex = np.empty(int(ids.max()) + 1, dtype=np.int64)
    vertex[ids[:n]] = np.arange(n)
    cells = _Cells(
        vertices=elements.vertices,
        triangles=vertex[ids[n:]].reshape(-1, 3),
        owners=owner + elements.n_whole,
        quads=elements.rings.start[starts_of(counts)[square, None] + np.arange(4)],
        whole=square,
        closed=np.stack([elements.edges.a[between], elements.edges.b[between]], axis=1),
    )
    return _fanned(elements, cells, np.flatnonzero(counts != 4))


def _fanned(elements: Elements, cells: _Cells, chosen: Ints) -> _Cells:
    """The whole tiles `chosen` (k,) as triangles from their middles to their sides."""
    number = np.full(elements.n, -1)
    number[chosen] = len(cells.vertices) + np.arange(len(chosen))
    side = np.flatnonzero(number[elements.rings.face] >= 0)
    owner = elements.rings.face[side]
    fans = np.stack([elements.rings.start[side], elements.rings.end[side], number[owner]], axis=1)
    kept = number[cells.whole] < 0
    return replace(
        cells,
        vertices=np.concatenate([cells.vertices, elements.reference[chosen]]),
        triangles=np.concatenate([cells.triangles, fans]),
        owners=np.concatenate([cells.owners, owner]),
        quads=cells.quads[kept],
        whole=cells.whole[kept],
    )


def _divided(elements: Elements, cells: _Cells, tips: Sequence[Tip]) -> _Cells:
    """Halve sides that are too long until none is; where one of a triangle is, its longest one is halved, too.

    So triangles stay about as slender as they are (Rivara 1984).
    """
    near = _too_long(cells.vertices[_sides_of(cells.quads)], tips).any(axis=1)
    cells, n_looked = _fanned(elements, cells, cells.whole[near]), 0
    while True:
        ends = _sides_of(cells.triangles)
        keys, first, side = np.unique(cells.keys(ends), return_index=True, return_inverse=True)
        ends, side = ends.reshape(-1, 2)[first], side.reshape(-1, 3)
        new = (ends >= n_looked).any(axis=1)  # others are short enough
        halved = np.zeros(len(ends), dtype=bool)
        halved[new] = _too_long(cells.vertices[ends[new]], tips)
        if not halved.any():
            return cells
        longest = np.argmax(_lengths(cells.vertices[ends])[side], axis=1)
        of_triangle = side[np.arange(len(side)), longest]
        while (more := halved[side].any(axis=1) & ~halved[of_triangle]).any():
            halved[of_triangle[more]] = True
        touched = (found_in(keys[halved], cells.keys(_sides_of(cells.quads))) >= 0).any(axis=1)
        if touched.any():
            cells = _fanned(elements, cells, cells.whole[touched])
        else:
            middle = np.full(len(ends), -1)
            n_looked = len(cells.vertices)
            middle[halved] = n_looked + np.arange(int(halved.sum()))
            cells = _halved(cells, ends[halved], middle[side], longest)


def _halved(cells: _Cells, ends: Ints, middle: Ints, longest: Ints) -> _Cells:
    """Sides between `ends` (s, 2) get vertices in their middles, the next ones.

    middle: (t, 3) vertex in the middle of each side of the triangles, -1 for none
    longest: (t,) the side of each triangle that is halved first
    """
    turn = (longest[:, None] + np.arange(3)) % 3
    cut = np.take_along_axis(middle, turn, axis=1)
    whole = cut[:, 0] < 0
    a, b, c = np.take_along_axis(cells.triangles, turn, axis=1)[~whole].T
    m, p, q = cut[~whole].T
    first, second = np.concatenate([c, b]), np.concatenate([a, c])  # ends of the other two sides
    apex, on_side, owner = np.tile(m, 2), np.concatenate([q, p]), np.tile(cells.owners[~whole], 2)
    again = on_side >= 0
    parts = [
        cells.triangles[whole],
        np.stack([first, second, apex], axis=1)[~again],
        np.stack([first, on_side, apex], axis=1)[again],
        np.stack([on_side, second, apex], axis=1)[again],
    ]
    keys, closed = cells.keys(ends), cells.closed
    place = found_in(keys, cells.keys(closed))
    there = place >= 0
    between = len(cells.vertices) + place[there]
    halves = [np.stack([closed[there, 0], between], axis=1), np.stack([between, closed[there, 1]], axis=1)]
    return replace(
        cells,
        vertices=np.concatenate([cells.vertices, 0.5 * (cells.vertices[ends[:, 0]] + cells.vertices[ends[:, 1]])]),
        triangles=np.concatenate(parts),
        owners=np.concatenate([cells.owners[whole], owner[~again], owner[again], owner[again]]),
        closed=np.concatenate([closed[~there], *halves]),
    )


def output_mesh(elements: Elements, tips: Sequence[Tip]) -> OutputMesh:
    """The mesh of all elements; corners at a vertex are one node if a way round it joins them without a closed side."""
    cells = _cells_of(elements)
    cells = _divided(elements, cells, tips) if tips else cells
    n_vertices, n_corners = len(cells.vertices), cells.triangles.size
    element = np.concatenate([cells.owners, cells.whole])
    owner = np.repeat(element, np.repeat([3, 4], [len(cells.triangles), len(cells.quads)]))
    corner = np.concatenate([cells.triangles.ravel(), cells.quads.ravel()])
    places, place = np.unique(owner * n_vertices + corner, return_inverse=True)
    place_element, vertex = np.divmod(places, n_vertices)
    parts = place[:n_corners].reshape(-1, 3), place[n_corners:].reshape(-1, 4)
    sides = np.concatenate([_sides_of(part).reshape(-1, 2) for part in parts])
    turned = vertex[sides[:, 0]] > vertex[sides[:, 1]]
    sides[turned] = sides[turned, ::-1]
    keys = cells.keys(vertex[sides])
    sides, keys = sides[order := np.argsort(keys, kind="stable")], keys[order]
    joined = np.flatnonzero((keys[1:] == keys[:-1]) & (found_in(distinct(cells.keys(cells.closed)), keys[1:]) < 0))
    node = connected(len(places), sides[joined].ravel(), sides[joined + 1].ravel())
    _, first = np.unique(node, return_index=True)
    return OutputMesh(
        points=cells.vertices[vertex[first]],
        triangles=node[parts[0]],
        quads=node[parts[1]],
        element=element,
        sides=node[sides],
        place_node=node,
        place_element=place_element,
    )


def _too_long(ends: Floats, tips: Sequence[Tip]) -> Bools:
    """Which sides between points (..., 2, 2) are too long for their distance from a tip."""
    length, middle = _lengths(ends).ravel(), (0.5 * (ends[..., 0, :] + ends[..., 1, :])).reshape(-1, 2)
    reach, order = length.max(initial=0.0) / LONGEST, np.argsort(middle[:, 0])
    x, found = middle[order, 0], np.zeros(len(length), dtype=bool)
    for tip in tips:
        first, last = np.searchsorted(x, tip.point[0] + np.array([-reach, reach]))
        near = order[first:last]
        distance = np.hypot(*(middle[near] - tip.point).T)
        found[near] |= length[near] > np.maximum(LONGEST * distance, SHORTEST * tip.size)
    return found.reshape(ends.shape[:-2])


def _lengths(ends: Floats) -> Floats:
    """Distances (...) of points (..., 2, 2)."""
    return np.asarray(np.hypot(*np.moveaxis(ends[..., 1, :] - ends[..., 0, :], -1, 0)))


def _sides_of(cells: Ints) -> Ints:
    """Ends (n, k, 2) of the sides of cells with corners (n, k)."""
    return np.stack([cells, np.roll(cells, -1, axis=1)], axis=2)
