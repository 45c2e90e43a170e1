"""The four tip functions: closed form, gradients, fading."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.cover.tips import TipView, seen_from_tip, tip_angle
from tests.unit.approximation.tip_values import at_polar

POINTS = np.array([[4.0, 3.0], [3.2, 2.9], [2.6, 2.3], [1.6, 2.5]])
FADES = (np.inf, 2.0, 0.9)


def tip_with(fade: float) -> TipView:
    return replace(seen_from_tip(POINTS, 1.0, ends_inside=False), fade=fade)


def scattered(seed: int, n: int = 300) -> np.ndarray:
    """Points 0.05 to 1.5 from the tip."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, n)
    return POINTS[0] + (rng.uniform(0.05, 1.5, n) * [np.cos(angle), np.sin(angle)]).T


def test_values_follow_the_closed_form() -> None:
    r, t = np.array([0.25, 1.0, 4.0, 1.0, 1.0]), np.array([0.0, np.pi, -np.pi, np.pi / 2, -np.pi / 3])
    s = np.sqrt(0.5)
    expected = [[0.5, 0, 0.5, 0], [0, 1, 0, -1], [0, -2, 0, 2], [s, s, -s, s], [np.sqrt(3) / 2, -0.5, 0, -1]]
    values, _ = at_polar(tip_with(np.inf), r, t)
    np.testing.assert_allclose(values, expected, atol=1e-15)


@pytest.mark.parametrize("fade", FADES)
def test_gradients_agree_with_differences(fade: float) -> None:
    """In lattice axes, on a kinked crack; the references stay on their side."""
    tip, points, step = tip_with(fade), scattered(18), 1e-6

    def values(at: np.ndarray) -> np.ndarray:
        return at_polar(tip, *tip_angle(tip, at, points))[0]

    _, gradients = at_polar(tip, *tip_angle(tip, points, points))
    for axis in range(2):
        move = step * np.eye(2)[axis]
        difference = (values(points + move) - values(points - move)) / (2 * step)
        # third derivative about r^-2.5 < 2000, times step^2; rounding 1e-16 / step; the third derivative of chi jumps
        np.testing.assert_allclose(gradients[:, :, axis], difference, atol=1e-8)


def test_fading_multiplies_by_chi() -> None:
    r, t = np.linspace(0.01, 3.0, 60), np.linspace(-3, 3, 60)
    plain, faded = (at_polar(tip_with(fade), r, t)[0] for fade in (np.inf, 2.0))
    chi = np.where(r < 2.0, (1 - (r / 2.0) ** 2) ** 2, 0.0)
    np.testing.assert_allclose(faded, chi[:, None] * plain, atol=1e-15)


def test_faded_functions_and_gradients_vanish_from_the_fading_distance_on() -> None:
    values, gradients = at_polar(tip_with(0.9), np.array([0.9, 1.0, 5.0]), np.array([0.3, -2.0, 3.0]))
    assert np.all(values == 0.0)
    assert np.all(gradients == 0.0)


def test_only_the_sine_functions_jump_across_the_crack() -> None:
    r = np.linspace(0.1, 2, 7)
    plus, minus = (at_polar(tip_with(np.inf), r, np.full(7, t))[0] for t in (np.pi, -np.pi))
    root = np.sqrt(r)
    np.testing.assert_allclose(plus - minus, np.outer(root, [0, 2, 0, -2]), atol=1e-14)


def test_values_grow_with_the_square_root_and_gradients_with_its_inverse() -> None:
    t = np.full(2, 1.1)
    values, gradients = at_polar(tip_with(np.inf), np.array([0.01, 0.04]), t)
    np.testing.assert_allclose(values[1], 2 * values[0], rtol=1e-14)
    np.testing.assert_allclose(gradients[1], gradients[0] / 2, rtol=1e-13)


def test_at_the_tip_itself_values_vanish_and_gradients_are_finite() -> None:
    values, gradients = at_polar(tip_with(np.inf), np.zeros(1), np.zeros(1))
    assert np.all(values == 0.0)
    assert np.isfinite(gradients).all()


def test_functions_are_harmonic() -> None:
    """sqrt(r) {cos, sin} t/2 are harmonic: the divergence of their gradients vanishes."""
    tip, points, step = tip_with(np.inf), scattered(19), 1e-5

    def gradients(at: np.ndarray) -> np.ndarray:
        return at_polar(tip, *tip_angle(tip, at, points))[1]

    divergence = sum(
        (gradients(points + step * e)[:, :, k] - gradients(points - step * e)[:, :, k]) / (2 * step)
        for k, e in enumerate(np.eye(2))
    )
    assert np.abs(divergence[:, :2]).max() < 1e-6  # step^2 times the fourth derivative, r^-3.5 < 4e4 at r = 0.05
    assert np.abs(divergence[:, 2:]).max() > 1.0
