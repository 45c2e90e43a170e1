"""The course of named points: exact fields, the increments of a step, files, resuming, faults."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from crackgrow.__main__ import main
from crackgrow.case.load import read_case
from crackgrow.run.loop import grow, solved_steps
from crackgrow.run.result import History
from tests.scenes import shipped_case
from tests.whole_run import steps_of

YOUNG, STRESS = 1e9, 1e6  # Pa

BAR = """
title: a bar
plane: stress
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 0.02, height: 0.04}}
    material: {young: 1e9, poisson: 0.25}
supports:
  - {on: {body: rock, edge: bottom}, displacement: {y: 0}}
  - {at: [0, -0.02], displacement: {x: 0}}
loads: [{on: {body: rock, edge: top}, traction: [0, 1e6]}]
loading: {history: [0.5, -1]}
numerics: {spacing: 0.004}
output: {frames: none, figures: false, points: {corner: {at: [0.01, 0.02]}, gauge: {between: [[0, -0.01], [0, 0.01]]}}}
"""

STACK = """
title: a block on another
plane: strain
bodies:
  low: {shape: {rectangle: {center: [0, 0.05], width: 0.2, height: 0.1}}, material: {young: 1e9, poisson: 0.2}}
  top: {shape: {rectangle: {center: [0, 0.15], width: 0.1, height: 0.1}}, material: {young: 1e9, poisson: 0.2}}
interfaces: [{between: [low, top], contact: {friction: 0.2, cohesion: 0}}]
supports:
  - {on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}
  - {on: {body: top, edge: top}, displacement: {x: 0.001}}
loads: [{on: {body: top, edge: top}, traction: [0, -1e6], held: true}]
loading: {history: [1, -1]}
numerics: {spacing: 0.02}
output:
  frames: none
  figures: false
  points: {joint: {interface: [top, low], at: [0, 0.1]}, above: {at: [0, 0.1], body: top}}
"""

NOTCHED = """
title: a notched plate
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 0.02, height: 0.04}}
    material: {young: 1e9, poisson: 0.25}
    strength: {tension: 1e6, cohesion: 1e8, friction_angle: 30}
cracks: {notch: {path: {points: [[-0.01, 0], [-0.004, 0]]}, tips: end, contact: {friction: 0, cohesion: 0}}}
supports:
  - {on: {body: rock, edge: bottom}, displacement: {y: 0}}
  - {at: [0, -0.02], displacement: {x: 0}}
