"""Assembly of the stiffness matrix.

All plain elements of one shape, at the same place of their cell, share the gradients at their quadrature points, hence
one element matrix per material. The others are integrated one by one.

The gradients are corrected so that those of every element satisfy the divergence theorem at its quadrature points: the
linear patch test then passes at round-off whatever the rules, and the matrix stays symmetric (after Chen et al. 2001,
who smooth the gradients over nodal cells; here their deviation from the mean over an element is kept).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from crackgrow.approximation.basis import basis_at, functions_on, values_at
from crackgrow.approximation.mls import mls, mls_values
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import entries, list_starts
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.quadrature.elements import ElementPoints, element_points, plain_kinds
from crackgrow.quadrature.rims import rectangle_rim, rim_points
from crackgrow.quadrature.rules import square
from crackgrow.solid.assembly import MatrixSum
from crackgrow.solid.elasticity import PlaneElasticity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Block = tuple[Ints, Ints, Floats]  # rows, columns, entries

BATCH = 500000
"""Values of functions at points that are held at once."""


def stiffness(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> csc_array:
    """Stiffness K (n_dofs, n_dofs) in Pa, per metre of thickness, with `n` Gauss points per direction.

    `materials` are one per body.
    """
    return csc_array(_plain(cover, materials, n) + _cut(cover, materials, element_points(cover, n)))


def element_matrix(material: PlaneElasticity, gradients: Floats, weights: Floats) -> Floats:
    """Integral of B' D B (k, 2, k, 2) from gradients (n, k, 2) and weights (n,): function, component, twice."""
    gx, gy = gradients[:, :, 0], gradients[:, :, 1]
    wx, wy = (gx * weights[:, None]).T, (gy * weights[:, None]).T
    xx, xy, yy = wx @ gx, wx @ gy, wy @ gy
    k = gradients.shape[1]
    matrix = np.empty((k, 2, k, 2))
    matrix[:, 0, :, 0] = material.c11 * xx + material.c33 * yy
    matrix[:, 1, :, 1] = material.c11 * yy + material.c33 * xx
    matrix[:, 0, :, 1] = material.c12 * xy + material.c33 * xy.T
    matrix[:, 1, :, 0] = matrix[:, 0, :, 1].T
    return matrix


def consistent(gradients: Floats, weights: Floats, rim_values: Floats, normals: Floats) -> Floats:
    """Gradients (n, k, 2) of k functions at quadrature points with weights (n,), shifted by a constant per function.

    Their integral then equals that of phi n along the rim, given by values (m, k) and normals times lengths (m, 2).
    """
    integral = (weights @ gradients.reshape(len(weights), -1)).reshape(-1, 2)
    return np.asarray(gradients + (rim_values.T @ normals - integral) / weights.sum())


def _plain(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> csc_array:
    """The element matrix of every kind of plain element, once and at all of its places."""
    lattice = cover.lattice
    local, weights = square(n)
    blocks: list[Block] = [_scattered(np.empty((0, 1), dtype=np.int64), np.empty((0, 1, 2, 1, 2)))]
    for kind in plain_kinds(cover):
        area = weights * kind.size.prod()
        _, gradients = mls(kind.low + local * kind.size, lattice.support, lattice.reach)
        rim, normals = rectangle_rim(kind.low, kind.size)
        gradients = consistent(gradients, area, mls_values(rim, lattice.support, lattice.reach), normals)
        matrix = element_matrix(materials[kind.body], gradients[:, kind.covers], area)
        ids = cover.functions[kind.elements][:, kind.covers]
        blocks.append(_scattered(ids, np.broadcast_to(matrix, (len(ids), *matrix.shape))))
    row, column, entry = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return csc_array((entry, (row, column)), shape=(cover.n_dofs, cover.n_dofs))


def _cut(cover: Cover, materials: Sequence[PlaneElasticity], points: ElementPoints) -> csc_array:
    """Element matrices one by one; elements with about as many functions share the evaluation of the basis."""
    area = points.weights * cover.lattice.spacing**2
    rim = rim_points(cover)
    normals = rim.normals * cover.lattice.spacing
    inside, outside = (list_starts(element, cover.elements.n) for element in (points.element, rim.element))
    total = MatrixSum(*functions_on(cover, np.flatnonzero(np.diff(inside))), cover.n_functions)
    for batch in _batches(cover, np.diff(inside)):
        (_, at), (_, on) = entries(inside, batch), entries(outside, batch)
        basis = basis_at(cover, points.points[at], points.element[at])
        values = values_at(cover, rim.points[on], rim.element[on]).values
        weights, outward = area[at], normals[on]
        ends, rim_ends = (np.append(0, np.cumsum(np.diff(start)[batch])) for start in (inside, outside))
        for element, start, end, first, last in zip(
            batch, ends[:-1], ends[1:], rim_ends[:-1], rim_ends[1:], strict=True
        ):
            used = basis.ids[start] >= 0
            gradients = basis.gradients[start:end, used]
            gradients = consistent(gradients, weights[start:end], values[first:last, used], outward[first:last])
            material = materials[cover.elements.body[element]]
            total.add(basis.ids[start, used], element_matrix(material, gradients, weights[start:end]))
    return total.matrix()


def _batches(cover: Cover, n_points: Ints) -> list[Ints]:
    """The elements with points, `n_points` (elements,), in batches of similar numbers of functions."""
    elements = np.flatnonzero(n_points)
    elements = elements[np.argsort(cover.enrichment.n_patches[elements], kind="stable")]
    n_columns = cover.lattice.window + N_TIP_FUNCTIONS * cover.enrichment.n_patches[elements]
    batch = np.cumsum(n_points[elements] * n_columns) // BATCH
    return np.split(elements, np.flatnonzero(np.diff(batch)) + 1) if len(elements) else []


def _scattered(ids: Ints, matrices: Floats) -> Block:
    """Rows, columns and entries of element matrices (m, k, 2, k, 2) for functions ids (m, k)."""
    dofs = 2 * ids[:, :, None] + np.arange(2)
    shape = matrices.shape
    row = np.broadcast_to(dofs[:, :, :, None, None], shape)
    column = np.broadcast_to(dofs[:, None, None, :, :], shape)
    return row.ravel(), column.ravel(), matrices.ravel()
