"""A target of another quantity than K: its bound holds, cells are halved for it, and what lacks it is told."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.errors import CaseError
from crackgrow.run import grow
from crackgrow.run import target as target_file
from crackgrow.run.caution import Cause
from crackgrow.run.halvings import Accuracy, Halvings, accuracy_of_record, record_of
from crackgrow.run.result import Checkpoint, StepResult

CASES = Path(__file__).parents[3] / "cases"
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")


def case(name: str, goal: str, target: str, *settings: str) -> Case:
    aim = [f"numerics.goal={goal}", f"numerics.accuracy={target}", "numerics.spacing=auto"]
    return load_case(CASES / f"{name}.yaml", [*aim, *settings, *QUIET])


def told(step: StepResult) -> list[str]:
    return [caution.words for caution in step.cautions if caution.cause is Cause.TARGET]


@pytest.mark.parametrize("target", ["3 %", "0.3 %"])
def test_the_force_of_an_interface_is_within_the_target_and_the_bound(target: str) -> None:
    """635.76 and 214.29 MN/m by an independent code, good to 0.1 %."""
    step = next(grow(case("interface_friction04", "reaction", target)))
    force = next(reaction.force for reaction in step.reactions if reaction.where == "supports.0")
    exact = np.array([-214.29e6, 635.76e6])
    off = 100.0 * float(np.hypot(*(force - exact)) / np.hypot(*exact))
    assert told(step) == []
    assert step.goal_error <= float(target.removesuffix(" %"))
    assert off <= step.goal_error + 0.1


def test_slip_is_within_the_target_and_the_bound() -> None:
    """86.086 nm by an independent code, at the middle of the flaw, where slip is largest."""
    step = next(grow(case("compression30", "slip", "1 %")))
    slip = float(np.abs(step.faces[0].slip).max())
    assert told(step) == []
    assert step.goal_error <= 1.0
    assert 100.0 * abs(slip / 8.6086e-5 - 1.0) <= step.goal_error


def test_a_critical_load_is_within_the_target_and_the_bound() -> None:
    settings = ("loading=critical", "growth.steps=0", "growth.criterion=max_hoop_stress")
    coarse, fine = (next(grow(case("compression30", "load_factor", target, *settings))) for target in ("3 %", "0.3 %"))
    assert told(coarse) == told(fine) == []
    assert coarse.goal_error <= 3.0
    assert fine.goal_error <= 0.3
    assert 100.0 * abs(coarse.load_factor / fine.load_factor - 1.0) <= coarse.goal_error + fine.goal_error


def test_a_smaller_target_takes_more_unknowns() -> None:
    sizes = [next(grow(case("interface_friction04", "slip", target))).n_dofs for target in ("10 %", "1 %")]
    assert sizes[0] < sizes[1]


def test_K_is_told_beside_another_goal_by_its_own_bound() -> None:
    step = next(grow(case("compression30", "slip", "3 %")))
    assert all(0.0 < tip.K_II_error < 0.2 * abs(tip.K_II) for tip in step.tips)
    assert math.isnan(next(grow(case("compression30", "K", "3 %"))).goal_error)


def test_a_run_that_was_broken_off_goes_on_to_the_same_bits() -> None:
    aim = case("compression30", "slip", "3 %", "growth.steps=2")
    whole = list(grow(aim))
    kept = whole[1].checkpoint
    assert kept is not None
    rest = list(grow(aim, Checkpoint(kept.step, json.loads(json.dumps(kept.values)), kept.arrays)))
    assert [(step.goal_error, step.n_dofs) for step in rest] == [(step.goal_error, step.n_dofs) for step in whole[1:]]


def test_what_is_known_comes_back_from_plain_data() -> None:
    for goal in (0.25, math.inf):
        known = Accuracy(Halvings(2, (1,), 3), ((0, True),), (1.0,), 7.0, goal=goal)
        again = accuracy_of_record(json.loads(json.dumps(record_of(known))))
        assert (again.halvings, again.goal, again.shares()) == (known.halvings, goal, [goal])


def test_a_goal_that_does_not_converge_ends_with_what_was_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block that sticks everywhere does not slip but for what the contact's averages leave, which never settles."""
    monkeypatch.setattr(target_file, "MOST_UNKNOWNS", 5000)
    step = next(grow(case("block_foundation", "slip", "1 %")))
    (words,) = told(step)
    assert words.startswith("slip is asked for within 1 %")
    assert "at most 5,000" in words
    assert step.n_dofs <= 5000


def test_reactions_that_are_nothing_are_told() -> None:
    (words,) = told(next(grow(case("compression30", "reaction", "1 %"))))
    assert "it is nothing" in words


@pytest.mark.parametrize(
    ("name", "goal", "words"),
    [
        ("block_rigid", "K", "no crack has a tip"),
        ("interface_friction04", "K", "no crack has a tip"),
        ("compression30", "load_factor", "loading: critical"),
        ("compression30", "stiffness", "K | slip | reaction | load_factor"),
    ],
)
def test_a_goal_that_the_scene_does_not_have_is_refused(name: str, goal: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        case(name, goal, "1 %")
    (fault,) = caught.value.faults
    assert fault.key == "numerics.goal" or "numerics.goal" in str(fault)
    assert words in str(fault)


def test_a_scene_where_nothing_slips_has_no_slip_to_aim_at(tmp_path: Path) -> None:
    text = (CASES / "edge_tension.yaml").read_text()
    file = tmp_path / "plain.yaml"
    file.write_text(text[: text.index("cracks:")] + text[text.index("supports:") :])
    with pytest.raises(CaseError, match="nothing slips"):
        load_case(file, ["numerics.accuracy=1 %", "numerics.spacing=auto", "numerics.goal=slip"])
    step = next(grow(load_case(file, ["numerics.accuracy=standard", "numerics.goal=slip", *QUIET])))
    assert told(step) == []  # presets take no notice
