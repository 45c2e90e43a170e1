"""Slip and dissipation of a closed crack under a shear that turns back."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verification.reversed_shear import ShearedCrack

CRACK = ShearedCrack(half_length=0.5, young_prime=1e10, friction=0.4, pressure=5e6)  # sticks up to 2 MPa
LIMIT = 2e6


def cycles(amplitude: float, n_points: int) -> np.ndarray:
    """The first loading and one cycle: 0, +T, -T, +T."""
    corners = np.array([0.0, 1.0, -1.0, 1.0]) * amplitude
    return np.interp(np.linspace(0.0, 3.0, 3 * n_points + 1), np.arange(4), corners)


def test_a_reversal_sticks_for_twice_the_limit() -> None:
    slip = CRACK.driving([3 * LIMIT, 2 * LIMIT, 1 * LIMIT, 0.0, -3 * LIMIT, -1 * LIMIT, 3 * LIMIT]) / LIMIT
    np.testing.assert_allclose(slip, [2.0, 2.0, 2.0, 1.0, -2.0, -2.0, 2.0], rtol=1e-14)


def test_slip_is_an_ellipse_whose_mean_is_the_mean_slip() -> None:
    x = np.linspace(-0.5, 0.5, 20001)
    slip = CRACK.slip([3 * LIMIT], x)[0]
    assert slip.max() == pytest.approx(4.0 / 1e10 * 2.0 * LIMIT * 0.5)
    assert np.trapezoid(slip, x) == pytest.approx(CRACK.mean_slip([3 * LIMIT])[0], rel=1e-5)
    assert CRACK.K_II([3 * LIMIT])[0] == pytest.approx(2.0 * LIMIT * np.sqrt(np.pi * 0.5))


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
