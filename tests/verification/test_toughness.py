"""Growth at the toughness that is given: in mode I by every criterion, and of wings from a closed flaw.

A straight closed flaw at an angle t to the load's normal slips under p with tau = p (sin t cos t - mu cos^2 t), so that
K_II = tau sqrt(pi a); the hoop stress of K_II alone is largest at 70.5 degrees, where K_eq = 2 K_II / sqrt(3).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import Case, load_case
from crackgrow.case.toughness import MODE_I
from crackgrow.fracture.criteria import CRITERIA
from crackgrow.run.result import StepResult
from tests.whole_run import whole_run

TOUGHNESS = 1e6  # Pa sqrt(m)
HALF_LENGTH = 0.01  # m

PLATE = """
title: a flaw in a wide plate
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: {width}, height: {width}}}}}
    material: {{young: 1e10, poisson: 0.25}}
    strength: {{tension: {tension}, cohesion: 1e9, friction_angle: 30, toughness: 1 MPa sqrt(m)}}
cracks:
  flaw: {{path: {{center: [0, 0], length: 0.02, angle: {angle}}}, contact: {{friction: {friction}, cohesion: 0}}}}
supports:
  - {{on: {{body: rock, edge: bottom}}, displacement: {{y: 0}}}}
  - {{at: [0, -{half}], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [0, {load}]}}
loading: critical
growth: {{steps: 0, increment: 0.002, advance: most_critical, criterion: {criterion}}}
numerics: {{spacing: {spacing}, refine: {{tips: {halvings}}}}}
output: {{frames: none, figures: false, report: false}}
"""


def case_of(folder: Path, **values: object) -> Case:
    path = folder / "plate.yaml"
    path.write_text(PLATE.format(**values), encoding="utf-8")
    return load_case(path)


def first_step(case: Case) -> StepResult:
    return whole_run(case)[0][0]


@pytest.mark.parametrize("criterion", CRITERIA)
def test_mode_I_growth_at_the_toughness(criterion: str, tmp_path: Path) -> None:
    """Measured: 4e-10, 0.002 and 0.006 off. The radius is 0.04 of the half length, three cells at the tip."""
    tension = MODE_I[criterion] * TOUGHNESS / np.sqrt(2.0 * np.pi * 0.04 * HALF_LENGTH)
    plate = {"width": 0.1, "half": 0.05, "spacing": 0.002, "halvings": 4, "load": 1e6, "angle": 0, "friction": 0}
    step = first_step(case_of(tmp_path, tension=tension, criterion=criterion, **plate))
    assert step.effective_toughness == pytest.approx(TOUGHNESS, rel=1e-12)
    assert max(tip.criticality for tip in step.tips) == pytest.approx(1.0, abs=1e-9)
    assert [tip.K_I for tip in step.tips] == pytest.approx([TOUGHNESS] * 2, rel=0.01)
    assert not any("averaging radius" in text for text in step.warnings)


@pytest.mark.parametrize("angle", [30.0, 37.5, 45.0, 52.5, 60.0])
@pytest.mark.parametrize("friction", [0.0, 0.2, 0.4])
def test_wings_of_a_closed_flaw_start_at_the_closed_form(angle: float, friction: float, tmp_path: Path) -> None:
    plate = {"width": 0.2, "half": 0.1, "spacing": 0.004, "halvings": 0, "load": -1e6, "tension": 1e7}
    case = case_of(tmp_path, angle=angle, friction=friction, criterion="max_hoop_stress", **plate)
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    expected = 0.5 * np.sqrt(3.0) * TOUGHNESS / (np.sqrt(np.pi * HALF_LENGTH) * (s * c - friction * c * c))
    assert 1e6 * first_step(case).load_factor == pytest.approx(expected, rel=0.01)  # 0.6 % of it by the plate's width
