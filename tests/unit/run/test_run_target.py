"""Cells that are refined for a target, what is told where they can't be, and a run that goes on to the same bits."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.accuracy.companion import BOUND
from crackgrow.case.model import Case
from crackgrow.errors import CaseError, SolveError
from crackgrow.run import grow
from crackgrow.run import target as target_file
from crackgrow.run.caution import Cause
from crackgrow.run.checkpoint import beginning, restored
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import LoadsInTurn, load
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.unit.run.test_run_starting import SQUARE, plate

QUIET = ("output.frames=none", "output.figures=false", "output.report=false")

SHEARED = (
    "growth.steps=2",
    "growth.increment=2",
    "growth.advance=all",
    "growth.initiation=ends",
    "cracks.flaw.contact.friction=0.3",
    "bodies.rock.strength.cohesion=0.6",
)
"""Shear cracks start at the ends of a flaw, beside its wings."""


def case(name: str, accuracy: str, *settings: str) -> Case:
    aim = ("numerics.spacing=auto", f"numerics.accuracy={accuracy}")
    return shipped_case(name, [*aim, *settings, *QUIET])


def shares(step: StepResult) -> list[float]:
    """Error estimates of K over the largest K, tip by tip."""
    largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    return [max(tip.K_I_error, tip.K_II_error) / BOUND / largest for tip in step.tips]


def told(step: StepResult) -> list[str]:
    return [caution.words for caution in step.cautions if caution.cause is Cause.TARGET]


def true_error(aim: Case, step: StepResult, solution: StepSolution) -> float:
    """Of K, over the largest: against cells two levels smaller at all cracks, and everywhere."""
    assert step.checkpoint is not None
    scene, cracks = solution.scene, restored(aim, step.checkpoint).cracks
    grading = scene.grading
    levels = tuple(grading.level(crack) + 2 for crack in range(len(cracks)))
    finer_cells = scene.with_grading(replace(grading, cracks=levels, rest=grading.rest + 1))
    finer = np.array([tip.K for tip in load(finer_cells, cracks).tips])
    off = finer - [(tip.K_I, tip.K_II) for tip in step.tips]
    return float(np.hypot(*off.T).max() / np.hypot(*finer.T).max())


@pytest.mark.parametrize("target", [0.05, 0.02, 0.005])
def test_error_estimates_of_K_are_within_the_target(target: float) -> None:
    for step in grow(case("compression30", f"{100 * target} %", "growth.steps=3")):
        assert max(shares(step)) <= target
        assert told(step) == []
        assert all(tip.K_error_expected < tip.K_I_error for tip in step.tips)


def test_a_smaller_target_takes_more_unknowns() -> None:
    sizes = [next(grow(case("compression30", target))).n_dofs for target in ("20 %", "1 %", "0.1 %")]
    assert sizes[0] < sizes[1] < sizes[2]


def test_a_name_is_a_target() -> None:
    named, asked = (next(grow(case("compression30", accuracy))) for accuracy in ("standard", "1 %"))
    assert [(t.K_I, t.K_II, t.K_I_error) for t in named.tips] == [(t.K_I, t.K_II, t.K_I_error) for t in asked.tips]


def test_cells_by_hand_have_no_error_and_the_run_says_so() -> None:
    step = next(grow(case("compression30", "standard", "numerics.spacing=3")))
    assert all(math.isnan(tip.K_I_error) and math.isnan(tip.K_error_expected) for tip in step.tips)
    assert [caution.cause for caution in step.cautions].count(Cause.UNMEASURED) == 1


def test_cracks_that_start_meet_the_target() -> None:
    """Their cells are small by their own length."""
    aim = case("compression30", "3 %", *SHEARED)
    steps = list(solved_steps(aim))
    step, solution = steps[-1]
    assert [event.kind for event in step.events] == ["initiation", "initiation"]
    assert len(step.tips) == 4
    assert told(step) == []
    assert max(max(shares(each)) for each, _ in steps) <= 0.03
    assert true_error(aim, step, solution) <= 0.03


def test_where_nothing_has_started_yet_there_is_no_K_to_aim_at(tmp_path: Path) -> None:
    """The first crack then meets the target."""
    aim = plate(tmp_path, SQUARE, "anywhere", "numerics.accuracy=3 %", "numerics.spacing=auto", "growth.steps=1")
    first, (step, solution) = solved_steps(aim)
    assert told(first[0]) == told(step) == []
    assert max(shares(step)) <= 0.03
    assert true_error(aim, step, solution) <= 0.03


def test_every_load_of_a_history_meets_the_target() -> None:
    steps = list(grow(case("cyclic_friction", "3 %", "loading.history=[0.5, 1.0, 0.8]")))
    assert len(steps) == 3
    for step in steps:
        assert max(shares(step)) <= 0.03 or told(step)


def test_loads_before_are_paid_for_where_cells_are_made_smaller() -> None:
    """They are gone through again on them; the next load finds all of it made."""
    aim = case("cyclic_friction", "3 %", "loading.history=[0.5, 1.0, 1.1]")
    scene, given = make_scene(aim), beginning(aim).cracks
    again = LoadsInTurn(scene, given)
    second, third = again.solution(1), again.solution(2)
    assert [second.factorizations, third.factorizations] == [1, 0]
    assert [solution.seconds["assembly"] > 0.0 for solution in (second, third)] == [True, False]
    assert second.seconds["contact"] > second.state.seconds


@pytest.mark.parametrize("friction", [2, 5])
def test_faces_that_stick_leave_no_K_to_aim_at(friction: float) -> None:
    step = next(grow(case("compression30", "1 %", f"cracks.flaw.contact.friction={friction}")))
    assert told(step) == []  # it is zero, and known to be
    assert all(math.isnan(tip.K_I_error) for tip in step.tips)
    assert step.n_dofs < 20_000


def test_without_a_solution_on_the_companion_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    def unsolved(*_: object) -> None:
        raise SolveError("none")

    monkeypatch.setattr("crackgrow.run.loading.NextStep.companion", unsolved)
    step = next(grow(case("compression30", "1 %")))
    (words,) = told(step)
    assert words.endswith("the companion mesh has no solution to hold it against: none")
    assert all(math.isnan(tip.K_I_error) for tip in step.tips)


def test_a_companion_without_a_solution_is_tried_once_more_on_smaller_cells() -> None:
    """On the first ones the functions of both tips depend on each other, where a wing starts at a flaw that sticks."""
    shallow = ("cracks.flaw.path.angle=15", "cracks.flaw.contact.friction=0.4", "growth.steps=1")
    steps = list(grow(case("compression30", "1 %", *shallow)))
    assert [told(step) for step in steps] == [[], []]
    assert all(math.isfinite(tip.K_I_error) for tip in steps[1].tips)


def test_a_target_that_takes_too_many_unknowns_ends_with_what_was_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(target_file, "MOST_UNKNOWNS", 100)
    step = next(grow(case("two_flaws", "0.1 %")))
    (words,) = told(step)
    assert "within 0.1 %" in words
    assert "at most 100 " in words
    assert f"is off by an estimated {100.0 * max(shares(step)):.2g} %" in words


def test_loads_go_on_with_their_cells_where_smaller_ones_have_no_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the first load; contact of the others is that of the history on those cells."""

    def unsolved(*_: object) -> None:
        raise SolveError("not solved")

    monkeypatch.setattr("crackgrow.run.loading.History.solve", unsolved)
    steps = list(grow(case("cyclic_friction", "0.1 %", "numerics.goal=slip", "loading.history=[0.5, 1.0]")))
    assert [step.load_factor for step in steps] == [0.5, 1.0]
    (words,) = told(steps[0])
    assert "smaller cells are not to be had: not solved" in words
    assert steps[0].n_dofs == steps[1].n_dofs


