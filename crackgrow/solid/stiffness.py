"""Assembly of the stiffness matrix.

All whole tiles without tip functions share the gradients at their quadrature points, hence one element matrix per
material (and per kind of tile). The others are integrated one by one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from crackgrow.approximation.basis import basis_at
from crackgrow.approximation.mls import mls
from crackgrow.cover.cover import Cover
from crackgrow.quadrature.elements import ElementPoints, element_points, enriched_elements, plain_elements
from crackgrow.quadrature.rules import square
from crackgrow.solid.elasticity import PlaneElasticity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Block = tuple[Ints, Ints, Floats]  # rows, columns, entries


def stiffness(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> csc_array:
    """Stiffness K (n_dofs, n_dofs) in Pa, per metre of thickness, with `n` Gauss points per direction.

    `materials` are one per body.
    """
    blocks = _plain(cover, materials, n) + _cut(cover, materials, element_points(cover, n))
    row, column, entry = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return csc_array((entry, (row, column)), shape=(cover.n_dofs, cover.n_dofs))


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


def _plain(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> list[Block]:
    """The element matrix of every kind of whole tile, once per body and at all of its places."""
    lattice = cover.lattice
    elements = np.flatnonzero(plain_elements(cover))
    local, weights = square(n)
    per_cell = len(lattice.breaks) - 1
    part = cover.elements.tile[elements] % per_cell
    sizes = np.diff(lattice.breaks)
    blocks = []
    for i, j in np.unique(part, axis=0):
        at = lattice.breaks[[i, j]] + local * sizes[[i, j]]
        _, gradients = mls(at, lattice.support, lattice.reach)
        same_kind = np.all(part == (i, j), axis=1)
        for body, material in enumerate(materials):
            mine = elements[same_kind & (cover.elements.body[elements] == body)]
            if not len(mine):
                continue
            covers = cover.functions[mine[0]] >= 0  # the same for all tiles of a kind
            ids = cover.functions[mine][:, covers]
            matrix = element_matrix(material, gradients[:, covers], weights * sizes[i] * sizes[j])
            blocks.append(_scattered(ids, np.broadcast_to(matrix, (len(mine), *matrix.shape))))
    return blocks


def _cut(cover: Cover, materials: Sequence[PlaneElasticity], points: ElementPoints) -> list[Block]:
    """Element matrices one by one; elements with the same tip functions share the evaluation of the basis."""
    area = points.weights * cover.lattice.spacing**2
    pattern = (1 << np.arange(len(cover.tips))) @ enriched_elements(cover)[:, points.element]
    blocks = []
    for kind in np.unique(pattern):
        chosen = np.flatnonzero(pattern == kind)
        element, weights = points.element[chosen], area[chosen]
        basis = basis_at(cover, points.points[chosen], element)
        starts = np.flatnonzero(np.diff(element, prepend=-1))
        for start, end in zip(starts, np.append(starts[1:], len(element)), strict=True):
            used = basis.ids[start] >= 0
            gradients = basis.gradients[start:end] if used.all() else basis.gradients[start:end, used]
            matrix = element_matrix(materials[cover.elements.body[element[start]]], gradients, weights[start:end])
            blocks.append(_scattered(basis.ids[start, used][None], matrix[None]))
    return blocks


def _scattered(ids: Ints, matrices: Floats) -> Block:
    """Rows, columns and entries of element matrices (m, k, 2, k, 2) for functions ids (m, k)."""
    dofs = 2 * ids[:, :, None] + np.arange(2)
    shape = matrices.shape
    row = np.broadcast_to(dofs[:, :, :, None, None], shape)
    column = np.broadcast_to(dofs[:, None, None, :, :], shape)
    return row.ravel(), column.ravel(), matrices.ravel()
