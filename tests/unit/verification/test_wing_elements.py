"""Elements of displacement discontinuity: straight cracks in closed form, and a short wing."""

from __future__ import annotations

import numpy as np
import pytest

from tests.verification.wing_elements import Elements, graded, stress_intensities, wing_K, winged_flaw
from tests.verification.wing_model import WingModel

FLAW = np.array([[-np.cos(np.pi / 6.0), -0.5], [np.cos(np.pi / 6.0), 0.5]])  # half length 1, 30 degrees


def straight(angle_deg: float, n: int) -> Elements:
    """A crack of half length 1 without traction."""
    along = np.exp(1j * np.deg2rad(angle_deg))
    return Elements((2.0 * graded(n) - 1.0) * along, np.zeros(n, dtype=bool))


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, -60.0])
def test_straight_open_crack(angle_deg: float) -> None:
    """K_I = sigma cos^2 sqrt(pi a); K_II: the left, upper face moves up, outward where the tip points up."""
    K_I, K_II = stress_intensities(straight(angle_deg, 40), 1.0, 0.0, 0.0)
    c, s = np.cos(np.deg2rad(angle_deg)), np.sin(np.deg2rad(angle_deg))
    assert pytest.approx(np.array([c * c, s * c]) * np.sqrt(np.pi), abs=1e-10) == [K_I, K_II]


def test_a_crack_of_three_pieces_in_a_line() -> None:
    """A straight crack along the pressure whose middle slides without load: lateral tension opens the rest."""
    flaw, wing = np.array([[0.0, -0.5], [0.0, 0.5]]), np.array([[0.0, 0.5], [0.0, 2.0]])
    closed_middle = stress_intensities(winged_flaw(flaw, wing, 40), -1.0, 1.0, 0.0)[0]
    whole = stress_intensities(straight(90.0, 120), -1.0, 1.0, 0.0)[0] * np.sqrt(2.0)
    assert 0.5 * whole < closed_middle < whole


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_long_wings_are_wedged_by_a_point_force(friction: float) -> None:
    """Wings along the compression, of 20 a, without lateral stress: the formula is right there."""
    wing = FLAW[1] + np.array([[0.0, 0.0], [0.0, 20.0]])
    K_I, _ = wing_K(FLAW, wing, 120, -1.0, 0.0, friction)
    assert pytest.approx(WingModel(1.0, 30.0, friction, 1.0, 0.0).K_I(20.0), rel=0.02) == K_I


@pytest.mark.parametrize("length", [0.3, 1.0, 2.0])
def test_more_elements_change_K_by_a_percent(length: float) -> None:
    wing = FLAW[1] + length * np.array([[0.0, 0.0], [-0.1, 1.0]])
    coarse, fine = (wing_K(FLAW, wing, n, -1.0, -0.05, 0.3)[0] for n in (80, 160))
    wedged = WingModel(1.0, 30.0, 0.3, 1.0, 0.0).K_I(length)
    assert abs(fine - coarse) < 0.012 * wedged
