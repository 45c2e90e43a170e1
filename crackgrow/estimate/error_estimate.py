"""An estimate of the error in the energy norm, by recovery of the stress (after Zienkiewicz, Zhu 1987, 1992).

On every physical patch i the stress, less the singular stress of the tips near by (after Rodenas et al. 2008), is
fitted by a quadratic polynomial P_i. The error of stress ripples with the period of the lattice, which such a fit
averages out; what the computed stress deviates by from it is the estimate,

    eta^2 = sum_i integral phi_i (P_i - s)' C^-1 (P_i - s) dA,

not less than the norm of s* - s with s* = sum_i phi_i P_i, since the phi_i add up to one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from crackgrow.approximation.basis import basis_at
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.estimate.patch_fits import Samples, fit, misfits
from crackgrow.quadrature.elements import ElementPoints
from crackgrow.quadrature.plain_kinds import all_points
from crackgrow.ragged import Ragged, by_row, numbered
from crackgrow.solid.elasticity import PlaneElasticity, energy_components
from crackgrow.solid.recovery import stress_of

N_POINTS = 2
"""Gauss points per direction at which stress is sampled: with 4 the estimate differs by 3 %, at thrice the cost."""

AT_ONCE = 8_000
"""Points, and pairs of a point and a patch, taken together: more do not fit into a cache."""


class Singular(Protocol):
    """A known singular part of the stress."""

    @property
    def patches(self) -> Bools:
        """The physical patches (n_patches,) in which it is told apart."""

    def at(self, points: Floats, elements: Ints) -> Floats:
        """Stress (n, 3) Pa at points (n, 2) of elements (n,)."""


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
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, singular: Sequence[Singular]
) -> ErrorEstimate:
    """Estimate for displacements `u` (n_dofs,) m in bodies of `materials`, in-situ stress included."""
    n_patches = len(cover.patches.nodes)
    acting = np.zeros((len(singular), n_patches), dtype=bool)
    for row, part in zip(acting, singular, strict=True):
        row[:] = part.patches
    patch, part_there = np.nonzero(acting.T)
    acting_on = by_row(patch, part_there, n_patches)
    blocks = [_sampled(cover, materials, u, some, singular, acting_on) for some in _points_of(cover)]
    samples, norm = [part for parts, _ in blocks for part in parts], sum(squares for _, squares in blocks)
    parts = misfits(fit(n_patches, samples), samples, cover.elements.n)
    area = cover.lattice.spacing**2
    return ErrorEstimate(area * parts, math.sqrt(area * norm))


def _points_of(cover: Cover) -> list[ElementPoints]:
    """Points of all elements, in blocks."""
    at = all_points(cover, N_POINTS)
    blocks = [slice(start, start + AT_ONCE) for start in range(0, len(at.points), AT_ONCE)]
    return [ElementPoints(at.points[b], at.weights[b], at.element[b]) for b in blocks]


def _sampled(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    at: ElementPoints,
    singular: Sequence[Singular],
    acting: Ragged,
) -> tuple[list[Samples], float]:
    """Samples at points anywhere, and the integral of their squares; `acting` are the singular parts on patches."""
    points, weights, element = at.points, at.weights, at.element
    body = cover.elements.body[element]
    basis = basis_at(cover, points, element)
    gradient = basis.field(u.reshape(-1, 2))[1:].transpose(1, 2, 0)
    places = cover.lattice.to_metres(points)
    values = energy_components(materials, stress_of(materials, gradient, body, places), body)
    patches, point = basis.patches, basis.patches.row
    # no fits on crumbs, whose stress is uniform
    phi = np.where(cover.patches.in_crumb[element][point], 0.0, np.maximum(basis.phi[0], 0.0))
    less = np.zeros((len(point), 3))  # patch by patch, what is told apart there
    seen, place = acting.places(patches.values)
    parts = acting.values[place].astype(np.min_scalar_type(len(singular)))  # short numbers are sorted by their digits
    order = np.argsort(parts, kind="stable")
    for sees in np.split(order, np.flatnonzero(np.diff(parts[order])) + 1) if len(order) else ():
        part, sees = singular[parts[sees[0]]], seen[sees]
        mine, back = numbered(point[sees], len(points))
        less[sees] += energy_components(materials, part.at(points[mine], element[mine]), body[mine])[back]
    half = cover.patches.half[patches.values] / cover.lattice.support
    distance = (points[point] - cover.patches.nodes[patches.values]) / half[:, None]
    owner, area, own = element[point], weights[point] * phi, values[point] - less
    some = [slice(start, start + AT_ONCE) for start in range(0, len(point), AT_ONCE)]
    samples = [Samples(owner[at], patches.values[at], distance[at], area[at], own[at]) for at in some]
    return samples, float(weights @ np.sum(values**2, axis=1))
