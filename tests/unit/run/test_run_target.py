"""Cells that are refined for a target, what is told where they can't be, and a run that goes on to the same bits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crackgrow.accuracy.companion import BOUND
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from crackgrow.run import target as target_file
from crackgrow.run.loop import grow
from crackgrow.run.result import StepResult
from tests.scenes import STARTS, shipped_case
from tests.verification.solutions import QUIET

SHEARED = (*STARTS, "growth.steps=2", "growth.initiation=ends")
"""Shear cracks start at the ends of a flaw, beside its wings."""


def case(name: str, accuracy: str, *settings: str) -> Case:
    aim = ("numerics.spacing=auto", f"numerics.accuracy={accuracy}")
    return shipped_case(name, [*aim, *settings, *QUIET])


def shares(step: StepResult) -> list[float]:
    """Error estimates of K over the largest K, tip by tip."""
    largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    return [max(tip.K_I_error, tip.K_II_error) / BOUND / largest for tip in step.tips]


def told(step: StepResult) -> list[str]:
    return [warning.words for warning in step.step_warnings if warning.cause == "TARGET"]


def test_every_load_of_a_history_meets_the_target() -> None:
    steps = list(grow(case("cyclic_friction", "3 %", "loading.history=[0.5, 1.0, 0.8]")))
    assert len(steps) == 3
    assert all(max(shares(step)) <= 0.03 or told(step) for step in steps)


def test_cracks_that_start_meet_the_target() -> None:
    """Their cells are small by their own length."""
    steps = list(grow(case("compression30", "3 %", *SHEARED)))
    assert [event.kind for event in steps[-1].events] == ["initiation", "initiation"]
    assert len(steps[-1].tips) == 4
    assert told(steps[-1]) == []
    assert max(max(shares(step)) for step in steps) <= 0.03


def test_without_a_solution_on_the_companion_nothing_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    def unsolved(*_: object) -> None:
        raise SolveError("none")

    monkeypatch.setattr("crackgrow.run.loading.NextStepSolver.companion", unsolved)
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

    monkeypatch.setattr("crackgrow.run.loading.HistorySolver.solve", unsolved)
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
