"""What follows from the error of K for directions and critical loads, and how steeply the criticality rises."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.run.checkpoint import beginning
from crackgrow.run.growth_error import Judged, judged_when_off, kink_errors, load_error
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load
from crackgrow.run.loop import grow
from crackgrow.run.scene import make_scene

CASES = Path(__file__).parents[3] / "cases"
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")
OPEN = ("cracks.flaw.path.angle=0", "growth.steps=0", "growth.criterion=max_hoop_stress", "numerics.spacing=3")
PULLED = ("loads.0.traction=[0,10]", "loads.1.traction=[0,-10]")


def solved(*settings: str) -> StepSolution:
    case = load_case(CASES / "compression30.yaml", [*OPEN, *settings, *QUIET])
    return load(make_scene(case), beginning(case).cracks)


def off_by(solution: StepSolution, of_I: float, of_II: float) -> Judged:
    """What the criterion says where K_I and K_II are off by these parts of the largest K_I."""
    largest = max(tip.K[0] for tip in solution.tips)
    return judged_when_off(solution, [(of_I * largest, of_II * largest) for _ in solution.tips])


def test_a_load_that_is_critical_by_K_I_is_off_by_as_much() -> None:
    solution = solved(*PULLED, "loading=critical")
    assert solution.steepness == pytest.approx(1.0, rel=1e-6)
    assert load_error(solution, off_by(solution, 0.02, 0.0)) == pytest.approx(0.02, rel=1e-3)
    assert load_error(solution, off_by(solution, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-9)


def test_where_a_held_load_does_half_the_work_the_load_factor_is_off_by_twice_as_much() -> None:
    case = load_case(CASES / "compression30.yaml", [*OPEN, *PULLED, "loading=critical", *QUIET])
    critical = load(make_scene(case), beginning(case).cracks).state.factor
    half = 5.0 * critical
    loads = "[" + ", ".join(
        f"{{on: {{body: rock, edge: {edge}}}, traction: [0, {sign * size}]{more}}}"
        for edge, sign in (("top", 1), ("bottom", -1))
        for size, more in ((half, ", held: true"), (10, ""))
    ) + "]"  # fmt: skip
    case = load_case(CASES / "compression30.yaml", [*OPEN, f"loads={loads}", "loading=critical", *QUIET])
    solution = load(make_scene(case), beginning(case).cracks)
    assert solution.state.factor == pytest.approx(0.5 * critical, rel=1e-6)
    assert solution.steepness == pytest.approx(0.5, rel=1e-4)
    found = load_error(solution, off_by(solution, 0.02, 0.0))
    assert found == pytest.approx(0.04, rel=1e-3)


def test_a_tip_in_pure_mode_I_turns_by_twice_the_part_of_shear() -> None:
    solution = solved(*PULLED)
    np.testing.assert_allclose(kink_errors(solution, off_by(solution, 0.0, 0.01)), 0.02, rtol=1e-2)


def test_the_direction_without_shear_is_judged_by_the_hoop_stress_whatever_the_criterion() -> None:
    explicit, implicit = (solved(*PULLED, f"growth.direction={way}") for way in ("explicit", "implicit"))
    assert kink_errors(explicit, off_by(explicit, 0.01, 0.02)) == kink_errors(implicit, off_by(implicit, 0.01, 0.02))


def test_a_tip_that_goes_on_in_shear_is_judged_by_its_criterion_however_others_turn() -> None:
    explicit, implicit = (solved(*PULLED, f"growth.direction={way}") for way in ("explicit", "implicit"))
    found = []
    for solution in (explicit, implicit):
        verdicts = [replace(tip.verdict, mode="shear", kink=0.5) for tip in solution.tips if tip.verdict is not None]
        tips = [replace(tip, verdict=verdict) for tip, verdict in zip(solution.tips, verdicts, strict=True)]
        in_shear = replace(solution, tips=tips)
        found.append(kink_errors(in_shear, off_by(in_shear, 0.01, 0.02)))
    assert found[0] == found[1]
    np.testing.assert_allclose(found[0], 0.5, rtol=0, atol=0.1)


def test_what_is_not_known_is_not_told() -> None:
    solution = solved(*PULLED, "loading=critical")
    unknown = judged_when_off(solution, [(np.nan, np.nan)] * 2)
    assert np.isnan(kink_errors(solution, unknown)).all()
    assert np.isnan(load_error(solution, unknown))
    assert np.isnan(load_error(replace(solution, steepness=np.inf), off_by(solution, 0.1, 0.1))) is np.False_
    static = next(grow(load_case(CASES / "edge_tension.yaml", QUIET)))
    assert np.isnan([static.load_factor_error, static.tips[0].kink_error_deg]).all()
