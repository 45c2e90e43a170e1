"""Extremes of a target: refused or told, nothing endless, nothing silent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.errors import CaseError
from crackgrow.run import grow
from crackgrow.run.caution import Cause
from crackgrow.run.result import StepResult
from crackgrow.run.target import MOST_UNKNOWNS

CASES = Path(__file__).parents[3] / "cases"
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")


def first(name: str, target: str, *settings: str) -> StepResult:
    aim = (f"numerics.accuracy={target}", "numerics.spacing=auto")
    return next(grow(load_case(CASES / f"{name}.yaml", [*aim, *settings, *QUIET])))


def told(step: StepResult) -> list[str]:
    return [caution.words for caution in step.cautions if caution.cause is Cause.TARGET]


def met_or_told(step: StepResult, target: float) -> bool:
    largest = max((np.hypot(tip.K_I, tip.K_II) for tip in step.tips), default=0.0)
    bound = max((max(tip.K_I_error, tip.K_II_error) for tip in step.tips), default=np.inf)
    return bool(told(step)) != bool(bound <= target * largest)


@pytest.mark.parametrize("target", ["1e-6", "0.0001 %", "50 %", "0.5", "0", "-1 %", "nan", "inf"])
def test_targets_that_no_run_can_meet_or_that_say_nothing_are_refused(target: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(CASES / "compression30.yaml", [f"numerics.accuracy={target}"])
    (fault,) = caught.value.faults
    assert "numerics.accuracy" in str(fault)


@pytest.mark.parametrize("target", ["0.1 %", "20 %"])
def test_the_ends_of_what_is_allowed(target: str) -> None:
    step = first("edge_tension", target)
    assert met_or_told(step, float(target.removesuffix(" %")) / 100.0)
    assert step.n_dofs < MOST_UNKNOWNS


def test_no_tips_are_refused_by_the_name_of_the_goal() -> None:
    with pytest.raises(CaseError, match=r"numerics\.goal"):
        first("block_rigid", "1 %")


def test_cracks_without_tips_are_refused_too() -> None:
    with pytest.raises(CaseError, match="no crack has a tip"):
        first("edge_tension", "1 %", "cracks.notch.tips=none")


def test_everything_stuck_is_told() -> None:
    (words,) = told(first("compression30", "1 %", "cracks.flaw.contact.friction=5"))
    assert "stick" in words


def test_nothing_loaded_is_told() -> None:
    (words,) = told(first("edge_tension", "1 %", "loads.0.traction=[0,0]", "loads.1.traction=[0,0]"))
    assert "K" in words


def touching(y: float, tips: str) -> StepResult:
    """A crack that ends in the middle of another, or at a distance y (mm) from it."""
    paths = (f"cracks.lower.path={{points: [[-6, -3], [0, {y}]]}}", "cracks.upper.path={points: [[-6, 0], [6, 0]]}")
    more = (f"cracks.lower.tips={tips}", "growth.steps=0", "loading={history: [1]}")
    return first("two_flaws_overlapping", "3 %", *paths, *more)


@pytest.mark.parametrize(("y", "tips"), [(0.0, "start"), (-0.01, "both")])
def test_a_crack_that_touches_another_is_met_or_told(y: float, tips: str) -> None:
    step = touching(y, tips)
    assert met_or_told(step, 0.03)
    assert step.n_dofs < MOST_UNKNOWNS


def test_a_tip_that_lies_on_another_crack_is_refused_by_name() -> None:
    with pytest.raises(CaseError, match="'upper'"):
        touching(0.0, "both")
