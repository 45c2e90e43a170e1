"""Growth at the toughness that is given: in mode I by every criterion, and of wings from a closed flaw.

A straight closed flaw at an angle t to the load's normal slips under p with tau = p (sin t cos t - mu cos^2 t), so that
K_II = tau sqrt(pi a); the hoop stress of K_II alone is largest at 70.5 degrees, where K_eq = 2 K_II / sqrt(3).
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import Case, load_case
from crackgrow.case.toughness import MODE_I
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import CRITERIA
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.critical_load import critically_loaded
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
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


PRESSED = """
title: a crack in a wide plate that a fluid and the rock press
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 1.2, height: 1.2}}}}
    material: {{young: 2e10, poisson: 0.2}}
    strength: {{tension: {tension}, cohesion: 1e9, friction_angle: 30, toughness: 1 MPa sqrt(m)}}
cracks:
  hf: {{path: {{points: [[-0.03, 0], [0.03, 0]]}}, contact: {{friction: 0.6, cohesion: 0}}}}
supports: minimal
loads:
  - {{on: {{edge: top}}, traction: [0, -{pressure}], held: true}}
  - {{on: {{edge: bottom}}, traction: [0, {pressure}], held: true}}
  - {{on: {{edge: left}}, traction: [{along}, 0], held: true}}
  - {{on: {{edge: right}}, traction: [-{along}, 0], held: true}}
  - {{crack: hf, pressure: {pressure}, held: true}}
  - {{on: {{edge: top}}, traction: [0, 1e6]}}
  - {{on: {{edge: bottom}}, traction: [0, -1e6]}}
loading: critical
growth: {{steps: 0, increment: 0.01, advance: all, criterion: {criterion}}}
numerics: {{spacing: 0.04, refine: {{tips: 5}}}}
"""


@pytest.fixture(scope="module")
def same_cells() -> list[Configuration]:
    """The configuration of the test that came first: the others take from it what loads and strength do not change."""
    return []


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("lengths", [10, 100, 1000])
@pytest.mark.parametrize("pressure", [0, 1, 2, 5, 10])
@pytest.mark.parametrize("along", [0, 10])
def test_mode_I_grows_at_the_toughness_under_any_pressure(
    criterion: str, lengths: int, pressure: int, along: int, same_cells: list[Configuration], tmp_path: Path
) -> None:
    """K_I = sigma sqrt(pi a) is the toughness; the plate's width adds 0.15 % to it.

    The length is that over the averaging radius; a fluid, and the rock across the crack, press by `pressure` and rock
    along it by `along` times the tensile strength: neither has a K. Measured: 0.35 % off, where the average with all of
    the stress would grow at up to 11 times the toughness.
    """
    tension = MODE_I[criterion] * TOUGHNESS / np.sqrt(2.0 * np.pi * 0.06 / lengths)
    path = tmp_path / "pressed.yaml"
    values = {"tension": tension, "pressure": pressure * tension, "along": along * tension}
    path.write_text(PRESSED.format(criterion=criterion, **values), encoding="utf-8")
    case = load_case(path)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    configuration = assemble(make_scene(case), cracks, same_cells[0] if same_cells else None)
    same_cells.append(configuration)
    found = critically_loaded(configuration, 1.0)
    assert 1e6 * found.state.factor * np.sqrt(np.pi * 0.03) == pytest.approx(TOUGHNESS, rel=0.01)
    assert [tip.K[0] for tip in found.tips] == pytest.approx([TOUGHNESS] * 2, rel=0.001)
    assert [tip.K_growth for tip in found.tips] == pytest.approx([TOUGHNESS] * 2, rel=0.001)


ROCK = (
    "{young: 20 GPa, poisson: 0.2}, strength: {tension: 5, cohesion: 15, friction_angle: 40, toughness: 1 MPa sqrt(m)}"
)
IN_THE_GROUND = """
title: a crack that a fluid opens in the ground
units: {length: mm, stress: MPa}
plane: strain
bodies: {rock: {shape: SHAPE, material: ROCK}}
supports: minimal
loads:
  - {on: {edge: top}, traction: [0, -ACROSS], held: true}
  - {on: {edge: bottom}, traction: [0, ACROSS], held: true}
  - {on: {edge: right}, traction: [-ALONG, 0], held: true}
  - {on: {edge: left}, traction: [ALONG, 0], held: true}
FLUID
loading: critical
growth: {steps: 0, increment: 4, advance: all, criterion: CRITERION}
output: {frames: none, figures: false, report: false}
""".replace("ROCK", ROCK)
BREAKDOWN = {
    "SHAPE": "{rectangle: {center: [0, 0], width: 1200, height: 1200}}",
    "ACROSS": "5",
    "ALONG": "12",
    "FLUID": """  - {crack: hf, pressure: 1}
cracks: {hf: {path: {points: [[-30, 0], [30, 0]]}, contact: {friction: 0.6}}}""",
}
NOTCHED = {
    "SHAPE": "{rectangle: {center: [0, 0], width: 400, height: 400}, holes: [{disk: {center: [0, 0], radius: 10}}]}",
    "ACROSS": "10",
    "ALONG": "5",
    "FLUID": """  - {on: {edge: hole0}, pressure: 1}
  - {crack: n1, pressure: 1}
  - {crack: n2, pressure: 1}
cracks:
  n1: {path: {points: [[8.6603, 5], [12.9904, 7.5]]}, contact: {friction: 0.6}, tips: end}
  n2: {path: {points: [[-8.6603, -5], [-12.9904, -7.5]]}, contact: {friction: 0.6}, tips: end}""",
}


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize(
    ("scene", "expected"), [(BREAKDOWN, 5.0 + 1.0 / np.sqrt(np.pi * 0.03)), (NOTCHED, 13.6)], ids=["crack", "borehole"]
)
def test_breakdown_in_the_ground(scene: dict[str, str], expected: float, criterion: str, tmp_path: Path) -> None:
    """Of the crack: sigma_h + K_Ic / sqrt(pi a). Of notches 5 mm long, and of a radius of 15 and 25 mm: by their K.

    With all of the stress in the average these were 16.9 and 20.5 of 8.26 MPa, and 36 and 46 of 13.6.
    """
    text = IN_THE_GROUND
    for key, value in {**scene, "CRITERION": criterion}.items():
        text = text.replace(key, value)
    path = tmp_path / "breakdown.yaml"
    path.write_text(text, encoding="utf-8")
    step = first_step(load_case(path))
    assert step.load_factor == pytest.approx(expected, rel=0.01)
    assert not any("averag" in words for words in step.warnings)


@pytest.mark.parametrize(
    ("angle", "friction", "criterion"),
    [
        *product([30.0, 37.5, 45.0, 52.5, 60.0], [0.0, 0.2, 0.4], ["max_hoop_stress"]),
        *product([45.0], [0.2], ["strength", "directional_strength"]),
    ],
)
def test_wings_of_a_closed_flaw_start_at_the_closed_form(
    angle: float, friction: float, criterion: str, tmp_path: Path
) -> None:
    plate = {"width": 0.2, "half": 0.1, "spacing": 0.004, "halvings": 0, "load": -1e6, "tension": 1e7}
    case = case_of(tmp_path, angle=angle, friction=friction, criterion=criterion, **plate)
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    expected = 0.5 * np.sqrt(3.0) * TOUGHNESS / (np.sqrt(np.pi * HALF_LENGTH) * (s * c - friction * c * c))
    assert 1e6 * first_step(case).load_factor == pytest.approx(expected, rel=0.01)  # 0.6 % of it by the plate's width
