"""Stress fitted by a quadratic polynomial on every physical patch: nothing is averaged across a crack.

The fit P_i of patch i minimises the integral of phi_i |P_i - s|^2 for a field s, phi_i the patch's function of the
partition of unity. Elements whose points lie alike in their cells share the monomials and the moments.

Arrays inside run over the points last, so that every operation is one long loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from crackgrow.arrays import Floats, Ints

N_MONOMIALS = 6
"""1, x, y, x^2, x y, y^2."""

RIDGE = 1e-12
"""Added to the normalised moments: slivers of rock do not see all of the polynomial."""


@dataclass(frozen=True, slots=True, eq=False)
class RegularSamples:
    """Points at the same places in the cells of many elements."""

    elements: Ints  # (e,)
    patches: Ints  # (e, window), each at most once in a column; the number of patches where there is none
    distance: Floats  # (q, window, 2) from the nodes to the points, spacings
    weights: Floats  # (q, window) area, in squared spacings, times phi_i
    values: Floats  # (q, e, 3)


@dataclass(frozen=True, slots=True, eq=False)
class FreeSamples:
    """Points anywhere, whose values may differ from patch to patch: all columns but one of a window of patches."""

    elements: Ints  # (n,)
    patches: Ints  # (n, window)
    nodes: Floats  # (n_patches + 1, 2)
    points: Floats  # (n, 2)
    weights: Floats  # (n, window)
    common: Floats  # (n, 3) values, less, patch by patch,
    start: Ints  # (n + 1,) at point i, from start[i] to start[i + 1],
    parts: Floats  # (m, 3) these parts,
    acting: NDArray[np.bool_]  # (m, window) in these patches

    def column(self, slot: int) -> tuple[Floats, Floats]:
        """Monomials (6, n) and values (3, n) of one column of patches."""
        n, m = len(self.common), len(self.parts)
        acting = csr_array((self.acting[:, slot].astype(float), np.arange(m), self.start), shape=(n, m))
        values = self.common - acting @ self.parts
        return monomials(self.points - self.nodes.take(self.patches[:, slot], axis=0)), values.T


def monomials(d: Floats) -> Floats:
    """1, x, y, x^2, x y, y^2 (6, n) of d (n, 2)."""
    x, y = d.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def fit(n_patches: int, regular: list[RegularSamples], free: list[FreeSamples]) -> Floats:
    """Coefficients (n_patches + 1, 6, 3) of the polynomials, round each patch's node; the last serves no patch."""
    sums = np.zeros((n_patches + 1, N_MONOMIALS, N_MONOMIALS + 3))  # of monomials times monomials, then times values
    for some in regular:
        q, e, _ = some.values.shape
        of_elements = np.empty((e, *sums.shape[1:]))
        for slot, patch in enumerate(some.patches.T):
            p = monomials(some.distance[:, slot])
            weighted = p * some.weights[:, slot]
            of_elements[..., :N_MONOMIALS] = weighted @ p.T
            by_values = weighted @ some.values.reshape(q, 3 * e)
            of_elements[..., N_MONOMIALS:] = by_values.reshape(-1, e, 3).transpose(1, 0, 2)
            sums[patch] += of_elements
    number = np.zeros(n_patches + 1, dtype=np.int64)
    for block in free:
        n, seen = len(block.elements), np.flatnonzero(np.bincount(block.patches.ravel()))
        number[seen] = np.arange(len(seen))
        of_block = sums[seen]
        for slot, patch in enumerate(block.patches.T):
            p, values = block.column(slot)
            products = p[:, None] * np.concatenate([p, values])
            gather = csc_array((block.weights[:, slot], number[patch], np.arange(n + 1)), shape=(len(seen), n))
            of_block += (gather @ products.reshape(-1, n).T).reshape(of_block.shape)
        sums[seen] = of_block
    return _solved(sums[..., :N_MONOMIALS], sums[..., N_MONOMIALS:])


def misfits(coefficients: Floats, regular: list[RegularSamples], free: list[FreeSamples], n_elements: int) -> Floats:
    """The integrals of sum_i phi_i |P_i - s|^2 over each element (n_elements,), in squared spacings."""
    found = np.zeros(n_elements)
    for some in regular:
        for slot, patch in enumerate(some.patches.T):
            own = coefficients[patch].transpose(1, 0, 2).reshape(N_MONOMIALS, -1)
            fitted = monomials(some.distance[:, slot]).T @ own
            squares = np.sum((fitted.reshape(some.values.shape) - some.values) ** 2, axis=2)
            found[some.elements] += some.weights[:, slot] @ squares
    by_patch = np.ascontiguousarray(coefficients.transpose(1, 2, 0))
    for block in free:
        for slot, patch in enumerate(block.patches.T):
            p, values = block.column(slot)
            fitted = np.sum(p[:, None] * by_patch.take(patch, axis=2), axis=0)
            squares = np.sum((fitted - values) ** 2, axis=0)
            found += np.bincount(block.elements, block.weights[:, slot] * squares, n_elements)
    return found


def _solved(moments: Floats, right: Floats) -> Floats:
    size = np.sqrt(np.einsum("nii->ni", moments))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    normal = moments * scale[:, :, None] * scale[:, None, :] + RIDGE * np.eye(N_MONOMIALS)
    return np.asarray(np.linalg.solve(normal, right * scale[:, :, None]) * scale[:, :, None])
