"""Time of subcritical growth: a crack in tension in a wide plate, against the closed form.

With K = c s sqrt(pi a) / sqrt(cos(pi a / W)) (Feddersen), where c = 1 but for the error of the first K, the time from
a_0 to a_1 is the integral of da / (v_max (K / K_c)^n): in an infinite plate, for n = 2, ln(a_1 / a_0) K_c^2 / (v_max pi
s^2).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from crackgrow.case import load_case
from tests.whole_run import whole_run

TWO = (
    "cracks={long: {path: {center: [-150, 0], length: 40, angle: 0}, contact: none}, "
    "short: {path: {center: [150, 0], length: 36, angle: 0}, contact: none}}",
    "growth.subcritical.exponent=5",
)
"""Far from each other, of which the shorter one falls behind."""

HALF, WIDTH, STRESS, TOUGHNESS, V_MAX = 0.02, 0.8, 1.5, 1.0, 0.01  # m, m, MPa, MPa sqrt(m), m/s
SHORT = 0.018  # m, half of the shorter crack
PLATE = """
title: Crack in tension that grows slowly
source: closed form of the crack in a wide plate
units: {length: mm, stress: MPa}
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 800, height: 800}}
    material: {young: 30000, poisson: 0.2}
    strength: {tension: 5, cohesion: 20, friction_angle: 40, toughness: 1 MPa sqrt(m)}
cracks: {flaw: {path: {center: [0, 0], length: 40, angle: 0}, contact: none}}
supports: minimal
loads:
  - {on: {body: rock, edge: top}, traction: [0, 1.5]}
  - {on: {body: rock, edge: bottom}, traction: [0, -1.5]}
growth:
  {steps: 1, increment: 5, advance: all, criterion: max_hoop_stress, direction: explicit, law: subcritical,
   subcritical: {velocity: 10 mm/s, exponent: 2}}
numerics: {spacing: 20, refine: {tips: 3}}
output: {figures: false, frames: none}
"""


def error_of_time(exponent: int, increment: float, folder: Path) -> float:
    """What the time is off by, relative, in which the crack has come to twice its length in increments (mm)."""
    path = folder / "plate.yaml"
    path.write_text(PLATE, encoding="utf-8")
    settings = (f"growth.increment={increment}", f"growth.steps={round(20 / increment)}")
    results, _ = whole_run(load_case(path, [*settings, f"growth.subcritical.exponent={exponent}"]))

    def intensity(a: float) -> float:
        return float(STRESS * np.sqrt(np.pi * a / np.cos(np.pi * a / WIDTH)))

    c = 1e-6 * results[0].tips[0].K_I / intensity(HALF)
    assert c == pytest.approx(1.0, abs=0.01)

    def slowness(a: float) -> float:
        return float(1.0 / (V_MAX * (c * intensity(a) / TOUGHNESS) ** exponent))

    exact, _ = quad(slowness, HALF, 0.5 * results[-1].crack_length, epsrel=1e-10)
    return results[-1].time / exact - 1.0


@pytest.mark.parametrize("exponent", [2, 10])
def test_time_in_which_a_crack_doubles_its_length(exponent: int, tmp_path: Path) -> None:
    """With n = 2: 0.6, -0.2, -0.4 % measured; with n = 10: 4.9, 0.6, -0.7 %."""
    error = [error_of_time(exponent, increment, tmp_path) for increment in (10.0, 5.0, 2.5)]
    assert abs(error[2]) < 0.01
    assert abs(error[0] - error[1]) > 3.0 * abs(error[1] - error[2])


def too_far(increment: float, folder: Path) -> float:
    """By what part of its growth the shorter crack is ahead, when the longer one has come to twice its length.

    With n = 5 both obey a^(-3/2) = a_0^(-3/2) - C t, with one C, but for what they know of each other and the edges.
    The increments are in mm.
    """
    path = folder / "plate.yaml"
    path.write_text(PLATE, encoding="utf-8")
    settings = (*TWO, f"growth.increment={increment}", f"growth.steps={round(20 / increment)}")
    results, _ = whole_run(load_case(path, settings))
    half = {each.name: 0.5 * float(np.hypot(*np.diff(each.points, axis=0).T).sum()) for each in results[-1].cracks}
    assert half["long"] == pytest.approx(2.0 * HALF, rel=0.01)
    exact = (half["long"] ** -1.5 - HALF**-1.5 + SHORT**-1.5) ** (-1.0 / 1.5)
    return (half["short"] - exact) / (exact - SHORT)


def test_a_slower_crack_comes_as_far_as_its_velocity_takes_it(tmp_path: Path) -> None:
    """To the order of two in the increment: 3.2, 0.6 % measured.

    By the velocities at the beginning of each step alone it came 7.6 and 4 % too far.
    """
    coarse, fine = (too_far(increment, tmp_path) for increment in (5.0, 2.5))
    assert abs(fine) < 0.01
    assert abs(fine) < 0.35 * abs(coarse)


def test_time_goes_on_where_the_fastest_tip_slows_while_another_waits(tmp_path: Path) -> None:
    """What the other one was short of was 20 increments, and the next step began before the one before."""
    path = tmp_path / "plate.yaml"
    path.write_text(PLATE, encoding="utf-8")
    settings = (
        "cracks={wedged: {path: {center: [-150, 0], length: 10, angle: 0}, contact: none}, "
        "slow: {path: {center: [150, 0], length: 40, angle: 0}, contact: none}}",
        'loads=[{crack: wedged, pressure: "20*exp(-((x+150)/2)**2)"}, {crack: slow, pressure: 2.08}]',
        "growth.subcritical.exponent=20",
        "growth.steps=4",
        "numerics.refine.tips=4",
    )
    results, _ = whole_run(load_case(path, settings))
    assert np.all(np.diff([result.time for result in results]) > 0.0)
