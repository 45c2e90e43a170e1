"""The sliding-crack model: its limits, and how wings stop."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.verification.wing_model import SHORT_WING, WingModel

MODEL = WingModel(half_length=5e-3, angle_deg=30.0, friction=0.3, axial=100e6, lateral=5e6)
FREE = replace(MODEL, lateral=0.0)


def test_driving_shear_is_what_friction_leaves_over() -> None:
    """60 degrees between flaw and load: pressure 75 MPa, shear 43.3 MPa (closed form of the wide plate)."""
    assert FREE.driving == pytest.approx(100e6 * math.sqrt(3.0) / 4.0 - 0.3 * 75e6)
    assert replace(FREE, friction=0.6).driving == 0.0  # beyond tan 30 degrees the flaw sticks


def test_a_vanishing_wing_has_the_largest_hoop_stress_of_the_flaw() -> None:
    """At acos(1/3) from the flaw K_I is 2/sqrt(3) K_II: what the length 0.27 a stands for."""
    flaw = replace(FREE, angle_deg=90.0 - math.degrees(math.acos(1.0 / 3.0)), friction=0.0)
    exact = 2.0 / math.sqrt(3.0) * flaw.driving * math.sqrt(math.pi * flaw.half_length)
    assert flaw.K_I(0.0) == pytest.approx(exact, rel=5e-4)


def test_a_long_wing_is_a_crack_wedged_by_a_point_force() -> None:
    length = 1e4 * FREE.half_length
    assert FREE.K_I(length) == pytest.approx(FREE.wedge / math.sqrt(math.pi * length), rel=1e-4)


def test_arrest_length_without_lateral_stress() -> None:
    toughness = 1e6
    exact = FREE.wedge**2 / (math.pi * toughness**2) - SHORT_WING * FREE.half_length
    assert FREE.arrest_length(toughness) == pytest.approx(exact, rel=1e-12)
    assert FREE.arrest_length(0.0) == math.inf
