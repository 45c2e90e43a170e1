"""All basis functions at points: MLS functions of the physical patches, and tip functions on the singular ones.

u(x) = sum over physical patches of phi_i (u_i + E_i A_i), paper eqs. (2), (3).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls, mls_values
from crackgrow.approximation.tip_functions import tip_functions, tip_values
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import entries, list_starts
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, polar_beside, side_angle


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
    on = _on_points(cover, elements)
    ids, values, gradients = on.empty(-1, np.int64), on.empty(0.0), on.empty(0.0, np.float64, 2)
    phi, dphi = mls(points - _cells(cover, elements), lattice.support, lattice.reach)
    if cover.crumbs.n:
        rows, linear, slopes = _in_crumbs(cover, points, elements)
        phi[rows, :3], dphi[rows, :3] = linear, slopes
    plain = ids[: lattice.window] = cover.functions[elements].T
    none = plain < 0
    phi = values[: lattice.window] = np.where(none, 0.0, phi.T)
    dphi = gradients[:, : lattice.window] = np.where(none, 0.0, dphi.transpose(2, 1, 0) / lattice.spacing)
    if len(on.pair):
        f, df = np.empty((N_TIP_FUNCTIONS, len(on.pair))), np.empty((2, N_TIP_FUNCTIONS, len(on.pair)))
        for tip, rows, r, t in _polar(cover, points, elements, on):
            value, gradient = tip_functions(tip, r, t)
            f[:, rows], df[:, :, rows] = value.T, gradient.transpose(2, 1, 0)
        df /= lattice.spacing
        w, dw = on.of_patches(phi), [on.of_patches(component) for component in dphi]
        for k in range(N_TIP_FUNCTIONS):
            at, value = on.place_of(k), f[k].take(on.pair_of_patch)
            ids.ravel()[at] = on.first + k
            values.ravel()[at] = w * value
            for component, slope, gradient in zip(dw, df[:, k], gradients, strict=True):
                gradient.ravel()[at] = component * value + w * slope.take(on.pair_of_patch)
    return Basis(ids.T, values.T, gradients.transpose(2, 1, 0))


def values_at(cover: Cover, points: Floats, elements: Ints) -> Values:
    """The values of `basis_at` alone, at a third of the cost."""
    lattice = cover.lattice
    on = _on_points(cover, elements)
    ids, values = on.empty(-1, np.int64), on.empty(0.0)
    phi = mls_values(points - _cells(cover, elements), lattice.support, lattice.reach)
    if cover.crumbs.n:
        rows, linear, _ = _in_crumbs(cover, points, elements)
        phi[rows, :3] = linear
    plain = ids[: lattice.window] = cover.functions[elements].T
    phi = values[: lattice.window] = np.where(plain < 0, 0.0, phi.T)
    if len(on.pair):
        f = np.empty((N_TIP_FUNCTIONS, len(on.pair)))
        for tip, rows, r, t in _polar(cover, points, elements, on):
            f[:, rows] = tip_values(tip, r, t).T
        w = on.of_patches(phi)
        for k in range(N_TIP_FUNCTIONS):
            at = on.place_of(k)
            ids.ravel()[at], values.ravel()[at] = on.first + k, w * f[k].take(on.pair_of_patch)
    return Values(ids.T, values.T)


def functions_on(cover: Cover, elements: Ints) -> tuple[Ints, Ints]:
    """All functions of elements (n,), each once: those of element i are ids[start[i] : start[i + 1]].

    Returns start (n + 1,) and ids.
    """
    enrichment = cover.enrichment
    plain = cover.functions[elements]
    which, pair = enrichment.tips.of(elements)
    pair_of_patch, entry = entries(enrichment.start, pair)
    numbers = enrichment.number[entry, None] + np.arange(N_TIP_FUNCTIONS)
    owner = np.concatenate([np.nonzero(plain >= 0)[0], np.repeat(which[pair_of_patch], N_TIP_FUNCTIONS)])
    ids = np.concatenate([plain[plain >= 0], numbers.ravel()])
    return list_starts(np.sort(owner), len(elements)), ids[np.argsort(owner, kind="stable")]


def _in_crumbs(cover: Cover, points: Floats, elements: Ints) -> tuple[Ints, Floats, Floats]:
    """The points (k,) that lie in crumbs, and the functions there (k, 3) and their gradients (k, 3, 2) per spacing."""
    rows = np.flatnonzero(cover.crumbs.of_element[elements] >= 0)
    return rows, *cover.crumbs.functions(points[rows], cover.crumbs.of_element[elements[rows]])


def _cells(cover: Cover, elements: Ints) -> Ints:
    """Lower left nodes (n, 2) of the cells of elements (n,)."""
    return np.asarray(cover.elements.tile[elements] // (len(cover.lattice.breaks) - 1))


@dataclass(frozen=True, slots=True, eq=False)
class _OnPoints:
    """The enrichment of the elements of n points: pairs of a point and a tip, and each pair's singular patches."""

    n: int
    window: int
    point: Ints  # (q,) of each pair
    pair: Ints  # (q,) number in the cover's enrichment
    pair_of_patch: Ints  # (s,) to which of the q pairs a singular patch belongs
    patch_point: Ints  # (s,)
    place: Ints  # (s,) place among the singular patches of its point
    slot: Ints  # (s,) place in the window
    first: Ints  # (s,) number of the first of its four functions

    def empty(self, missing: float, dtype: DTypeLike = np.float64, *more: int) -> Any:
        """All columns (..., window + 4 k, n) at the points, k the most singular patches that a point has.

        The points run last: what is done with all of them is one long loop.
        """
        n_singular = int(self.place.max(initial=-1)) + 1
        return np.full((*more, self.window + N_TIP_FUNCTIONS * n_singular, self.n), missing, dtype=dtype)

    def of_patches(self, window: Floats) -> Floats:
        """Values (s,) of the singular patches, from those of the window (window, n) at the points."""
        return window.ravel().take(self.slot * self.n + self.patch_point)

    def place_of(self, k: int) -> Ints:
        """Places (s,) of function k of every singular patch in flattened columns."""
        return np.asarray((self.window + N_TIP_FUNCTIONS * self.place + k) * self.n + self.patch_point)


