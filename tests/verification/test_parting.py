"""K of cracks whose faces part over a stretch next to a tip, and lose the cohesion there that slip has left them.

Where they part far from the tip cells are large, on other cells, too. Where they part so near to the tip that no
contact point is open K_I is that of cells too large for the pressure, and far too large.

A fluid takes the pressure off a flaw in a wide plate, more so towards its end: the faces part over the last stretch.
With the pressure g (x0 - x) that is left, the stretch is 2 l = 4 (a - x0) / 3 long, since K_I is zero at its inner end,
and K_I = g l sqrt(pi l) at the tip. Without friction the shear c of the cohesion is missing there alone:

    K_II = (t - c) sqrt(pi a) + c / sqrt(pi a) times the integral over the stretch of sqrt((a + x) / (a - x))
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.accuracy.companion import BOUND
from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.caution import Cause
from crackgrow.run.result import TipResult

HALF, SHEAR, COHESION = 0.01, 5e6, 3e6  # m, Pa
WIDE = 0.0007
"""What a plate 40 times as wide as the flaw is long adds to K, of itself."""

PLATE = """
title: Faces that part next to a tip
units: {{length: mm, stress: MPa}}
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 800, height: 800}}}}
    material: {{young: 10000, poisson: 0.2}}
    strength: {{tension: 5, cohesion: 10, friction_angle: 30}}
cracks:
  flaw:
    path: {{points: [[-10, 0], [10, 0]]}}
    contact: {{friction: 0, cohesion: {cohesion}, cohesion_after_slip: kept}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [5, -10]}}
  - {{on: {{body: rock, edge: bottom}}, traction: [-5, 10]}}
  - {{on: {{body: rock, edge: right}}, traction: [0, 5]}}
  - {{on: {{body: rock, edge: left}}, traction: [0, -5]}}
  - {{crack: flaw, pressure: "10 + {slope} * (x - {zero})"}}
supports: minimal
numerics: {{accuracy: {target}}}
output: {{figures: false, frames: none, report: false}}
"""


def end_of_flaw(
    folder: Path, slope: float, zero: float, target: str, cohesion: float = 1e-6 * COHESION
) -> tuple[TipResult, bool]:
    """The end, and whether the run says that its target is missed."""
    file = folder / "scene.yaml"
    file.write_text(PLATE.format(slope=slope, zero=zero, target=target, cohesion=cohesion))
    step = next(grow(load_case(file)))
    told = any(caution.cause is Cause.TARGET for caution in step.cautions)
    return next(tip for tip in step.tips if tip.tip == "end"), told


def exact(slope: float, zero: float) -> tuple[float, float]:
    """K_I and K_II of the end, Pa sqrt(m)."""
    half = 2.0 * (HALF - 1e-3 * zero) / 3.0  # l
    angle = np.arcsin(1.0 - 2.0 * half / HALF)  # x = a sin(angle) where the stretch begins
    shear_there = COHESION * np.sqrt(HALF / np.pi) * (np.pi / 2.0 - angle + np.cos(angle))
    return 1e9 * slope * half * np.sqrt(np.pi * half), (SHEAR - COHESION) * np.sqrt(np.pi * HALF) + shear_there


@pytest.mark.parametrize(("slope", "zero"), [(0.5, 9.8), (0.5, 9.0), (0.2, 9.5)])
@pytest.mark.parametrize("target", [3.0, 1.0, 0.3])
def test_what_is_asked_for_is_reached(tmp_path: Path, slope: float, zero: float, target: float) -> None:
    (tip, told), (K_I, K_II) = end_of_flaw(tmp_path, slope, zero, f"{target} %"), exact(slope, zero)
    assert (tip.K_II_error > BOUND * 1e-2 * target * tip.K_II) == told
    assert not told or target < 1.0
    assert abs(tip.K_II - K_II) <= tip.K_II_error + WIDE * K_II
    assert abs(tip.K_I - K_I) <= tip.K_I_error


@pytest.mark.parametrize(("slope", "zero"), [(0.5, 9.8), (0.5, 9.0), (0.2, 9.5)])
@pytest.mark.parametrize("name", ["draft", "standard"])
def test_the_bound_of_a_name_knows_of_a_stretch_that_its_cells_do_not_see(
    tmp_path: Path, slope: float, zero: float, name: str
) -> None:
    (tip, _), (_, K_II) = end_of_flaw(tmp_path, slope, zero, name), exact(slope, zero)
    assert abs(tip.K_II - K_II) <= tip.K_II_error


def off_without_cohesion(folder: Path, slope: float, zero: float, accuracy: str) -> tuple[float, TipResult, bool]:
    """What K of the end is off by, beyond what the plate adds, Pa sqrt(m); the end, and whether a miss is told."""
    (tip, told), (K_I, _) = end_of_flaw(folder, slope, zero, accuracy, cohesion=0.0), exact(slope, zero)
    K_II = SHEAR * np.sqrt(np.pi * HALF)
    return float(np.hypot(tip.K_I - K_I, tip.K_II - K_II) - WIDE * np.hypot(K_I, K_II)), tip, told


@pytest.mark.parametrize(("slope", "zero"), [(3.0, 6.0), (5.0, 6.0), (5.0, 7.0)])
@pytest.mark.parametrize("accuracy", ["draft", "standard", "3 %", "1 %", "0.3 %"])
def test_the_bound_knows_of_pressure_where_faces_part_far_from_the_tip(
    tmp_path: Path, slope: float, zero: float, accuracy: str
) -> None:
    off, tip, told = off_without_cohesion(tmp_path, slope, zero, accuracy)
    assert off <= max(tip.K_I_error, tip.K_II_error)
    assert not told


@pytest.mark.parametrize("slope", [0.5, 5.0, 50.0])
@pytest.mark.parametrize("zero", [9.9, 9.6, 9.3])
@pytest.mark.parametrize("accuracy", ["draft", "standard", "3 %", "1 %", "0.3 %"])
def test_the_bound_holds_where_a_tip_opens_more_closely_than_any_contact_point_sees(
    tmp_path: Path, slope: float, zero: float, accuracy: str
) -> None:
    off, tip, _ = off_without_cohesion(tmp_path, slope, zero, accuracy)
    assert off <= tip.K_I_error
