"""The displacement is continuous everywhere except across a crack."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.solid.recovery import displacement_at

LAYOUTS = {
    "kinked": [([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)], (True, True))],
    "from a side": [([(0.5, 2.2), (3.1, 2.7)], (False, True))],
    "two": [([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)], (True, True)), ([(4.4, 1.3), (5.2, 4.8)], (True, True))],
    "through": [([(0.5, 2.3), (3.2, 2.9), (6.5, 3.6)], (False, False))],
    "on lattice lines": [([(1.3, 3.0), (3.0, 3.0), (3.0, 4.6)], (True, True))],
    "crossing": [([(1.7, 2.2), (4.9, 3.0)], (True, True)), ([(3.0, 1.4), (3.6, 4.1)], (True, True))],
    "branch": [([(1.7, 2.2), (4.9, 3.0)], (True, True)), ([(3.3, 2.6), (3.6, 4.1)], (False, True))],
}


def sample_of(build, name: str, support: float):
    cracks = [build.crack(points, tips, str(k)) for k, (points, tips) in enumerate(LAYOUTS[name])]
    return build.block((6, 5), cracks, support)


def random_unknowns(sample) -> np.ndarray:
    """Every function takes part: any gap between two elements would show."""
    return np.random.default_rng(70).uniform(-1, 1, sample.cover.n_dofs)


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
@pytest.mark.parametrize("name", LAYOUTS)
def test_both_sides_of_every_border_that_is_no_crack_agree(build, name: str, support: float) -> None:
    sample = sample_of(build, name, support)
    elements, u = sample.cover.elements, random_unknowns(sample)
    inner = np.flatnonzero((elements.edges.right >= 0) & ~elements.is_crack)
    share = np.random.default_rng(71).uniform(0.02, 0.98, (5, len(inner), 1))
    a, b = elements.vertices[elements.edges.a[inner]], elements.vertices[elements.edges.b[inner]]
    for points in a + share * (b - a):
        left = displacement_at(sample.cover, u, points, elements.edges.left[inner])
        right = displacement_at(sample.cover, u, points, elements.edges.right[inner])
        np.testing.assert_allclose(left, right, atol=1e-7)  # vertices are rounded by 1e-9, the slope of phi is below 10


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("name", LAYOUTS)
def test_displacement_jumps_across_the_crack(build, name: str, support: float) -> None:
    sample = sample_of(build, name, support)
    u = random_unknowns(sample)
    for crack in sample.cover.elements.lines:
        middles = crack.points.mean(axis=1)
        plus, minus = (displacement_at(sample.cover, u, middles, side) for side in (crack.plus, crack.minus))
        jump = np.hypot(*(plus - minus).T)
        assert jump.min() > 1e-4
        assert np.median(jump) > 0.05


@pytest.mark.parametrize("name", ["kinked", "two", "from a side"])
def test_jump_closes_with_the_square_root_of_the_distance_from_the_tip(build, name: str) -> None:
    sample = sample_of(build, name, 2.0)
    u = random_unknowns(sample)
    for (index, at_end), tip in zip(sample.cover.tip_ends, sample.cover.tips, strict=True):
        crack = sample.cover.elements.lines[index]
        last = -1 if at_end else 0
        back = -tip.rotation[0]
        points = tip.point + np.array([[4e-6], [1e-6]]) * back
        side = np.array([crack.plus[last]] * 2), np.array([crack.minus[last]] * 2)
        plus, minus = (displacement_at(sample.cover, u, points, elements) for elements in side)
        far, near = plus - minus
        np.testing.assert_allclose(far, 2 * near, rtol=1e-4)  # the next term is r, 1e-6 / 1e-3 smaller
