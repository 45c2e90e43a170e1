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
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from crackgrow.approximation.basis import basis_at
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.windows import regular_window
from crackgrow.estimate.energy_norm import energy_components
from crackgrow.estimate.patch_fits import FreeSamples, RegularSamples, fit, misfits
from crackgrow.quadrature.elements import ElementPoints
from crackgrow.quadrature.everywhere import all_points
from crackgrow.quadrature.plain_kinds import plain_kinds
from crackgrow.quadrature.rules import square
from crackgrow.ragged import Ragged, by_row, numbered
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_of

N_POINTS = 2
"""Gauss points per direction at which stress is sampled: with 4 the estimate differs by 3 %, at thrice the cost."""

AT_ONCE = 8_000
"""Points, and pairs of a point and a patch, taken together where they are not regular: more do not fit into a cache."""


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
    of_element, n_patches = cover.patches.of_element, len(cover.patches.nodes)
    acting = np.zeros((len(singular), n_patches), dtype=bool)
    for row, part in zip(acting, singular, strict=True):
        row[:] = part.patches
    near = np.zeros(cover.elements.n, dtype=bool)
    near[of_element.row[np.asarray(acting.any(axis=0))[of_element.values]]] = True
    is_regular = cover.plain & ~near
    is_regular[cover.elements.n_whole :] = False
    regular = _regular(cover, materials, u, is_regular)
    rest = _points_of(cover, ~is_regular)
    patch, part_there = np.nonzero(acting.T)
    acting_on = by_row(patch, part_there, n_patches)
    blocks = [_free(cover, materials, u, some, singular, acting_on) for some in rest]
    free, norm = [part for parts, _ in blocks for part in parts], sum(squares for _, squares in blocks)
    for some in regular:
        norm += float(some.areas @ np.einsum("qw,qec->e", some.weights, some.values**2))
    coefficients = fit(n_patches, regular, free)
    parts = misfits(coefficients, regular, free, cover.elements.n)
    area = cover.lattice.spacing**2
    return ErrorEstimate(area * parts, math.sqrt(area * norm))


def _regular(cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, chosen: Bools) -> list[RegularSamples]:
    """Samples of plain elements: those `chosen` (elements,), kind by kind."""
    lattice, found = cover.lattice, []
    share, weights = square(N_POINTS)
    for kind in plain_kinds(cover):
        some = replace(kind, elements=kind.elements[chosen[kind.elements]])
        mine, patches = some.elements, some.patches(cover)
        if len(mine) == 0:
            continue
        phi, dphi = some.functions(lattice, share)
        own = u.reshape(-1, 2)[patches].transpose(1, 0, 2).reshape(patches.shape[1], -1)
        by = dphi.transpose(2, 0, 1).reshape(-1, patches.shape[1]) @ own  # (q d, e c)
        side = cover.elements.size[mine]
        gradient = by.reshape(len(share), 2, len(mine), 2).transpose(0, 2, 3, 1)
        gradient = gradient / (lattice.spacing * side)[:, None, None]
        body = np.tile(cover.elements.body[mine], len(share))
        at = cover.elements.cell[mine] + (kind.low + share * kind.size)[:, None] * side[:, None]
        places = lattice.to_metres(at.reshape(-1, 2))
        values = energy_components(materials, stress_of(materials, gradient.reshape(-1, 2, 2), body, places), body)
        area = weights * kind.size.prod()
        distance = (kind.low + share * kind.size)[:, None] - regular_window(lattice.support)[kind.slots]
        of_points = values.reshape(len(share), len(mine), 3)
        of_area = area[:, None] * np.maximum(phi.T, 0.0)
        found.append(RegularSamples(mine, patches, distance, of_area, side**2, of_points))
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
    at: ElementPoints,
    singular: Sequence[Singular],
    acting: Ragged,
) -> tuple[list[FreeSamples], float]:
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
    samples = [FreeSamples(owner[at], patches.values[at], distance[at], area[at], own[at]) for at in some]
    return samples, float(weights @ np.sum(values**2, axis=1))
