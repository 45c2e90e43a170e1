"""The sliding-crack model: its limits, and how wings stop."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.verification.wing_model import SHORT_WING, WingModel

MODEL = WingModel(half_length=5e-3, angle_deg=30.0, friction=0.3, axial=100e6, lateral=5e6)
FREE = replace(MODEL, lateral=0.0)


def test_driving_shear_is_what_friction_leaves_over() -> None:
    """60 degrees between flaw and load: pressure 75 MPa, shear 43.3 MPa (closed form of the wide plate)."""
    assert FREE.driving == pytest.approx(100e6 * math.sqrt(3.0) / 4.0 - 0.3 * 75e6)
    assert replace(FREE, friction=0.6).driving == 0.0  # beyond tan 30 degrees the flaw sticks


def test_equal_stresses_drive_nothing() -> None:
    assert replace(MODEL, lateral=100e6, friction=0.0).driving == 0.0


def test_a_vanishing_wing_has_the_largest_hoop_stress_of_the_flaw() -> None:
    """At acos(1/3) from the flaw K_I is 2/sqrt(3) K_II: what the length 0.27 a stands for."""
    flaw = replace(FREE, angle_deg=90.0 - math.degrees(math.acos(1.0 / 3.0)), friction=0.0)
    exact = 2.0 / math.sqrt(3.0) * flaw.driving * math.sqrt(math.pi * flaw.half_length)
    assert flaw.K_I(0.0) == pytest.approx(exact, rel=5e-4)


def test_a_long_wing_is_a_crack_wedged_by_a_point_force() -> None:
    length = 1e4 * FREE.half_length
    assert FREE.K_I(length) == pytest.approx(FREE.wedge / math.sqrt(math.pi * length), rel=1e-4)


def test_K_I_falls_with_the_length_and_with_the_lateral_stress() -> None:
    lengths = np.geomspace(1e-6, 1.0, 50)
    along = np.array([MODEL.K_I(length) for length in lengths])
    assert np.all(np.diff(along) < 0.0)
    across = np.array([replace(MODEL, lateral=p * 1e6).K_I(3e-3) for p in range(30)])
    assert np.all(np.diff(across) < 0.0)


def test_arrest_length_without_lateral_stress() -> None:
    toughness = 1e6
    exact = FREE.wedge**2 / (math.pi * toughness**2) - SHORT_WING * FREE.half_length
    assert FREE.arrest_length(toughness) == pytest.approx(exact, rel=1e-12)
    assert FREE.arrest_length(0.0) == math.inf


def test_arrest_length_without_toughness() -> None:
    """l (l + l*) = (wedge / (pi lateral))^2."""
    short = SHORT_WING * MODEL.half_length
    exact = -0.5 * short + math.hypot(0.5 * short, MODEL.wedge / (math.pi * MODEL.lateral))
    assert MODEL.arrest_length(0.0) == pytest.approx(exact, rel=1e-12)


def test_arrested_wings_are_shorter_under_more_lateral_stress() -> None:
    lengths = [replace(MODEL, lateral=p * 1e6).arrest_length(1e6) for p in range(0, 40, 2)]
    assert lengths[0] > 0.0
    assert lengths[-1] == 0.0
    assert np.all(np.diff([length for length in lengths if length > 0.0]) < 0.0)
    assert MODEL.K_I(MODEL.arrest_length(1e6)) == pytest.approx(1e6, rel=1e-9)


def test_no_wing_starts_below_the_toughness() -> None:
    assert MODEL.arrest_length(1.001 * MODEL.K_I(0.0)) == 0.0
    assert replace(MODEL, friction=0.7).arrest_length(0.0) == 0.0


def test_lateral_tension_is_refused() -> None:
    with pytest.raises(ValueError, match="tension"):
        replace(MODEL, lateral=-1.0)
