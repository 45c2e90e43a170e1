"""Gathered tip functions at points: their definition, their gradients, and no jump but on the crack."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at, fields_at, values_at
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import tip_angle
from tests.unit.approximation.test_approximation_basis import inner_points
from tests.unit.approximation.tip_values import at_polar
from tests.unit.cover_tables import gradient_rows

BENT = [(6.3, 9.2), (9.2, 9.9), (12.4, 12.1), (15.9, 13.4)]
"""The kinks lie in the discs of both tips."""


def sample_with(build, levels: int, support: float = 2.0):
    """Both tips of a bent crack gathered, in a body of 22 x 22 spacings; cells are small at one of them."""
    sample = build.block((22, 22), [build.crack(BENT, gathered=True)], support, levels, [BENT[-1]])
    assert all(tip.carriers.gathered for tip in sample.cover.tips)
    return sample


@pytest.mark.parametrize("levels", [0, 2])
def test_functions_are_the_carriers_times_the_tip_functions(build, levels: int) -> None:
    """And the others add up to one and to the position, as they do without."""
    sample = sample_with(build, levels)
    cover = sample.cover
    points, elements = inner_points(sample, 30)
    found, n_patches = values_at(cover, points, elements).rows.toarray(), len(cover.patches.nodes)
    phi = found[:, :n_patches]
    np.testing.assert_allclose(phi.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(phi @ cover.patches.nodes, points, atol=1e-12)
    for tip in cover.tips:
        four = at_polar(tip, *tip_angle(tip, points, cover.elements.reference[elements]))[0]
        for carrier in range(3):
            mine = tip.carriers.number == carrier
            sums = phi[:, tip.patches[mine]] @ tip.carriers.shares[mine]
            first = tip.first_function + 4 * carrier
            np.testing.assert_allclose(found[:, first : first + 4], sums[:, None] * four, atol=1e-13)


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("levels", [0, 2])
def test_gradients_agree_with_differences_and_fields_with_rows(build, levels: int, support: float) -> None:
    sample = sample_with(build, levels, support)
    points, elements = inner_points(sample, 31)
    basis = basis_at(sample.cover, points, elements)
    step = 1e-6
    for axis in range(2):
        move = step * np.eye(2)[axis]
        ahead, behind = (values_at(sample.cover, points + s * move, elements).rows for s in (1, -1))
        assert np.abs(gradient_rows(basis)[axis] - (ahead - behind) / (2 * step)).max() < 1e-7
    coefficients = np.random.default_rng(6).normal(size=(sample.cover.n_functions, 2))
    for field, rows in zip(
        fields_at(sample.cover, coefficients, points, elements), (basis.rows, *gradient_rows(basis)), strict=True
    ):
        np.testing.assert_allclose(field, rows @ coefficients, atol=1e-11)


@pytest.mark.parametrize("levels", [0, 2])
def test_functions_jump_on_the_crack_and_nowhere_else(build, levels: int) -> None:
    """Between all neighbours, at the middle of their edge: also behind the kinks, and where they have faded out."""
    cover = sample_with(build, levels).cover
    edges, vertices = cover.elements.edges, cover.elements.vertices
    inside = (edges.left >= 0) & (edges.right >= 0)
    passable = cover.elements.passable
    n_patches = len(cover.patches.nodes)
    for chosen, jumps in ((inside & passable, False), (inside & ~passable, True)):
        some = np.flatnonzero(chosen)
        middle = 0.5 * (vertices[edges.a[some]] + vertices[edges.b[some]])
        left, right = (
            values_at(cover, middle, side[some]).rows.tocsc()[:, n_patches:] for side in (edges.left, edges.right)
        )
        largest = abs(left - right).max(axis=0).toarray().ravel()
        assert len(some) > 10
        assert (largest > 0.1).any() == jumps
        if not jumps:
            assert largest.max() < 1e-12
            assert abs(left).max() > 1.0


def test_no_function_is_seen_beyond_its_reach(build) -> None:
    sample = sample_with(build, 2)
    cover = sample.cover
    points = sample.lattice.to_lattice(np.random.default_rng(9).uniform(0.6, 22.4, (3000, 2)))
    values = values_at(cover, points, locate(sample.lattice, cover.elements, points)).rows.tocsc()
    for tip in cover.tips:
        mine = values[:, tip.first_function : tip.first_function + 12]
        distance = np.hypot(*(points - tip.point).T)
        seen = distance[np.unique(mine.nonzero()[0])]
        assert 0.6 * tip.carriers.reach < seen.max() <= tip.carriers.reach
