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
from typing import Any

import numpy as np

from crackgrow.approximation.basis import arrays_of, gathered, most_functions
from crackgrow.approximation.mls import mls
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import kernel
from crackgrow.cover.cover import Cover
from crackgrow.fracture.singular_stress import SingularStress
from crackgrow.quadrature.elements import ElementPoints, element_points
from crackgrow.ragged import distinct, starts_of
from crackgrow.solid.elasticity import PlaneElasticity, energy_components
from crackgrow.solid.recovery import stress_at

N_MONOMIALS = 6
"""1, x, y, x^2, x y, y^2."""

RIDGE = 1e-12
"""Added to the normalised moments: slivers of rock do not see all of the polynomial."""

N_POINTS = 2
"""Gauss points per direction at which stress is sampled: with 4 the estimate differs by 3 %, at thrice the cost."""


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
    at, patches = element_points(cover, N_POINTS), cover.patches
    body = cover.elements.body[at.element]
    stress = energy_components(materials, stress_at(cover, materials, u, at.points, at.element), body)
    scale = cover.lattice.support / patches.half  # of the polynomials' arguments, which are of order 1
    # no fits on crumbs, whose stress is uniform
    weights = np.where(patches.in_crumb[at.element], 0.0, at.weights)
    samples = at.points, at.element, weights, stress, *_singular_stress(cover, materials, at, singular)
    sums = np.zeros((len(patches.nodes), N_MONOMIALS, N_MONOMIALS + 3))
    _add_moments(arrays_of(cover), scale, samples, sums)
    elements = np.zeros(cover.elements.n)
    _add_squares(arrays_of(cover), scale, samples, _solved(sums), elements)
    area = cover.lattice.spacing**2
    return ErrorEstimate(area * elements, math.sqrt(area * float(at.weights @ np.sum(stress**2, axis=1))))


def _singular_stress(
    cover: Cover, materials: Sequence[PlaneElasticity], at: ElementPoints, singular: Sequence[SingularStress]
) -> tuple[Bools, Ints, Ints, Floats]:
    """The singular stress of the tips near by, point after point: those of point i are start[i] to start[i + 1].

    Returns the patches in which each tip's is told apart (n_tips, n_patches), start (n + 1,), tips (q,), and stresses
    (q, 3) in the components of the energy.
    """
    of_element = cover.patches.of_element
    acts = np.array([tip.patches for tip in singular], dtype=bool).reshape(-1, len(cover.patches.nodes))
    point, number, values = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for n, tip in enumerate(singular):
        sees = np.zeros(of_element.n, dtype=bool)
        sees[distinct(of_element.row[acts[n][of_element.values]])] = True
        mine = np.flatnonzero(sees[at.element])
        element = at.element[mine]
        stress = tip.at(at.points[mine], element)
        point.append(mine)
        number.append(np.full(len(mine), n))
        values.append(energy_components(materials, stress, cover.elements.body[element]))
    points = np.concatenate(point)
    order = np.argsort(points, kind="stable")
    start = starts_of(np.bincount(points, minlength=len(at.points)))
    return acts, start, np.concatenate(number)[order], np.concatenate(values)[order]


@kernel
def _regular_stress(i: int, patch: int, stress: Floats, acts: Bools, start: Ints, tip: Ints, singular: Floats) -> Any:
    """Give the stress at a point less the singular stress that is told apart in a patch."""
    a, b, c = stress[i, 0], stress[i, 1], stress[i, 2]
    for at in range(start[i], start[i + 1]):
        if acts[tip[at], patch]:
            a, b, c = a - singular[at, 0], b - singular[at, 1], c - singular[at, 2]
    return a, b, c


@kernel
def _add_moments(arrays: Any, scale: Floats, samples: Any, sums: Floats) -> None:
    """Add integrals of phi_i, times monomials round the node, times these and the stress, to `sums` (patches, 6, 9)."""
    nodes, half, patch_at, patch, pair_at, _, _, carrier_at = arrays[:8]
    points, elements, weights, stress, acts, start, tip, singular = samples
    most, k, m = most_functions(patch_at, pair_at, carrier_at), 0, np.ones(6)
    f, work, at, per = np.empty((3, most)), np.empty((5, most)), np.empty((2, most)), np.empty(most)
    for i in range(len(points)):
        e, x, y = elements[i], points[i, 0], points[i, 1]
        if i == 0 or e != elements[i - 1]:
            k = gathered(e, at, per, nodes, half, patch_at, patch)
        mls(x, y, at, per, k, False, f, work)
        for j in range(k):
            p = patch[patch_at[e] + j]
            weight, dx, dy = weights[i] * max(f[0, j], 0.0), (x - nodes[p, 0]) * scale[p], (y - nodes[p, 1]) * scale[p]
            a, b, c = _regular_stress(i, p, stress, acts, start, tip, singular)
            m[1], m[2], m[3], m[4], m[5] = dx, dy, dx * dx, dx * dy, dy * dy
            for row in range(6):
                part = weight * m[row]
                for column in range(6):
                    sums[p, row, column] += part * m[column]
                sums[p, row, 6] += part * a
                sums[p, row, 7] += part * b
                sums[p, row, 8] += part * c


@kernel
def _add_squares(arrays: Any, scale: Floats, samples: Any, fits: Floats, found: Floats) -> None:
    """Add the integrals of sum_i phi_i |P_i - s|^2 over each element to `found` (elements,), in squared spacings."""
    nodes, half, patch_at, patch, pair_at, _, _, carrier_at = arrays[:8]
    points, elements, weights, stress, acts, start, tip, singular = samples
    most, k, m = most_functions(patch_at, pair_at, carrier_at), 0, np.ones(6)
    f, work, at, per = np.empty((3, most)), np.empty((5, most)), np.empty((2, most)), np.empty(most)
    for i in range(len(points)):
        e, x, y = elements[i], points[i, 0], points[i, 1]
        if i == 0 or e != elements[i - 1]:
            k = gathered(e, at, per, nodes, half, patch_at, patch)
        mls(x, y, at, per, k, False, f, work)
        for j in range(k):
            p = patch[patch_at[e] + j]
            dx, dy = (x - nodes[p, 0]) * scale[p], (y - nodes[p, 1]) * scale[p]
            a, b, c = _regular_stress(i, p, stress, acts, start, tip, singular)
            m[1], m[2], m[3], m[4], m[5] = dx, dy, dx * dx, dx * dy, dy * dy
            for row in range(6):
                a, b, c = a - m[row] * fits[p, row, 0], b - m[row] * fits[p, row, 1], c - m[row] * fits[p, row, 2]
            found[e] += weights[i] * max(f[0, j], 0.0) * (a * a + b * b + c * c)


def _solved(sums: Floats) -> Floats:
    """Coefficients (n_patches, 6, 3) of the polynomials, round each patch's node; zero where nothing was sampled."""
    moments, right = sums[..., :N_MONOMIALS], sums[..., N_MONOMIALS:]
    size = np.sqrt(np.einsum("nii->ni", moments))
    scale = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    normal = moments * scale[:, :, None] * scale[:, None, :] + RIDGE * np.eye(N_MONOMIALS)
    return np.asarray(np.linalg.solve(normal, right * scale[:, :, None]) * scale[:, :, None])
