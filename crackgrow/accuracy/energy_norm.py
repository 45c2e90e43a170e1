"""An estimate of the error in the energy norm, by recovery of the stress (after Zienkiewicz, Zhu 1987, 1992).

On every physical patch i the stress, less the singular stress of the tips near by (after Rodenas et al. 2008), is
fitted by a quadratic polynomial P_i. The error of stress ripples with the period of the lattice, which such a fit
averages out, and nothing is averaged across a crack; what the computed stress deviates by from it is the estimate,

    eta^2 = sum_i integral phi_i (P_i - s)' C^-1 (P_i - s) dA,

not less than the norm of s* - s with s* = sum_i phi_i P_i, since the phi_i add up to one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from crackgrow.approximation.basis import basis_at
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.quadrature.elements import ElementPoints, element_points
from crackgrow.ragged import numbered
from crackgrow.solid.elasticity import PlaneElasticity, energy_components
from crackgrow.solid.recovery import stress_of

N_MONOMIALS = 6
"""1, x, y, x^2, x y, y^2."""

RIDGE = 1e-12
"""Added to the normalised moments: slivers of rock do not see all of the polynomial."""

N_POINTS = 2
"""Gauss points per direction at which stress is sampled: with 4 the estimate differs by 3 %, at thrice the cost."""

AT_ONCE = 8_000
"""Points, and pairs of a point and a patch, taken together: more do not fit into a cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Pairs of a point anywhere and a patch over it; values may differ from patch to patch."""

    elements: Ints  # (p,)
    patches: Ints  # (p,)
    distance: Floats  # (p, 2) from the node to the point, in the largest cells at the node
    weights: Floats  # (p,) area, in squared spacings, times phi_i
    values: Floats  # (p, 3)


@dataclass(frozen=True, slots=True, eq=False)
class ErrorEstimate:
    """The estimated error of the stress."""

    elements: Floats  # (elements,) J/m: each element's part of the squared norm
    norm: float  # sqrt(J/m): energy norm of the computed stress

    @property
    def absolute(self) -> float:
        """Energy norm of the error, sqrt(J/m)."""
        return math.sqrt(float(self.elements.sum()))

    @property
    def relative(self) -> float:
        """The same in percent of the norm of the stress; nan where there is none."""
        return 100.0 * self.absolute / self.norm if self.norm > 0.0 else math.nan


def error_estimate(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, singular: Sequence[SingularStress]
) -> ErrorEstimate:
    """Estimate for displacements `u` (n_dofs,) m in bodies of `materials`, in-situ stress included."""
    n_patches, everywhere = len(cover.patches.nodes), element_points(cover, N_POINTS)
    acting = [(part, part.patches) for part in singular]
    some = [slice(start, start + AT_ONCE) for start in range(0, len(everywhere.points), AT_ONCE)]
    blocks = [_sampled(cover, materials, u, everywhere, block, acting) for block in some]
    samples, norm = [part for parts, _ in blocks for part in parts], sum(squares for _, squares in blocks)
    parts = fit_residuals(fit(n_patches, samples), samples, cover.elements.n)
    area = cover.lattice.spacing**2
    return ErrorEstimate(area * parts, math.sqrt(area * norm))


def _sampled(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    at: ElementPoints,
    block: slice,
    acting: Sequence[tuple[SingularStress, Bools]],
) -> tuple[list[Samples], float]:
    """Samples at a block of points, and the integral of their squares; singular parts act on some of the patches."""
    points, weights, element = at.points[block], at.weights[block], at.element[block]
    body = cover.elements.body[element]
    basis, patches = basis_at(cover, points, element), cover.patches.of_element.taken(element)
    gradient = basis.fields(u)[1:].transpose(1, 2, 0)
    places = cover.lattice.to_metres(points)
    values = energy_components(materials, stress_of(materials, gradient, body, places), body)
    point = patches.row
    # no fits on crumbs, whose stress is uniform
    phi = np.where(
        cover.patches.in_crumb[element][point],
        0.0,
        np.maximum(basis.values[0, basis.functions < len(cover.patches.nodes)], 0.0),
    )
    less = np.zeros((len(point), 3))  # patch by patch, what is told apart there
    for part, acts in acting:
        sees = np.flatnonzero(acts[patches.values])
        mine, back = numbered(point[sees], len(points))
        if len(mine):
            less[sees] += energy_components(materials, part.at(points[mine], element[mine]), body[mine])[back]
    half = cover.patches.half[patches.values] / cover.lattice.support
    distance = (points[point] - cover.patches.nodes[patches.values]) / half[:, None]
    owner, area, own = element[point], weights[point] * phi, values[point] - less
    some = [slice(start, start + AT_ONCE) for start in range(0, len(point), AT_ONCE)]
    samples = [Samples(owner[at], patches.values[at], distance[at], area[at], own[at]) for at in some]
    return samples, float(weights @ np.sum(values**2, axis=1))


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


def fit_residuals(coefficients: Floats, samples: list[Samples], n_elements: int) -> Floats:
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
