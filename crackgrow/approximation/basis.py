"""All basis functions at points: MLS functions of the physical patches, and tip functions on the singular ones.

u(x) = sum over physical patches of phi_i (u_i + E_i A_i), paper eqs. (2), (3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls, mls_values
from crackgrow.approximation.tip_functions import tip_functions, tip_values
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import entries
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, tip_angle

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_Number = TypeVar("_Number", np.int64, np.float64)


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
    """Functions at points (n, 2), in lattice coordinates, each inside or on the rim of its element (n,).

    The columns are the window's nodes, then the tip functions that the element carries, four by four. They are the same
    for all points of an element, and as many as the element that carries most needs.
    """
    lattice = cover.lattice
    phi, dphi = mls(points - _cells(cover, elements), lattice.support, lattice.reach)
    ids = cover.functions[elements]
    phi = np.where(ids >= 0, phi, 0.0)
    dphi = np.where(ids[:, :, None] >= 0, dphi, 0.0)
    on = _on_points(cover, elements)
    if len(on.pair):
        f, df = np.empty((len(on.pair), N_TIP_FUNCTIONS)), np.empty((len(on.pair), N_TIP_FUNCTIONS, 2))
        for tip, rows, r, t in _polar(cover, points, elements, on):
            f[rows], df[rows] = tip_functions(tip, r, t)
        w, dw = phi[on.patch_point, on.slot, None], dphi[on.patch_point, on.slot, None]
        gradients = dw * f[on.pair_of_patch, :, None] + w[:, :, None] * df[on.pair_of_patch]
        ids, phi, dphi = (
            np.concatenate([ids, on.columns(on.numbers, -1)], axis=1),
            np.concatenate([phi, on.columns(w * f[on.pair_of_patch], 0.0)], axis=1),
            np.concatenate([dphi, on.columns(gradients, 0.0)], axis=1),
        )
    return Basis(ids, phi, dphi / lattice.spacing)


def values_at(cover: Cover, points: Floats, elements: Ints) -> Values:
    """The values of `basis_at` alone, at a third of the cost."""
    lattice = cover.lattice
    ids = cover.functions[elements]
    phi = np.where(ids >= 0, mls_values(points - _cells(cover, elements), lattice.support, lattice.reach), 0.0)
    on = _on_points(cover, elements)
    if len(on.pair):
        f = np.empty((len(on.pair), N_TIP_FUNCTIONS))
        for tip, rows, r, t in _polar(cover, points, elements, on):
            f[rows] = tip_values(tip, r, t)
        products = phi[on.patch_point, on.slot, None] * f[on.pair_of_patch]
        ids = np.concatenate([ids, on.columns(on.numbers, -1)], axis=1)
        phi = np.concatenate([phi, on.columns(products, 0.0)], axis=1)
    return Values(ids, phi)


def _cells(cover: Cover, elements: Ints) -> Ints:
    """Lower left nodes (n, 2) of the cells of elements (n,)."""
    return np.asarray(cover.elements.tile[elements] // (len(cover.lattice.breaks) - 1))


@dataclass(frozen=True, slots=True, eq=False)
class _OnPoints:
    """The enrichment of the elements of n points: pairs of a point and a tip, and each pair's singular patches."""

    n: int
    point: Ints  # (q,) of each pair
    pair: Ints  # (q,) number in the cover's enrichment
    pair_of_patch: Ints  # (s,) to which of the q pairs a singular patch belongs
    patch_point: Ints  # (s,)
    place: Ints  # (s,) place among the singular patches of its point
    slot: Ints  # (s,) place in the window
    numbers: Ints  # (s, 4) of the functions

    def columns(self, values: NDArray[_Number], missing: float) -> NDArray[_Number]:
        """Values (s, 4, ...) as columns (n, 4 k, ...) of the points, k the most singular patches that a point has."""
        longest = int(self.place.max(initial=-1)) + 1
        table = np.full((self.n, longest, *values.shape[1:]), missing, dtype=values.dtype)
        table[self.patch_point, self.place] = values
        return table.reshape(self.n, longest * N_TIP_FUNCTIONS, *values.shape[2:])


def _on_points(cover: Cover, elements: Ints) -> _OnPoints:
    enrichment = cover.enrichment
    point, pair = enrichment.tips.of(elements)
    pair_of_patch, entry = entries(enrichment.start, pair)
    patch_point = point[pair_of_patch]
    first = enrichment.start[enrichment.tips.start[elements[patch_point]]]
    numbers = enrichment.number[entry, None] + np.arange(N_TIP_FUNCTIONS)
    return _OnPoints(
        len(elements), point, pair, pair_of_patch, patch_point, entry - first, enrichment.slot[entry], numbers
    )


def _polar(cover: Cover, points: Floats, elements: Ints, on: _OnPoints) -> Iterator[tuple[Tip, Ints, Floats, Floats]]:
    """Tip by tip: which pairs are its own, and the polar coordinates round it of their points."""
    tips = cover.enrichment.tips.tip[on.pair]
    order = np.argsort(tips, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(tips[order])) + 1):
        tip, at = cover.tips[tips[rows[0]]], on.point[rows]
        yield tip, rows, *tip_angle(tip, points[at], cover.elements.reference[elements[at]])


def value_matrix(basis: Basis | Values, n_functions: int) -> csr_array:
    """Sparse matrix (n, n_functions) of the values: displacement at the points = matrix @ coefficients."""
    used = basis.ids >= 0
    row_ends = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return csr_array((basis.values[used], basis.ids[used], row_ends), shape=(len(used), n_functions))
