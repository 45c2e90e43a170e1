"""Essential conditions by Lagrange multipliers: a point, or linear along an edge (paper eq. (13)).

Each row of the constraint matrix C is a displacement, so that C u = g in metres: at a point the displacement itself,
along an edge the average weighted with the multiplier's hat function.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack

from crackgrow.approximation.basis import basis_at, value_matrix
from crackgrow.case.model import Body, EdgeRegion, EdgeSupport, PointSupport
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.errors import GeometryError
from crackgrow.quadrature.lines import on_edges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

POINTS_PER_EDGE = 6
"""Gauss points on each edge of the arrangement: round-off for the polynomials, 1e-6 for the rest."""


def constraints(
    cover: Cover, bodies: tuple[Body, ...], supports: tuple[PointSupport | EdgeSupport, ...]
) -> tuple[csr_array, Floats]:
    """Constraint matrix C (m, n_dofs) and prescribed displacements g (m,) in metres.

    Raises GeometryError for a support outside of all bodies.
    """
    rows: list[csr_array] = [csr_array((0, cover.n_dofs))]
    given: list[Floats] = []
    for support in supports:
        if isinstance(support, PointSupport):
            values = _at_point(cover, support.point)
        else:
            values = _along_edge(cover, bodies, support.region)
        for component, displacement in enumerate(support.displacement):
            if displacement is not None:
                rows.append(component_matrix(values, component))
                given.append(np.full(values.shape[0], displacement))
    return csr_array(vstack(rows, format="csr")), np.concatenate(given) if given else np.empty(0)


def component_matrix(values: csr_array, component: int) -> csr_array:
    """The matrix (m, n_functions) of a scalar field as one (m, 2 n_functions) of a displacement component."""
    return csr_array(
        (values.data, 2 * values.indices + component, values.indptr), shape=(values.shape[0], 2 * values.shape[1])
    )


def edge_points(cover: Cover, bodies: tuple[Body, ...], region: EdgeRegion) -> tuple[Floats, Floats, Ints, Floats]:
    """Gauss points along a region of an edge.

    Points (n, 2) in lattice coordinates, their lengths (n,) m, elements (n,), arc length (n,) m from the edge's start.
    """
    body_index = next(index for index, body in enumerate(bodies) if body.name == region.body)
    body = bodies[body_index]
    outlines = cover.elements.outlines
    named = np.array([name == region.edge for name in body.edge_names])
    mine = np.flatnonzero((outlines.body == body_index) & named[outlines.segment])
    ends = outlines.points[mine]
    elements = outlines.element[mine]
    corner = int(np.flatnonzero(named)[0])
    start = cover.lattice.to_lattice(body.outline[corner])
    direction = body.outline[(corner + 1) % len(body.outline)] - body.outline[corner]
    axis = int(np.argmax(np.abs(direction)))
    unit = direction / np.hypot(*direction)
    ends, elements = _clipped(cover, ends, elements, region, axis)
    position, weights = on_edges(len(ends), POINTS_PER_EDGE)
    step = ends[:, 1] - ends[:, 0]
    points = (ends[:, None, 0] + position[:, :, None] * step[:, None]).reshape(-1, 2)
    length = (weights * np.hypot(step[:, 0], step[:, 1])[:, None]).ravel() * cover.lattice.spacing
    s = (points - start) @ unit * cover.lattice.spacing
    return points, length, np.repeat(elements, POINTS_PER_EDGE), s


def _clipped(cover: Cover, ends: Floats, elements: Ints, region: EdgeRegion, axis: int) -> tuple[Floats, Ints]:
    """The edges (n, 2, 2) cut off at the region's coordinates along `axis`."""
    low, high = -np.inf, np.inf
    if region.start is not None:
        low = (region.start - cover.lattice.origin[axis]) / cover.lattice.spacing
    if region.end is not None:
        high = (region.end - cover.lattice.origin[axis]) / cover.lattice.spacing
    along = ends[:, :, axis]
    clipped = np.clip(along, low, high)
    span = along[:, 1] - along[:, 0]
    t = (clipped - along[:, :1]) / span[:, None]
    cut = ends[:, :1] + t[:, :, None] * (ends[:, 1:] - ends[:, :1])
    keep = np.abs(clipped[:, 1] - clipped[:, 0]) > 0.0
    return cut[keep], elements[keep]


def _at_point(cover: Cover, point: Floats) -> csr_array:
    at = cover.lattice.to_lattice(point[None])
    element = locate(cover.lattice, cover.elements, at)
    if element[0] < 0:
        raise GeometryError(f"the support at ({point[0]:g}, {point[1]:g}) m lies outside of all bodies")
    return value_matrix(basis_at(cover, at, element), cover.n_functions)


def _along_edge(cover: Cover, bodies: tuple[Body, ...], region: EdgeRegion) -> csr_array:
    """Averages weighted with hat functions whose nodes are about one spacing apart: (nodes, n_functions)."""
    points, length, elements, s = edge_points(cover, bodies, region)
    values = value_matrix(basis_at(cover, points, elements), cover.n_functions)
    total = length.sum()
    n_pieces = max(1, int(total / cover.lattice.spacing))
    position = (s - s.min()) / (s.max() - s.min()) * n_pieces
    hats = np.maximum(0.0, 1.0 - np.abs(position[None] - np.arange(n_pieces + 1)[:, None])) * length
    return csr_array(diags_array(1.0 / hats.sum(axis=1)) @ (csr_array(hats) @ values))
