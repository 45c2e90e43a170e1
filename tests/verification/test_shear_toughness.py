"""Growth in shear at the toughness that is given, of a closed crack that slides under uniaxial compression p.

At 45 degrees the crack is pressed by p/2 and sheared by p/2, so that K_II = (1 - mu) p/2 sqrt(pi a). Ahead of it the
shear stress is mu p/2 + (1 - mu) p/2 x / sqrt(x^2 - a^2), and averages over R to mu p/2 + (1 - mu) p/2 sqrt(1 + 2a/R).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import Case, load_case
from crackgrow.case.toughness import shear_radius_of
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene

TOUGHNESS = 1e6  # Pa sqrt(m), in shear
HALF_LENGTH = 0.01  # m

PLATE = """
title: a closed crack in a wide plate
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 0.2, height: 0.2}}}}
    material: {{young: 1e10, poisson: 0.25}}
    strength:
      tension: 8e6
      cohesion: {cohesion}
      friction_angle: {phi}
      toughness: 3 MPa sqrt(m)
      shear_toughness: 1 MPa sqrt(m)
cracks:
  fault: {{path: {{center: [0, 0], length: 0.02, angle: 45}}, contact: {{friction: {friction}, cohesion: 0}}}}
supports:
  - {{on: {{body: rock, edge: bottom}}, displacement: {{y: 0}}}}
  - {{at: [0, -0.1], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [0, -1e6]}}
loading: critical
growth: {{steps: 0, increment: 0.002, advance: all, criterion: max_hoop_stress, initiation: ends}}
numerics: {{spacing: 0.004, refine: {{tips: {halvings}}}}}
output: {{frames: none, figures: false, report: false}}
"""


def cohesion_of(radius: float) -> float:
    """The cohesion (Pa) by which the toughness stands for a radius (m)."""
    return 2.0 * TOUGHNESS / float(np.sqrt(2.0 * np.pi * radius))


def just_grows(folder: Path, **values: float) -> tuple[Case, StepSolution]:
    """The crack, as one that has started in shear, where it just goes on."""
    path = folder / "plate.yaml"
    path.write_text(PLATE.format(**values), encoding="utf-8")
    case = load_case(path)
    cracks = tuple(replace(GrowingCrack.given(crack), in_shear=True) for crack in case.cracks)
    found = critically_loaded(assemble(make_scene(case), cracks), 1.0)
    assert [tip.verdict.mode for tip in found.tips if tip.verdict] == ["shear", "shear"]
    return case, found


@pytest.mark.parametrize(("friction", "phi"), [(0.0, 0.0), (0.3, 16.69924), (0.3, 0.0), (0.3, 32.0)])
def test_a_long_crack_goes_straight_on_at_the_toughness_and_the_pressure_it_is_pressed_by(
    friction: float, phi: float, tmp_path: Path
) -> None:
    """Where the rock has the friction of the faces the pressure does not count; else by what it has more.

    R is a hundredth of the length, by which K_II is 0.5 % smaller.
    """
    cohesion = cohesion_of(0.01 * 2.0 * HALF_LENGTH)
    _, found = just_grows(tmp_path, friction=friction, phi=phi, cohesion=cohesion, halvings=5)
    pressure = 0.5e6 * found.state.factor
    expected = TOUGHNESS * (1.0 + (np.tan(np.deg2rad(phi)) - friction) * pressure / cohesion)
    assert [abs(tip.K[1]) for tip in found.tips] == pytest.approx([expected] * 2, rel=0.01)
    assert [tip.verdict.kink for tip in found.tips if tip.verdict] == pytest.approx([0.0] * 2, abs=np.deg2rad(1.0))


@pytest.mark.parametrize("part", [0.1, 1.0, 2.0])
def test_a_short_crack_goes_by_the_average_over_the_radius(part: float, tmp_path: Path) -> None:
    """K_II = K_IIc / sqrt(1 + R / 2a): a length R over which stress suffices, and the energy of an advance by R."""
    cohesion = cohesion_of(part * 2.0 * HALF_LENGTH)
    assert shear_radius_of(cohesion, TOUGHNESS) == pytest.approx(part * 2.0 * HALF_LENGTH, rel=1e-12)
    _, found = just_grows(tmp_path, friction=0.3, phi=16.69924, cohesion=cohesion, halvings=3)
    expected = TOUGHNESS / np.sqrt(1.0 + part)
    assert [abs(tip.K[1]) for tip in found.tips] == pytest.approx([expected] * 2, rel=0.01)


@pytest.mark.parametrize("halvings", [0, 1, 2])
def test_cells_do_not_decide(halvings: int, tmp_path: Path) -> None:
    """A radius of a tenth of the length, in cells of twice, once and half of it; friction more than the faces'."""
    cohesion, tangent = cohesion_of(0.1 * 2.0 * HALF_LENGTH), np.tan(np.deg2rad(32.0))
    _, found = just_grows(tmp_path, friction=0.3, phi=32.0, cohesion=cohesion, halvings=halvings)
    expected = 2.0 * cohesion / (0.7 * np.sqrt(11.0) + 0.3 - tangent)
    assert 1e6 * found.state.factor == pytest.approx(expected, rel=0.01)
