"""Slip and dissipation of a closed crack under a shear that turns back."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verification.reversed_shear import ShearedCrack

CRACK = ShearedCrack(half_length=0.5, young_prime=1e10, friction=0.4, pressure=5e6)  # sticks up to 2 MPa
LIMIT = 2e6
PER_STRESS = np.pi * 0.5 / 1e10  # m/Pa: mean slip


def cycles(amplitude: float, n_points: int) -> np.ndarray:
    """The first loading and one cycle: 0, +T, -T, +T."""
    corners = np.array([0.0, 1.0, -1.0, 1.0]) * amplitude
    return np.interp(np.linspace(0.0, 3.0, 3 * n_points + 1), np.arange(4), corners)


def test_first_loading_sticks_and_then_slides() -> None:
    slip = CRACK.mean_slip([0.5 * LIMIT, LIMIT, 1.5 * LIMIT, 3.0 * LIMIT])
    np.testing.assert_allclose(slip, np.array([0.0, 0.0, 0.5, 2.0]) * LIMIT * PER_STRESS, rtol=1e-14)


def test_a_reversal_sticks_for_twice_the_limit() -> None:
    slip = CRACK.driving([3 * LIMIT, 2 * LIMIT, 1 * LIMIT, 0.0, -3 * LIMIT, -1 * LIMIT, 3 * LIMIT]) / LIMIT
    np.testing.assert_allclose(slip, [2.0, 2.0, 2.0, 1.0, -2.0, -2.0, 2.0], rtol=1e-14)


def test_slip_is_an_ellipse_whose_mean_is_the_mean_slip() -> None:
    x = np.linspace(-0.5, 0.5, 20001)
    slip = CRACK.slip([3 * LIMIT], x)[0]
    assert slip.max() == pytest.approx(4.0 / 1e10 * 2.0 * LIMIT * 0.5)
    assert np.trapezoid(slip, x) == pytest.approx(CRACK.mean_slip([3 * LIMIT])[0], rel=1e-5)
    assert CRACK.K_II([3 * LIMIT])[0] == pytest.approx(2.0 * LIMIT * np.sqrt(np.pi * 0.5))


def test_only_turning_points_matter() -> None:
    turning = [3 * LIMIT, -1.7 * LIMIT, 0.9 * LIMIT, -2.5 * LIMIT]
    fine = np.interp(np.linspace(0.0, 4.0, 4001), np.arange(5), [0.0, *turning])
    assert CRACK.driving(turning)[-1] == pytest.approx(CRACK.driving(fine)[-1], rel=1e-14)
    assert CRACK.dissipated(turning)[-1] == pytest.approx(CRACK.dissipated(fine)[-1], rel=1e-12)


@pytest.mark.parametrize("amplitude", [1.2 * LIMIT, 2.0 * LIMIT, 5.0 * LIMIT])
def test_dissipation_is_the_integral_of_friction_times_slip(amplitude: float) -> None:
    """Both by the traction on the faces and as the area of the loop of shear stress against mean slip."""
    shear = cycles(amplitude, 2000)
    slip = CRACK.mean_slip(shear)[2000:]
    length = 2.0 * CRACK.half_length
    by_faces = length * np.trapezoid(CRACK.traction(shear)[2000:], slip)
    loop = length * np.trapezoid(shear[2000:], slip)
    by_history = np.diff(CRACK.dissipated(shear)[[2000, -1]])[0]
    closed_form = CRACK.dissipated_per_cycle(amplitude)
    assert by_history == pytest.approx(closed_form, rel=1e-12)
    assert by_faces == pytest.approx(closed_form, rel=2e-3)  # the trapezium that holds the corner
    assert loop == pytest.approx(closed_form, rel=2e-3)


@pytest.mark.parametrize("amplitude", [0.0, 0.5 * LIMIT, LIMIT])
def test_nothing_slips_below_the_limit(amplitude: float) -> None:
    shear = cycles(amplitude, 10)
    assert np.all(CRACK.mean_slip(shear) == 0.0)
    assert CRACK.dissipated(shear)[-1] == 0.0
    assert CRACK.dissipated_per_cycle(amplitude) == 0.0


def test_traction_never_exceeds_friction() -> None:
    shear = np.random.default_rng(3).uniform(-5, 5, 200) * LIMIT
    assert np.abs(CRACK.traction(shear)).max() <= LIMIT * (1.0 + 1e-12)


def test_without_friction_slip_follows_the_shear() -> None:
    free = ShearedCrack(0.5, 1e10, 0.0, 5e6)
    shear = cycles(3 * LIMIT, 5)
    np.testing.assert_allclose(free.mean_slip(shear), shear * PER_STRESS, rtol=1e-14)
    assert free.dissipated(shear)[-1] == 0.0
