"""Essential conditions by Lagrange multipliers: a point, or linear along an edge (paper eq. (13)).

Each row of the constraint matrix C is a displacement, so that C u = g in metres: at a point the displacement itself,
along an edge the average weighted with the multiplier's hat function.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Component, ContactSupport, EdgeSupport, PointSupport, Support
from crackgrow.case.units import place_text
from crackgrow.cover.cell_lengths import cell_lengths
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.face_edges import FaceEdges
from crackgrow.cover.shapes import body_index
from crackgrow.cover.squares import QUANTA
from crackgrow.errors import GeometryError
from crackgrow.quadrature.rims import points_on_outlines
from crackgrow.vectors import outward_normals

if TYPE_CHECKING:
    from scipy.sparse import csr_array

CLOSE = 0.25
"""Cells: an edge that is closer to a side of its cells has next to nothing of the nodes on the other side."""


@dataclass(frozen=True, slots=True, eq=False)
class Constraints:
    """Linear conditions C u - B m = g on the displacement, m the forces by which they are held."""

    matrix: csr_array  # (m, n_dofs) C
    given: Floats  # (m,) m, g
    support: Ints  # (m,) number of the support that a row belongs to, -1 for none
    component: Ints  # (m,) 0: x, 1: y
    surface: Ints  # (m,) number of the bonded surface that a row belongs to, -1 for none
    load: Ints  # (m,) number of the load whose volume of fluid a row gives, -1 for none
    compliance: Floats  # (m,) m/(N/m), B: zero but for volumes


def constraints(cover: Cover, supports: Sequence[Support]) -> Constraints:
    """The conditions of all supports of the bodies that are there; contact supports have none.

    Raises GeometryError for a support outside of its body.
    """
    from scipy.sparse import csr_array, vstack  # here: who counts conditions alone needs neither it nor the basis

    from crackgrow.approximation.basis import of_component

    prescribing = _prescribing(cover, supports)
    if not prescribing:
        none = np.empty(0, dtype=np.int64)
        return Constraints(csr_array((0, cover.n_dofs)), np.empty(0), none, none, none, none, np.empty(0))
    averages = _averages(cover, [support for _, support in prescribing])
    values = _averaged_values(cover, averages)
    first = np.cumsum([0, *(average.n for average in averages)])
    rows: list[csr_array] = []
    given, owner, axes = [], [], []
    for (number, support), start, average in zip(prescribing, first[:-1], averages, strict=True):
        for component, displacement in enumerate(support.displacement):
            if displacement is not None:
                rows.append(of_component(values[start : start + average.n], component))
                given.append(_prescribed(displacement, average, cover.lattice.to_metres(average.points)))
                owner.append(np.full(average.n, number))
                axes.append(np.full(average.n, component))
    matrix = csr_array(vstack(rows, format="csr"))
    given_at, owners, axis = (np.concatenate(lists) for lists in (given, owner, axes))
    none = np.full(len(axis), -1)
    return Constraints(matrix, given_at, owners, axis, none, none, np.zeros(len(axis)))


def n_constraints(cover: Cover, supports: Sequence[Support]) -> int:
    """How many conditions `constraints` has."""
    held = [support for _, support in _prescribing(cover, supports)]
    components = (sum(component is not None for component in support.displacement) for support in held)
    return sum(average.n * n for average, n in zip(_averages(cover, held), components, strict=True))


def _prescribing(cover: Cover, supports: Sequence[Support]) -> list[tuple[int, PointSupport | EdgeSupport]]:
    """The supports that prescribe displacements of bodies that are there, with their numbers."""
    names = {body.name for body in cover.bodies}
    return [
        (n, support)
        for n, support in enumerate(supports)
        if not isinstance(support, ContactSupport) and held_body(support) in names
    ]


def joined_constraints(parts: Sequence[Constraints]) -> Constraints:
    """The rows of several sets as one set."""
    from scipy.sparse import csr_array, vstack  # as above

    if len(parts) == 1:
        return parts[0]
    arrays = (np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Constraints)[1:])
    return Constraints(csr_array(vstack([part.matrix for part in parts], format="csr")), *arrays)


def ties(rows: csr_array, surface: Ints) -> Constraints:
    """Rows (k, n_dofs) of bonded surfaces (k,) that are held at zero."""
    none, zero = np.full(len(surface), -1), np.zeros(len(surface))
    return Constraints(rows, zero, none, none, surface, none, zero)


@dataclass(frozen=True, slots=True, eq=False)
class EdgePoints:
    """Gauss points along a region of an edge."""

    points: Floats  # (n, 2) lattice coordinates
    lengths: Floats  # (n,) m
    elements: Ints  # (n,)
    sizes: Floats  # (n,) side of the cells there, spacings: see `_sizes_along`
    cells: Floats  # (n,) length from the start of the region, in cells of these sizes
    outward: Floats  # (n, 2) unit normals out of the rock


def points_along(cover: Cover, edges: Sequence[FaceEdges]) -> list[EdgePoints]:
    """The points along each of some rows of edges of outlines."""
    if not edges:
        return []
    ends, elements, numbers = (
        np.concatenate(arrays) for arrays in zip(*((e.points, e.plus, e.edge) for e in edges), strict=True)
    )
    edge, points, lengths = points_on_outlines(cover, ends, elements, numbers)
    outward, spacing = outward_normals(ends[:, 1] - ends[:, 0])[edge], cover.lattice.spacing
    found, first = [], 0
    for row in edges:
        mine = np.flatnonzero((edge >= first) & (edge < first + len(row.edge)))
        own, sizes = edge[mine] - first, _sizes_along(cover, row)
        s = row.s[own, 0] + np.hypot(*(points[mine] - row.points[own, 0]).T)
        cells = cell_lengths(row.s[-1, 1], row, sizes).at(s)
        at, element, length = points[mine], row.plus[own], lengths[mine] * spacing
        found.append(EdgePoints(at, length, element, sizes[own], cells, outward[mine]))
        first += len(row.edge)
    return found


def _sizes_along(cover: Cover, edges: FaceEdges) -> Floats:
    """Side (k,) of the cells along edges, spacings: of those outside of the rock where they are larger and close.

    An edge that is close to the side of its cells has the functions of the nodes there, and no other ones to speak of.
    Cells outside need not be small: these nodes are as far apart as the larger cells are wide.
    """
    own, ends = cover.elements.size[edges.plus], edges.points
    beyond = ends.mean(axis=1) + CLOSE * own[:, None] * outward_normals(ends[:, 1] - ends[:, 0])
    cells = cover.lattice.cells
    there = cells.at(np.floor(QUANTA * beyond).astype(np.int64))
    return np.where(there >= 0, np.maximum(own, cells.size[there] / QUANTA), own)


def held_body(support: Support) -> str:
    """Name of the body that a support holds."""
    return support.body if isinstance(support, PointSupport) else support.region.body


@dataclass(frozen=True, slots=True, eq=False)
class _Averages:
    """Averages of values at points."""

    n: int  # of averages
    row: Ints  # (w,) average, point and weight of that in it
    column: Ints  # (w,)
    weight: Floats  # (w,)
    points: Floats  # (p, 2) lattice coordinates
    elements: Ints  # (p,)

    @property
    def shares(self) -> csr_array:
        """The weight of each point in each average (n, p)."""
        from scipy.sparse import csr_array  # as above

        return csr_array((self.weight, (self.row, self.column)), shape=(self.n, len(self.points)))


def _prescribed(displacement: Component, average: _Averages, places: Floats) -> Floats:
    """Averages (n,) m of a prescribed displacement, whose points lie at `places` (p, 2) m."""
    if callable(displacement):
        return np.asarray(average.shares @ displacement(places))
    return np.full(average.n, displacement)


def _averages(cover: Cover, supports: Sequence[PointSupport | EdgeSupport]) -> list[_Averages]:
    """What each of the supports holds."""
    edges = [cover.edges_on(support.region) for support in supports if not isinstance(support, PointSupport)]
    along_edges = (_along_edge(points, cover.lattice.spacing) for points in points_along(cover, edges))
    return [
        _at_point(cover, support) if isinstance(support, PointSupport) else next(along_edges) for support in supports
    ]


def _averaged_values(cover: Cover, averages: Sequence[_Averages]) -> csr_array:
    """The averages (rows, n_functions) of the values of all functions."""
    from scipy.sparse import block_diag, csr_array  # as above

    from crackgrow.approximation.basis import values_at

    points, elements = (np.concatenate([getattr(a, name) for a in averages]) for name in ("points", "elements"))
    return csr_array(block_diag([a.shares for a in averages], "csr") @ values_at(cover, points, elements))


def _at_point(cover: Cover, support: PointSupport) -> _Averages:
    at = cover.lattice.to_lattice(support.point[None])
    element = locate(cover.lattice, cover.elements, at, body_index(cover.bodies, support.body))
    if element[0] < 0:
        there = place_text(support.point + cover.lattice.map_origin)
        raise GeometryError(f"the support at {there} lies outside of body '{support.body}'")
    first = np.zeros(1, dtype=np.int64)
    return _Averages(1, first, first, np.ones(1), at, element)


def _along_edge(edge: EdgePoints, spacing: float) -> _Averages:
    """Averages weighted with hat functions whose nodes are about one cell apart, as large as cells are there."""
    n_pieces = max(1, int((edge.lengths / edge.sizes).sum() / spacing))
    along = edge.cells - edge.cells.min()
    position = along / along.max() * n_pieces
    left = np.minimum(position.astype(np.int64), n_pieces - 1)
    share = position - left
    rows, points = np.concatenate([left, left + 1]), np.tile(np.arange(len(left)), 2)
    weights = np.concatenate([(1.0 - share) * edge.lengths, share * edge.lengths])
    weights /= np.bincount(rows, weights, minlength=n_pieces + 1)[rows]
    return _Averages(n_pieces + 1, rows, points, weights, edge.points, edge.elements)
