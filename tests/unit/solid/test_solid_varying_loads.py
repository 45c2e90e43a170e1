"""Tractions and pressures that vary with the place, and forces at points: closed forms, balance, units, faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import dump_case, load_case
from crackgrow.errors import CaseError
from crackgrow.run.result import StepResult
from tests.whole_run import whole_run

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


def solved(folder: Path, text: str, *edits: tuple[str, str]) -> StepResult:
    return whole_run(load_case(written(folder, text, *edits)))[0][0]


def written(folder: Path, text: str, *edits: tuple[str, str]) -> Path:
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def seen(result: StepResult, name: str) -> float:
    assert result.history is not None
    return float(result.history.values[-1, result.history.columns.index(name)])


def test_tractions_that_vary_along_an_edge_bend_a_beam(tmp_path: Path) -> None:
    """sigma_xx = 0.1 MPa/mm y everywhere, in a case in mm and MPa."""
    result = solved(tmp_path, BEAM)
    assert seen(result, "lower.stress_xx") == pytest.approx(-1e6, rel=0.01)
    assert seen(result, "upper.stress_xx") == pytest.approx(0.6e6, rel=0.01)
    assert abs(seen(result, "upper.stress_xy")) < 1e4
    for reaction in result.reactions:
        assert np.hypot(*reaction.force) < 1e-3


def test_pressure_that_varies_along_a_crack_has_the_K_of_the_closed_form(tmp_path: Path) -> None:
    """p (1 + x/a): K_I = p sqrt(pi a) (F +- 1/2) at the two tips; F = 1.014 in a square plate ten times as wide."""
    result = solved(tmp_path, CRACKED)
    K = 1e6 * np.sqrt(np.pi * 0.02)
    by_tip = {tip.tip: tip.K_I for tip in result.tips}
    assert by_tip["end"] == pytest.approx(1.514 * K, rel=0.003)
    assert by_tip["start"] == pytest.approx(0.514 * K, rel=0.003)


def test_force_at_a_point_is_from_afar_a_traction_on_a_short_edge(tmp_path: Path) -> None:
    edge = "{on: {body: rock, edge: top, from: 0.05, to: 0.15}, traction: [20 kPa, -50 kPa]}"
    point = PUSHED.split("loads: [")[1].split("]\nnum")[0]
    result, other = solved(tmp_path, PUSHED), solved(tmp_path, PUSHED, (point, edge))
    assert result.reactions[0].force == pytest.approx((-2000.0, 5000.0), rel=1e-9)
    assert any("acts on a point" in text for text in result.warnings)
    for column in ("side.u_x", "side.u_y", "side.stress_yy"):
        assert seen(result, column) == pytest.approx(seen(other, column), rel=0.02)


@pytest.mark.parametrize("text", [BEAM, CRACKED, PUSHED])
def test_case_with_varying_loads_reads_back(text: str, tmp_path: Path) -> None:
    case = load_case(written(tmp_path, text))
    again = tmp_path / "again.yaml"
    again.write_text(dump_case(case), encoding="utf-8")
    assert dump_case(load_case(again)) == dump_case(case)


@pytest.mark.parametrize(
    ("text", "edits", "key", "words"),
    [
        (BEAM, [('["0.1*y", 0]', '["1/y", 0]')], "loads.0.traction.0", "no finite value at"),
        (BEAM, [('["0.1*y", 0]', '["0.1 mm", 0]')], "loads.0.traction.0", "has a unit of length"),
        (CRACKED, [('"1e6*(1 + x/0.02)"', '"log(x)"')], "loads.0.pressure", "no finite value at"),
        (PUSHED, [("at: [0.1, 1]", "at: [0.1, 1.2]")], "loads.0.at", "outside of body 'rock', 0.2 m from it"),
        (PUSHED, [("at: [0.1, 1]", "at: [0.1, 1], body: rok")], "loads.0.body", "did you mean 'rock'?"),
        (PUSHED, [("2 kN/m", "2 kPa")], "loads.0.force.0", "has a unit of stress"),
        (
            PUSHED,
            [("plane: strain", "plane: strain\nunits: {length: mm}"), ("2 kN/m", "2")],
            "loads.0.force.0",
            "needs a",
        ),
    ],
)
def test_faults(text: str, edits: list[tuple[str, str]], key: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(written(tmp_path, text, *edits))
    fault = next(fault for fault in caught.value.faults if fault.key == key)
    assert words in fault.message
