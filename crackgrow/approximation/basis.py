"""All basis functions at points: MLS functions of the physical patches, and tip functions on the singular ones.

u(x) = sum over physical patches of phi_i (u_i + E_i A_i), paper eqs. (2), (3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS, tip_angle

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Functions at n points: column k of row i belongs to function ids[i, k], -1 where the row is shorter."""

    ids: Ints  # (n, k)
    values: Floats  # (n, k)
    gradients: Floats  # (n, k, 2) per metre


def basis_at(cover: Cover, points: Floats, elements: Ints) -> Basis:
    """Functions at points (n, 2), in lattice coordinates, each inside or on the rim of its element (n,)."""
    lattice = cover.lattice
    cell = cover.elements.tile[elements] // (len(lattice.breaks) - 1)
    phi, dphi = mls(points - cell, lattice.support, lattice.reach)
    ids = cover.functions[elements]
    phi = np.where(ids >= 0, phi, 0.0)
    dphi = np.where(ids[:, :, None] >= 0, dphi, 0.0)
    blocks = [(ids, phi, dphi)]
    for tip, first in zip(cover.tips, cover.tip_function_ids, strict=True):
        enriched = np.where(ids >= 0, first[ids], -1)
        rows = np.flatnonzero((enriched >= 0).any(axis=1))
        if len(rows):
            blocks.append(_enriched(cover, tip, rows, enriched, points, elements, phi, dphi))
    return Basis(
        np.concatenate([block[0] for block in blocks], axis=1),
        np.concatenate([block[1] for block in blocks], axis=1),
        np.concatenate([block[2] for block in blocks], axis=1) / lattice.spacing,
    )


def _enriched(cover, tip, rows, enriched, points, elements, phi, dphi):  # type: ignore[no-untyped-def]
    """Products of MLS and tip functions in all rows, in as many columns as the longest row needs."""
    n = len(points)
    count = (enriched[rows] >= 0).sum(axis=1)
    slots = np.argsort(enriched[rows] < 0, axis=1, kind="stable")[:, : int(count.max())]
    first = np.take_along_axis(enriched[rows], slots, axis=1)
    w = np.where(first >= 0, np.take_along_axis(phi[rows], slots, axis=1), 0.0)
    dw = np.where(first[:, :, None] >= 0, np.take_along_axis(dphi[rows], slots[:, :, None], axis=1), 0.0)
    r, t = tip_angle(tip, points[rows], cover.elements.reference[elements[rows]])
    f, df = tip_functions(tip, r, t)
    numbers = np.arange(N_TIP_FUNCTIONS)
    ids = np.where(first[:, :, None] >= 0, first[:, :, None] + numbers, -1).reshape(len(rows), -1)
    values = (w[:, :, None] * f[:, None, :]).reshape(len(rows), -1)
    gradients = (dw[:, :, None, :] * f[:, None, :, None] + w[:, :, None, None] * df[:, None, :, :]).reshape(
        len(rows), -1, 2
    )
    all_ids = np.full((n, ids.shape[1]), -1, dtype=np.int64)
    all_values = np.zeros((n, ids.shape[1]))
    all_gradients = np.zeros((n, ids.shape[1], 2))
    all_ids[rows], all_values[rows], all_gradients[rows] = ids, values, gradients
    return all_ids, all_values, all_gradients


def value_matrix(basis: Basis, n_functions: int) -> csr_array:
    """Sparse matrix (n, n_functions) of the values: displacement at the points = matrix @ coefficients."""
    return _matrix(basis.ids, basis.values, n_functions)


def gradient_matrices(basis: Basis, n_functions: int) -> tuple[csr_array, csr_array]:
    """Sparse matrices (n, n_functions) of the derivatives by x and by y, per metre."""
    return tuple(_matrix(basis.ids, basis.gradients[:, :, axis], n_functions) for axis in range(2))  # type: ignore[return-value]


def _matrix(ids: Ints, entries: Floats, n_functions: int) -> csr_array:
    used = ids >= 0
    row_ends = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return csr_array((entries[used], ids[used], row_ends), shape=(len(ids), n_functions))