def test_the_force_of_an_interface_is_within_the_target_and_the_bound() -> None:
    """635.76 and 214.29 MN/m by an independent code, good to 0.1 %."""
    for target in (3.0, 0.3):
        step = next(grow(case("interface_friction04", f"{target} %", "numerics.goal=reaction")))
        force = next(reaction.force for reaction in step.reactions if reaction.where == "supports.0")
        exact = np.array([-214.29e6, 635.76e6])
        off = 100.0 * float(np.hypot(*(force - exact)) / np.hypot(*exact))
        assert told(step) == []
        assert step.goal_error <= BOUND * target
        assert step.goal_error == step.reaction_error
        assert off <= step.goal_error + 0.1


def test_slip_is_within_the_target_and_the_bound() -> None:
    """86.086 nm by an independent code, at the middle of the flaw, where slip is largest."""
    step = next(grow(case("compression30", "1 %", "numerics.goal=slip")))
    slip = float(np.abs(step.faces[0].slip).max())
    assert told(step) == []
    assert step.goal_error <= BOUND * 1.0
    assert 100.0 * abs(slip / 8.6086e-5 - 1.0) <= step.goal_error


def test_a_critical_load_is_within_the_target_and_the_bound() -> None:
    settings = ("loading=critical", "growth.steps=0", "growth.criterion=max_hoop_stress", "numerics.goal=load_factor")
    coarse, fine = (next(grow(case("compression30", target, *settings))) for target in ("3 %", "0.3 %"))
    assert told(coarse) == told(fine) == []
    assert coarse.goal_error <= BOUND * 3.0
    assert fine.goal_error <= BOUND * 0.3
    assert 100.0 * abs(coarse.load_factor / fine.load_factor - 1.0) <= coarse.goal_error + fine.goal_error


