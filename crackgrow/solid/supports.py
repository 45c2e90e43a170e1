"""Essential conditions by Lagrange multipliers: a point, or linear along an edge (paper eq. (13)).

Each row of the constraint matrix C is a displacement, so that C u = g in metres: at a point the displacement itself,
along an edge the average weighted with the multiplier's hat function.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack

from crackgrow.approximation.basis import value_matrix, values_at
from crackgrow.case.model import Body, Component, ContactSupport, EdgeRegion, PointSupport, Support
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.cover.face_edges import edges_of_region
from crackgrow.errors import GeometryError
from crackgrow.quadrature.rims import points_on_outlines

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Constraints:
    """Linear conditions C u = g on the displacement."""

    matrix: csr_array  # (m, n_dofs) C
    given: Floats  # (m,) m, g
    support: Ints  # (m,) number of the support that a row belongs to, -1 for none
    component: Ints  # (m,) 0: x, 1: y


def constraints(cover: Cover, bodies: Sequence[Body], supports: Sequence[Support]) -> Constraints:
    """The conditions of all supports; contact supports have none.

    Raises GeometryError for a support outside of its body.
    """
    rows: list[csr_array] = [csr_array((0, cover.n_dofs))]
    given: list[Floats] = [np.empty(0)]
    owner: list[Ints] = [np.empty(0, dtype=np.int64)]
    components: list[Ints] = [np.empty(0, dtype=np.int64)]
    for number, support in enumerate(supports):
        if isinstance(support, ContactSupport):
            continue
        if isinstance(support, PointSupport):
            average, points, elements = _at_point(cover, bodies, support)
        else:
            average, points, elements = _along_edge(cover, bodies, support.region)
        values = csr_array(average @ value_matrix(values_at(cover, points, elements), cover.n_functions))
        places = cover.lattice.to_metres(points)
        for component, displacement in enumerate(support.displacement):
            if displacement is not None:
                rows.append(component_matrix(values, component))
                given.append(prescribed(displacement, average, places))
                owner.append(np.full(len(given[-1]), number))
                components.append(np.full(len(given[-1]), component))
    return Constraints(
        csr_array(vstack(rows, format="csr")), np.concatenate(given), np.concatenate(owner), np.concatenate(components)
    )


def tied(constraints: Constraints, rows: csr_array) -> Constraints:
    """The constraints with further `rows` (k, n_dofs) that are held at zero."""
    n = rows.shape[0]
    none = np.full(n, -1)
    return Constraints(
        csr_array(vstack([constraints.matrix, rows], format="csr")),
        np.concatenate([constraints.given, np.zeros(n)]),
        np.concatenate([constraints.support, none]),
        np.concatenate([constraints.component, none]),
    )


def prescribed(displacement: Component, average: csr_array, points: Floats) -> Floats:
    """Averages (m,) m of a prescribed displacement, from its values at points (n, 2) m by `average` (m, n)."""
    if callable(displacement):
        return np.asarray(average @ displacement(points))
    return np.full(average.shape[0], displacement)


def component_matrix(values: csr_array, component: int) -> csr_array:
    """The matrix (m, n_functions) of a scalar field as one (m, 2 n_functions) of a displacement component."""
    return csr_array(
        (values.data, 2 * values.indices + component, values.indptr), shape=(values.shape[0], 2 * values.shape[1])
    )


def edge_points(cover: Cover, bodies: Sequence[Body], region: EdgeRegion) -> tuple[Floats, Floats, Ints, Floats]:
    """Gauss points along a region of an edge.

    Points (n, 2) in lattice coordinates, their lengths (n,) m, elements (n,), arc length (n,) m from the part's start.
    """
    body = body_index(bodies, region.body)
    sides = cover.bodies[body].sides
    edges = edges_of_region(cover.elements.outlines, body, sides, region.sides, region.limits)
    edge, points, length = points_on_outlines(cover, edges.points, edges.plus, edges.edge)
    s = edges.s[edge, 0] + np.hypot(*(points - edges.points[edge, 0]).T)
    return points, length * cover.lattice.spacing, edges.plus[edge], s * cover.lattice.spacing


def body_index(bodies: Sequence[Body], name: str) -> int:
    """Number of the body of that name."""
    return next(index for index, body in enumerate(bodies) if body.name == name)


_Averages = tuple[csr_array, Floats, Ints]  # averages (rows, n) of values at points (n, 2) in elements (n,)


def _at_point(cover: Cover, bodies: Sequence[Body], support: PointSupport) -> _Averages:
    at = cover.lattice.to_lattice(support.point[None])
    element = locate(cover.lattice, cover.elements, at, body_index(bodies, support.body))
    if element[0] < 0:
        x, y = support.point
        raise GeometryError(f"the support at ({x:g}, {y:g}) m lies outside of body '{support.body}'")
    return csr_array(np.ones((1, 1))), at, element


def _along_edge(cover: Cover, bodies: Sequence[Body], region: EdgeRegion) -> _Averages:
    """Averages weighted with hat functions whose nodes are about one spacing apart."""
    points, length, elements, s = edge_points(cover, bodies, region)
    n_pieces = max(1, int(length.sum() / cover.lattice.spacing))
    position = (s - s.min()) / (s.max() - s.min()) * n_pieces
    hats = np.maximum(0.0, 1.0 - np.abs(position[None] - np.arange(n_pieces + 1)[:, None])) * length
    return csr_array(diags_array(1.0 / hats.sum(axis=1)) @ csr_array(hats)), points, elements
