"""All basis functions at points: MLS functions of the physical patches, and tip functions on the singular ones.

u(x) = sum over physical patches of phi_i (u_i + E_i A_i), paper eqs. (2), (3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls, mls_values
from crackgrow.approximation.tip_functions import tip_functions, tip_values
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, tip_angle

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_Columns = tuple[Ints, Floats, Floats]  # ids (n, k), values (n, k), gradients (n, k, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """Functions at n points: column k of row i belongs to function ids[i, k], -1 where the row is shorter."""

    ids: Ints  # (n, k)
    values: Floats  # (n, k)
    gradients: Floats  # (n, k, 2) per metre


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """The values of a `Basis` alone, in the same columns."""

    ids: Ints  # (n, k)
    values: Floats  # (n, k)


def basis_at(cover: Cover, points: Floats, elements: Ints) -> Basis:
    """Functions at points (n, 2), in lattice coordinates, each inside or on the rim of its element (n,)."""
    lattice = cover.lattice
    phi, dphi = mls(points - _cells(cover, elements), lattice.support, lattice.reach)
    ids = cover.functions[elements]
    phi = np.where(ids >= 0, phi, 0.0)
    dphi = np.where(ids[:, :, None] >= 0, dphi, 0.0)
    blocks = [(ids, phi, dphi)]
    for tip, first in zip(cover.tips, cover.tip_function_ids, strict=True):
        enriched = np.where(ids >= 0, first[ids], -1)
        rows = np.flatnonzero((enriched >= 0).any(axis=1))
        if len(rows):
            reference = cover.elements.reference[elements[rows]]
            products = _products(tip, points[rows], reference, enriched[rows], phi[rows], dphi[rows])
            blocks.append(_spread(products, rows, len(points)))
    return Basis(
        np.concatenate([block[0] for block in blocks], axis=1),
        np.concatenate([block[1] for block in blocks], axis=1),
        np.concatenate([block[2] for block in blocks], axis=1) / lattice.spacing,
    )


def values_at(cover: Cover, points: Floats, elements: Ints) -> Values:
    """The values of `basis_at` alone, at a third of the cost."""
    lattice = cover.lattice
    ids = cover.functions[elements]
    phi = np.where(ids >= 0, mls_values(points - _cells(cover, elements), lattice.support, lattice.reach), 0.0)
    blocks = [(ids, phi)]
    for tip, first in zip(cover.tips, cover.tip_function_ids, strict=True):
        enriched = np.where(ids >= 0, first[ids], -1)
        rows = np.flatnonzero((enriched >= 0).any(axis=1))
        if len(rows):
            slots, numbers = _singular_slots(enriched[rows])
            w = np.where(numbers[:, ::N_TIP_FUNCTIONS] >= 0, np.take_along_axis(phi[rows], slots, axis=1), 0.0)
            reference = cover.elements.reference[elements[rows]]
            f = tip_values(tip, *tip_angle(tip, points[rows], reference))
            found = np.full((len(points), numbers.shape[1]), -1), np.zeros((len(points), numbers.shape[1]))
            found[0][rows], found[1][rows] = numbers, (w[:, :, None] * f[:, None, :]).reshape(len(rows), -1)
            blocks.append(found)
    return Values(*(np.concatenate(columns, axis=1) for columns in zip(*blocks, strict=True)))


def _cells(cover: Cover, elements: Ints) -> Ints:
    """Lower left nodes (n, 2) of the cells of elements (n,)."""
    return np.asarray(cover.elements.tile[elements] // (len(cover.lattice.breaks) - 1))


def _singular_slots(first: Ints) -> tuple[Ints, Ints]:
    """The columns (n, m) of `first` (n, w) that number fours of tip functions, and all their numbers (n, 4 m).

    -1 in the numbers stands for none.
    """
    longest = int((first >= 0).sum(axis=1).max())
    slots = np.argsort(first < 0, axis=1, kind="stable")[:, :longest]
    first = np.take_along_axis(first, slots, axis=1)[:, :, None]
    numbers = np.where(first >= 0, first + np.arange(N_TIP_FUNCTIONS), -1)
    return slots, numbers.reshape(len(numbers), -1)


def _products(tip: Tip, points: Floats, reference: Floats, first: Ints, phi: Floats, dphi: Floats) -> _Columns:
    """Products of MLS functions phi (n, w) and tip functions; `first` (n, w) numbers their fours, -1 for none."""
    n = len(points)
    slots, ids = _singular_slots(first)
    first = ids[:, ::N_TIP_FUNCTIONS]
    w = np.where(first >= 0, np.take_along_axis(phi, slots, axis=1), 0.0)
    dw = np.where(first[:, :, None] >= 0, np.take_along_axis(dphi, slots[:, :, None], axis=1), 0.0)
    f, df = tip_functions(tip, *tip_angle(tip, points, reference))
    values = w[:, :, None] * f[:, None, :]
    gradients = dw[:, :, None, :] * f[:, None, :, None] + w[:, :, None, None] * df[:, None, :, :]
    return ids, values.reshape(n, -1), gradients.reshape(n, -1, 2)


def _spread(columns: _Columns, rows: Ints, n: int) -> _Columns:
    """Columns for the points `rows` only as columns for all n points."""
    if len(rows) == n:
        return columns
    k = columns[0].shape[1]
    ids, values, gradients = np.full((n, k), -1, dtype=np.int64), np.zeros((n, k)), np.zeros((n, k, 2))
    ids[rows], values[rows], gradients[rows] = columns
    return ids, values, gradients


def value_matrix(basis: Basis | Values, n_functions: int) -> csr_array:
    """Sparse matrix (n, n_functions) of the values: displacement at the points = matrix @ coefficients."""
    used = basis.ids >= 0
    row_ends = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return csr_array((basis.values[used], basis.ids[used], row_ends), shape=(len(used), n_functions))
