"""Subcritical growth: velocities, the lengths of a step, and the time that it takes."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.model import Fatigue, Subcritical
from crackgrow.fracture.subcritical import WAITS, lengths, mean_velocity, range_of_K, velocities


def test_velocity_is_the_power_of_the_criticality_between_threshold_and_toughness() -> None:
    """Without an exponent all loaded tips have the same; what is too slow for numbers stands still."""
    law = Subcritical(velocity=0.01, exponent=3.0, threshold=0.2)
    found = velocities(np.array([-np.inf, np.nan, -1.0, 0.0, 0.2, 0.5, 1.0, 7.0, np.inf]), law)
    np.testing.assert_allclose(found, [0, 0, 0, 0, 0, 0.01 / 8, 0.01, 0.01, 0.01])
    np.testing.assert_array_equal(velocities(np.array([0.0, 1e-3, 1.0]), Subcritical(2.0, 0.0, 0.0)), [0, 2, 2])
    assert velocities(np.array([1e-3]), Subcritical(1.0, 200.0, 0.0)) == 0.0


def test_growth_in_a_cycle_is_the_power_of_the_range_above_its_threshold() -> None:
    law = Fatigue(rate=1e-9, at=1e6, exponent=2.0, threshold=0.5e6)
    found = velocities(np.array([-np.inf, np.nan, 0.5e6, 1e6, 3e6]), law)
    np.testing.assert_allclose(found, [0, 0, 0, 1e-9, 9e-9])


def test_the_range_of_K_is_along_the_kink_and_of_open_cracks() -> None:
    """Shear to and fro has no more range than in one sense: a ray that one sense opens is closed by the other."""
    kink = -np.arccos(1.0 / 3.0)  # of the largest hoop stress in mode II, 2/sqrt(3) K_II
    assert range_of_K((0.0, 0.0), (0.0, 1.0), kink, (1j, 1j)) == pytest.approx(2.0 / np.sqrt(3.0))
    assert range_of_K((0.0, -1.0), (0.0, 1.0), kink, (1j, 1j)) == pytest.approx(2.0 / np.sqrt(3.0))
    assert range_of_K((-3.0, 0.0), (2.0, 0.0), 0.0, (1j, 1j)) == 2.0
    assert range_of_K((2.0, 0.0), (1.0, 0.0), 0.0, (1j, 1j)) == 1.0


def test_tips_advance_in_proportion_to_their_velocities() -> None:
    advance, gathered, first = lengths(np.array([1.0, 4.0, 0.0, 2.0]), np.zeros(4), 0.5)
    assert first == 1
    np.testing.assert_allclose(advance, [0.125, 0.5, 0.0, 0.25])
    np.testing.assert_array_equal(gathered, np.zeros(4))
    had = np.array([0.15, 0.1])  # one that stands still keeps what it has
    for velocity, expected in ((1.0, ([0.0, 1.0], [0.15, 0.0], 1)), (0.0, ([0.0, 0.0], [0.15, 0.1], None))):
        advance, gathered, first = lengths(np.array([0.0, velocity]), had, 1.0)
        assert (advance.tolist(), gathered.tolist(), first) == expected


def test_tips_that_wait_lose_nothing() -> None:
    velocity, n_steps = np.array([1.0, 0.013, 0.3, 0.0]), 200
    had = np.array([0.0, 0.0, 1.9, 0.0])  # with which the third comes first
    place, gathered, time = np.zeros(4), had, 0.0
    for _ in range(n_steps):
        advance, left, first = lengths(velocity, gathered, 2.0)
        assert first is not None
        assert advance.max() <= 2.0
        assert not np.any((advance > 0.0) & (advance < WAITS * 2.0))
        time += (2.0 - gathered[first]) / velocity[first]
        place, gathered = place + advance, left
    np.testing.assert_allclose(place + gathered, had + velocity * time, rtol=1e-12)
    assert np.all(gathered < WAITS * 2.0)


@pytest.mark.parametrize("ratio", [1.0, 1.0 + 1e-12, 1.3, 1e6, 1e-6, 1e-120])
def test_mean_velocity_is_that_of_an_exponential_law(ratio: float) -> None:
    """v = v_0 exp(k x): the time over a length is the integral of 1/v, by Gauss's rule."""
    x, weight = np.polynomial.legendre.leggauss(300)
    inverse = np.sum(0.5 * weight * ratio ** (-0.5 * (x + 1.0))) / 3.0
    assert mean_velocity(3.0, 3.0 * ratio) == pytest.approx(1.0 / inverse, rel=1e-9)
