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

from crackgrow.approximation.mls import mls, mls_values
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import list_starts
from crackgrow.estimate.energy_norm import energy_components
from crackgrow.estimate.patch_fits import FreeSamples, RegularSamples, fit, misfits
from crackgrow.quadrature.elements import ElementPoints
from crackgrow.quadrature.everywhere import all_points
from crackgrow.quadrature.rules import square
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_at, stress_of

N_POINTS = 2
"""Gauss points per direction at which stress is sampled: with 4 the estimate differs by 3 %, at thrice the cost."""

AT_ONCE = 8_000
"""Points taken together where they are not regular: what is computed of more of them does not fit into a cache."""


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
    patches = np.where(cover.functions < 0, len(cover.patch_nodes), cover.functions)
    acting = np.zeros((len(singular), len(cover.patch_nodes) + 1), dtype=bool)
    for row, part in zip(acting, singular, strict=True):
        row[:-1] = part.patches
    near = np.asarray(acting.any(axis=0))[patches].any(axis=1)
    is_regular = np.arange(len(patches)) < cover.elements.n_whole
    is_regular &= ~near & ~cover.enrichment.tips.any & (cover.crumbs.of_element < 0)
    regular = _regular(cover, materials, u, patches, np.flatnonzero(is_regular))
    rest = _points_of(cover, ~is_regular)
    blocks = [_free(cover, materials, u, patches, some, singular, acting) for some in rest]
    free, norm = [samples for samples, _ in blocks], sum(squares for _, squares in blocks)
    for some in regular:
        norm += float(np.einsum("qw,qec->", some.weights, some.values**2))
    coefficients = fit(len(cover.patch_nodes), regular, free)
    parts = misfits(coefficients, regular, free, len(patches))
    area = cover.lattice.spacing**2
    return ErrorEstimate(area * parts, math.sqrt(area * norm))


def _regular(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, patches: Ints, elements: Ints
) -> list[RegularSamples]:
    """Samples of whole tiles (e,) that carry MLS functions alone: those at the same place of their cell together."""
    lattice, found = cover.lattice, []
    local, weights = square(N_POINTS)
    in_cell = cover.elements.tile[elements] % (len(lattice.breaks) - 1)
    coefficients = np.append(u[: 2 * len(cover.patch_nodes)].reshape(-1, 2), np.zeros((1, 2)), axis=0)
    for part in np.unique(in_cell, axis=0):
        mine = elements[np.all(in_cell == part, axis=1)]
        low, size = lattice.breaks[part], lattice.breaks[part + 1] - lattice.breaks[part]
        points = low + local * size
        phi, dphi = mls(points, lattice.support, lattice.reach)
        own = coefficients[patches[mine]].transpose(1, 0, 2).reshape(lattice.window, -1)
        by = dphi.transpose(0, 2, 1).reshape(-1, lattice.window) / lattice.spacing @ own  # (q d, e c)
        gradient = by.reshape(len(points), 2, len(mine), 2).transpose(0, 2, 3, 1)
        body = np.tile(cover.elements.body[mine], len(points))
        values = energy_components(materials, stress_of(materials, gradient.reshape(-1, 2, 2), body), body)
        area = weights * size.prod()
        found.append(
            RegularSamples(
                mine,
                patches[mine],
                points[:, None] - lattice.offsets,
                area[:, None] * np.maximum(phi, 0.0),
                values.reshape(len(points), len(mine), 3),
            )
        )
    return found


def _points_of(cover: Cover, chosen: Bools) -> list[ElementPoints]:
    """Points of the elements `chosen` (elements,), in blocks."""
    everywhere = all_points(cover, N_POINTS)
    these = np.flatnonzero(chosen[everywhere.element])
    blocks = [these[start : start + AT_ONCE] for start in range(0, len(these), AT_ONCE)]
    return [ElementPoints(everywhere.points[b], everywhere.weights[b], everywhere.element[b]) for b in blocks]


def _free(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    patches: Ints,
    at: ElementPoints,
    singular: Sequence[Singular],
    acting: Bools,
) -> tuple[FreeSamples, float]:
    """Samples at points anywhere, and the integral of their squares."""
    points, weights, element = at.points, at.weights, at.element
    body, window = cover.elements.body[element], cover.lattice.window
    values = energy_components(materials, stress_at(cover, materials, u, points, element), body)
    cell = cover.elements.tile[element] // (len(cover.lattice.breaks) - 1)
    phi = np.maximum(mls_values(points - cell, cover.lattice.support, cover.lattice.reach), 0.0)
    # no fits on crumbs, whose stress is uniform
    phi[(cover.functions[element] < 0) | (cover.crumbs.of_element[element] >= 0)[:, None]] = 0.0
    rows, parts, where = [np.empty(0, dtype=np.int64)], [np.empty((0, 3))], [np.empty((0, window), dtype=bool)]
    for part, in_patches in zip(singular, acting, strict=True):
        sees = in_patches[patches]
        mine = np.flatnonzero(sees.any(axis=1)[element])
        rows.append(mine)
        parts.append(energy_components(materials, part.at(points[mine], element[mine]), body[mine]))
        where.append(sees[element[mine]])
    row = np.concatenate(rows)
    order = np.argsort(row, kind="stable")
    samples = FreeSamples(
        element,
        patches[element],
        np.append(cover.patch_nodes, np.zeros((1, 2)), axis=0),
        points,
        weights[:, None] * phi,
        values,
        list_starts(row[order], len(points)),
        np.concatenate(parts)[order],
        np.concatenate(where)[order],
    )
    return samples, float(weights @ np.sum(values**2, axis=1))