def _on_points(cover: Cover, elements: Ints) -> _OnPoints:
    enrichment = cover.enrichment
    point, pair = enrichment.tips.of(elements)
    pair_of_patch, entry = entries(enrichment.start, pair)
    patch_point = point[pair_of_patch]
    first = enrichment.start[enrichment.tips.start[elements[patch_point]]]
    return _OnPoints(
        len(elements),
        cover.lattice.window,
        point,
        pair,
        pair_of_patch,
        patch_point,
        entry - first,
        enrichment.slot[entry],
        enrichment.number[entry],
    )


def _polar(cover: Cover, points: Floats, elements: Ints, on: _OnPoints) -> Iterator[tuple[Tip, Ints, Floats, Floats]]:
    """Tip by tip: which pairs are its own, and the polar coordinates round it of their points."""
    tips = cover.enrichment.tips.tip[on.pair]
    order = np.argsort(tips, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(tips[order])) + 1):
        tip, at = cover.tips[tips[rows[0]]], on.point[rows]
        element = elements[at]
        first = np.append(True, element[1:] != element[:-1])  # points of an element mostly follow each other
        side = side_angle(tip, cover.elements.reference[element[first]])
        yield tip, rows, *polar_beside(tip, points[at], side[np.cumsum(first) - 1])


def value_matrix(basis: Basis | Values, n_functions: int) -> csr_array:
    """Sparse matrix (n, n_functions) of the values: displacement at the points = matrix @ coefficients."""
    used = basis.ids >= 0
    row_ends = np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    return csr_array((basis.values[used], basis.ids[used], row_ends), shape=(len(used), n_functions))
