"""Tractions and pressures that vary with the place, and forces at points: closed forms, balance, units, faults."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.load import read_case
from crackgrow.errors import CaseError
from crackgrow.run.result import StepResult
from tests.whole_run import steps_of

pytestmark = pytest.mark.physics

BEAM = """
title: pure bending
plane: stress
units: {length: mm, stress: MPa}
bodies: {beam: {shape: {rectangle: {center: [0, 0], width: 80, height: 20}}, material: {young: 1000, poisson: 0.25}}}
supports:
  - {at: [0, 0], displacement: {x: 0, y: 0}}
  - {at: [30, 0], displacement: {y: 0}}
loads:
  - {on: {body: beam, edge: right}, traction: ["0.1*y", 0]}
  - {on: {body: beam, edge: left}, traction: ["-0.1*y", 0]}
numerics: {spacing: 2}
output: {frames: none, figures: false, points: {lower: {at: [10, -10]}, upper: {at: [-7, 6]}}}
"""

CRACKED = """
title: a crack under a pressure that varies along it
plane: strain
bodies: {rock: {shape: {rectangle: {center: [0, 0], width: 0.4, height: 0.4}}, material: {young: 1e10, poisson: 0.2}}}
cracks: {flaw: {path: {center: [0, 0], length: 0.04, angle: 0}, contact: none}}
supports:
  - {at: [-0.2, -0.2], displacement: {x: 0, y: 0}}
  - {at: [0.2, -0.2], displacement: {y: 0}}
loads: [{crack: flaw, pressure: "1e6*(1 + x/0.02)"}]
numerics: {spacing: 0.005, refine: {tips: 1}}
output: {frames: none, figures: false}
"""

PUSHED = """
title: a block that a point pushes
plane: strain
bodies: {rock: {shape: {rectangle: {center: [0, 0.5], width: 1, height: 1}}, material: {young: 1e9, poisson: 0.2}}}
supports: [{on: {body: rock, edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{at: [0.1, 1], force: [2 kN/m, -5000 N/m]}]
numerics: {spacing: 0.1}
output: {frames: none, figures: false, points: {side: {at: [-0.5, 0.5]}}}
"""


def solved(text: str) -> StepResult:
    return steps_of(text)[0]


def seen(result: StepResult, name: str) -> float:
    assert result.history is not None
    return float(result.history.values[-1, result.history.columns.index(name)])


def test_tractions_that_vary_along_an_edge_bend_a_beam() -> None:
    """sigma_xx = 0.1 MPa/mm y everywhere, in a case in mm and MPa."""
    result = solved(BEAM)
    assert seen(result, "lower.stress_xx") == pytest.approx(-1e6, rel=0.01)
    assert seen(result, "upper.stress_xx") == pytest.approx(0.6e6, rel=0.01)
    assert abs(seen(result, "upper.stress_xy")) < 1e4
    for reaction in result.reactions:
        assert np.hypot(*reaction.force) < 1e-3


def test_pressure_that_varies_along_a_crack_has_the_K_of_the_closed_form() -> None:
    """p (1 + x/a): K_I = p sqrt(pi a) (F +- 1/2) at the two tips; F = 1.014 in a square plate ten times as wide."""
    result = solved(CRACKED)
    K = 1e6 * np.sqrt(np.pi * 0.02)
    by_tip = {tip.tip: tip.K_I for tip in result.tips}
    assert by_tip["end"] == pytest.approx(1.514 * K, rel=0.003)
    assert by_tip["start"] == pytest.approx(0.514 * K, rel=0.003)


def test_force_at_a_point_is_from_afar_a_traction_on_a_short_edge() -> None:
    edge = "{on: {body: rock, edge: top, from: 0.05, to: 0.15}, traction: [20 kPa, -50 kPa]}"
    point = PUSHED.split("loads: [")[1].split("]\nnum")[0]
    result, other = solved(PUSHED), solved(PUSHED.replace(point, edge))
    assert result.reactions[0].force == pytest.approx((-2000.0, 5000.0), rel=1e-9)
    assert any("acts on a point" in text for text in result.warnings)
    for column in ("side.u_x", "side.u_y", "side.stress_yy"):
        assert seen(result, column) == pytest.approx(seen(other, column), rel=0.02)


@pytest.mark.parametrize(
    ("text", "old", "new", "key", "words"),
    [
        (BEAM, '["0.1*y", 0]', '["1/y", 0]', "loads.0.traction.0", "no finite value at"),
        (BEAM, '["0.1*y", 0]', '["0.1 mm", 0]', "loads.0.traction.0", "has a unit of length"),
        (CRACKED, '"1e6*(1 + x/0.02)"', '"log(x)"', "loads.0.pressure", "no finite value at"),
        (PUSHED, "at: [0.1, 1]", "at: [0.1, 1.2]", "loads.0.at", "outside of body 'rock', 0.2 m from it"),
        (PUSHED, "2 kN/m", "2 kPa", "loads.0.force.0", "has a unit of stress"),
    ],
)
def test_faults(text: str, old: str, new: str, key: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        read_case(text.replace(old, new), "scene", "scene")
    fault = next(fault for fault in caught.value.faults if fault.key == key)
    assert words in fault.message