def test_a_goal_that_does_not_converge_ends_with_what_was_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block that sticks everywhere does not slip but for what the contact's averages leave, which never settles."""
    monkeypatch.setattr(target_file, "MOST_UNKNOWNS", 5000)
    step = next(grow(case("block_foundation", "1 %", "numerics.goal=slip")))
    (words,) = told(step)
    assert words.startswith("slip is asked for within 1 %")
    assert step.n_dofs <= 5000


def test_reactions_that_are_nothing_are_held_against_the_loads() -> None:
    step = next(grow(case("compression30", "1 %", "numerics.goal=reaction")))
    assert told(step) == []
    assert step.goal_error < 1e-6


def first_of(name: str, target: str, *settings: str) -> StepResult:
    aim = (f"numerics.accuracy={target}", "numerics.spacing=auto")
    return next(grow(shipped_case(name, [*aim, *settings, *QUIET])))


def met_or_told(step: StepResult, target: float) -> bool:
    largest = max((np.hypot(tip.K_I, tip.K_II) for tip in step.tips), default=0.0)
    bound = max((max(tip.K_I_error, tip.K_II_error) for tip in step.tips), default=np.inf)
    return bool(told(step)) != bool(bound <= BOUND * target * largest)


@pytest.mark.parametrize("target", ["0.1 %", "20 %"])
def test_the_ends_of_what_is_allowed(target: str) -> None:
    step = first_of("edge_tension", target)
    assert met_or_told(step, float(target.removesuffix(" %")) / 100.0)
    assert step.n_dofs < target_file.MOST_UNKNOWNS


def test_of_rock_that_nothing_loads_K_is_known_to_be_zero() -> None:
    step = first_of("edge_tension", "1 %", "loads.0.traction=[0,0]", "loads.1.traction=[0,0]")
    assert told(step) == []
    assert all(tip.K_I == tip.K_II == 0.0 for tip in step.tips)


def touching(y: float, tips: str) -> StepResult:
    """A crack that ends in the middle of another, or at a distance y (mm) from it."""
    paths = (f"cracks.lower.path={{points: [[-6, -3], [0, {y}]]}}", "cracks.upper.path={points: [[-6, 0], [6, 0]]}")
    more = (f"cracks.lower.tips={tips}", "growth.steps=0", "loading={history: [1]}")
    return first_of("two_flaws_overlapping", "3 %", *paths, *more)


@pytest.mark.parametrize(("y", "tips"), [(0.0, "start"), (-0.01, "both")])
def test_a_crack_that_touches_another_is_met_or_told(y: float, tips: str) -> None:
    step = touching(y, tips)
    assert met_or_told(step, 0.03)
    assert step.n_dofs < target_file.MOST_UNKNOWNS


def test_a_tip_that_lies_on_another_crack_is_refused_by_name() -> None:
    with pytest.raises(CaseError, match="'upper'"):
        touching(0.0, "both")