loads: [{on: {body: rock, edge: top}, traction: [0, 1e6]}]
loading: {history: [0.5, 1]}
growth: {steps: 2, increment: 0.002, advance: all, criterion: max_hoop_stress, tip_stress: {radius: 0.0005}}
numerics: {spacing: 0.002}
output: {frames: none, figures: false, points: {mouth: {crack: notch, at: [-0.01, 0]}}}
"""

FLAW_ON_ITS_WAY = (
    "growth.steps=0",
    "numerics.spacing=1.5",
    "cracks.flaw.contact.friction=0.3",
    "cracks.flaw.contact.cohesion=2",
    "output.points={mouth: {crack: flaw, at: [0, 0]}}",
    "output.figures=false",
    "output.frames=none",
)


def histories(text: str, *overrides: str) -> list[History]:
    found = [result.history for result in steps_of(text, *overrides)]
    assert all(found)
    return [history for history in found if history is not None]


def column(history: History, name: str) -> np.ndarray:
    return history.values[:, history.columns.index(name)]


def test_points_of_a_bar_in_tension_have_its_exact_fields() -> None:
    for history, factor in zip(histories(BAR), (0.5, -1.0), strict=True):
        strain = factor * STRESS / YOUNG
        assert history.load_factor.tolist() == [factor]
        assert column(history, "corner.u_y") == pytest.approx([0.04 * strain], rel=1e-9)
        assert column(history, "corner.u_x") == pytest.approx([-0.25 * 0.01 * strain], rel=1e-9)
        assert column(history, "corner.stress_yy") == pytest.approx([factor * STRESS], rel=1e-9)
        assert column(history, "corner.stress_xy") == pytest.approx([0.0], abs=1e-3)
        assert column(history, "gauge.convergence") == pytest.approx([-0.02 * strain], rel=1e-8)
        assert column(history, "supports.0.force_y") == pytest.approx([-0.02 * factor * STRESS], rel=1e-9)


def test_increments_inside_a_step_follow_the_friction() -> None:
    """The block is pushed, slips, and is pushed back: shear rises to its limit, stays, and turns round."""
    forward, back = histories(STACK)
    assert len(forward.load_factor) > 2
    assert np.all(np.diff(forward.load_factor) > 0.0)
    assert np.all(np.diff(back.load_factor) < 0.0)
    limit = 0.2 * 1e6 * 0.1  # N/m: friction times the weight on top
    pull = np.concatenate([column(some, "low/top.force_x") for some in (forward, back)])
    assert np.abs(pull).max() <= limit * (1.0 + 1e-6)
    assert abs(column(forward, "low/top.force_x")[-1]) == pytest.approx(limit, rel=1e-6)
    assert column(back, "low/top.force_x")[-1] == pytest.approx(-column(forward, "low/top.force_x")[-1], rel=1e-6)
    slip = column(forward, "joint.slip")
    assert slip[-1] != 0.0
    assert np.sign(column(back, "joint.slip")[-1]) == -np.sign(slip[-1])


def test_the_way_to_a_critical_load_is_that_of_the_load_itself() -> None:
    """A flaw that sticks up to its cohesion and slips: slip lies on the line of one increment to the same load."""
    strong = "bodies.rock.strength={tension: 60, cohesion: 100, friction_angle: 40}"
    settings = (
        *FLAW_ON_ITS_WAY,
        strong,
        "growth.criterion=max_hoop_stress",
        "cracks.flaw.contact.cohesion_after_slip=kept",
    )

    def under(loading: str) -> History:
        found = next(grow(shipped_case("compression30", [*settings, f"loading={loading}"]))).history
        assert found is not None
        return found

    rising = under("critical")
    known = under(f"{{history: [{float(rising.load_factor[-1])!r}]}}")
    assert len(rising.load_factor) > len(known.load_factor) > 1  # it makes for other loads first
    assert np.all(np.diff(rising.load_factor) > 0.0)
    slip = np.interp(rising.load_factor, known.load_factor, column(known, "mouth.slip"))
    np.testing.assert_allclose(column(rising, "mouth.slip"), slip, rtol=0, atol=1e-7 * np.abs(slip).max())


def test_history_is_a_file_that_a_resumed_run_goes_on_with(tmp_path: Path) -> None:
    case = tmp_path / "scene.yaml"
    case.write_text(NOTCHED, encoding="utf-8")
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert main(["run", str(case), "--out", str(whole), "--quiet"]) == 0
    assert main(["run", str(case), "--out", str(parts), "--quiet", "--set", "growth.steps=1"]) == 0
    assert main(["run", str(case), "--out", str(parts), "--quiet", "--resume"]) == 0
    text = (whole / "history.csv").read_text(encoding="utf-8")
    assert (parts / "history.csv").read_text(encoding="utf-8") == text
    rows = list(csv.DictReader(text.splitlines()))
    assert [(row["step"], row["increment"]) for row in rows] == [(s, i) for s in "012" for i in "01"]
    assert "Opening and slip at points" in (whole / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("pressed", ["whole", "loose"])
def test_states_found_together_are_those_found_alone(pressed: str) -> None:
    """Of a flaw on its way to slip, and of a block that contact alone holds: displacements and support forces."""
    flaw = pressed == "whole"
    case = shipped_case("compression30", FLAW_ON_ITS_WAY) if flaw else read_case(STACK, "stack", "stack")
    _, solution = next(iter(solved_steps(case)))
    states = [*solution.passed, solution.state]
    assert len(states) > 1
    assert (solution.contact.loose is None) == (pressed == "whole")
    together = solution.configuration.displacements([(state.level, state.states) for state in states])
    for (u, multipliers), state in zip(together, states, strict=True):
        outcome = state.outcome
        np.testing.assert_allclose(u, outcome.u, atol=1e-10 * np.abs(outcome.u).max())
        size = np.abs(solution.configuration.scaled).max()
        np.testing.assert_allclose(multipliers, outcome.multipliers, atol=1e-9 * size)
