"""Stress fitted by a quadratic polynomial on every physical patch: nothing is averaged across a crack.

The fit P_i of patch i minimises the integral of phi_i |P_i - s|^2 for a field s, phi_i the patch's function of the
partition of unity. Arrays inside run over the points last, so that every operation is one long loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from crackgrow.arrays import Floats, Ints

N_MONOMIALS = 6
"""1, x, y, x^2, x y, y^2."""

RIDGE = 1e-12
"""Added to the normalised moments: slivers of rock do not see all of the polynomial."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Pairs of a point anywhere and a patch over it; values may differ from patch to patch."""

    elements: Ints  # (p,)
    patches: Ints  # (p,)
    distance: Floats  # (p, 2) from the node to the point, in the largest cells at the node
    weights: Floats  # (p,) area, in squared spacings, times phi_i
    values: Floats  # (p, 3)


def monomials(d: Floats) -> Floats:
    """1, x, y, x^2, x y, y^2 (6, n) of d (n, 2)."""
    x, y = d.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def fit(n_patches: int, samples: list[Samples]) -> Floats:
    """Coefficients (n_patches, 6, 3) of the polynomials, round each patch's node."""
    sums = np.zeros((n_patches, N_MONOMIALS, N_MONOMIALS + 3))  # of monomials times monomials, then times values
    number = np.zeros(n_patches, dtype=np.int64)
    for block in samples:
        seen = np.flatnonzero(np.bincount(block.patches, minlength=n_patches))
        number[seen] = np.arange(len(seen))
        n, p = len(block.patches), np.ascontiguousarray(monomials(block.distance).T)
        products = p[:, :, None] * np.column_stack([p, block.values])[:, None]  # pair by pair, as they are gathered
        gather = csc_array((block.weights, number[block.patches], np.arange(n + 1)), shape=(len(seen), n))
        sums[seen] += (gather @ products.reshape(n, -1)).reshape(len(seen), *sums.shape[1:])
    return _solved(sums[..., :N_MONOMIALS], sums[..., N_MONOMIALS:])


def misfits(coefficients: Floats, samples: list[Samples], n_elements: int) -> Floats:
    """The integrals of sum_i phi_i |P_i - s|^2 over each element (n_elements,), in squared spacings."""
    found = np.zeros(n_elements)
    by_patch = np.ascontiguousarray(coefficients.transpose(1, 2, 0))
    for block in samples:
        fitted = np.sum(monomials(block.distance)[:, None] * by_patch.take(block.patches, axis=2), axis=0)
        squares = np.sum((fitted - block.values.T) ** 2, axis=0)
        found += np.bincount(block.elements, block.weights * squares, n_elements)
    return found


def _solved(moments: Floats, right: Floats) -> Floats:
    size = np.sqrt(np.einsum("nii->ni", moments))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    normal = moments * scale[:, :, None] * scale[:, None, :] + RIDGE * np.eye(N_MONOMIALS)
    return np.asarray(np.linalg.solve(normal, right * scale[:, :, None]) * scale[:, :, None])
