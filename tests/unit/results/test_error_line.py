"""What summary.json and the last lines of a run tell of the error."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from crackgrow.case.model import Stage, Stages
from crackgrow.results.log import Progress
from crackgrow.results.summary import K_error, K_spread, Tally, error_line, summarize, summary_text
from crackgrow.run.result import StepResult, TipResult
from tests.unit.results.synthetic import make_case, make_end, make_result


def with_tips(step: int, *changes: dict[str, object]) -> StepResult:
    """A step with one tip for each of `changes`: K = (3, -4), errors (0.4, 0.1), spread (0.02, 0.08), room enough.

    K_I and K_II together are 5.
    """
    K = {"K_I": 3.0, "K_II": -4.0, "K_I_error": 0.4, "K_II_error": 0.1, "K_I_spread": 0.02, "K_II_spread": 0.08}
    tip: TipResult = replace(make_result(step).tips[1], **K, K_note="")
    return make_result(step, tips=tuple(replace(tip, **change) for change in changes))


def test_the_spread_is_that_of_tips_with_room_by_the_largest_K() -> None:
    np.testing.assert_allclose(K_spread(with_tips(0, {})), 1.6)
    crowded = {"K_note": "the outline makes the disc of the integral small", "K_I_spread": 1.0, "K_I": 9.0}
    np.testing.assert_allclose(K_spread(with_tips(0, {}, crowded)), 1.6)
    np.testing.assert_allclose(K_spread(with_tips(0, {}, {"K_I": 6.0, "K_II": -8.0, "K_I_spread": 0.4})), 4.0)
    for tips in ((crowded,), (), ({"K_I": 0.0, "K_II": 0.0},), ({"K_I": math.nan},)):
        assert math.isnan(K_spread(with_tips(0, *tips)))


def test_the_bound_is_that_of_all_tips_by_the_largest_K() -> None:
    np.testing.assert_allclose(K_error(with_tips(0, {})), 8.0)
    crowded = {"K_note": "the outline makes the disc of the integral small", "K_II_error": 0.8}
    np.testing.assert_allclose(K_error(with_tips(0, {}, crowded)), 16.0)
    assert math.isnan(K_error(with_tips(0, {"K_I": math.nan})))


@pytest.mark.parametrize("told", [K_spread, K_error])
def test_K_that_is_nothing_beside_what_the_stress_could_make_has_no_error(told: Callable[[StepResult], float]) -> None:
    """10 Pa make 10 sqrt(0.1 pi) = 5.6 Pa sqrt(m) of a crack with a half length of a tenth of a metre."""
    nothing, usual = {"K_I": 3e-3, "K_II": -4e-3, "K_radius": 0.1}, told(with_tips(0, {}))
    assert math.isnan(told(replace(with_tips(0, nothing), stress=10.0)))
    np.testing.assert_allclose(told(replace(with_tips(0, nothing, {"K_radius": 0.1}), stress=10.0)), usual)
    np.testing.assert_allclose(told(replace(with_tips(0, nothing), stress=1.0)), 1000.0 * usual)


@pytest.mark.parametrize("told", [K_spread, K_error])
def test_the_K_of_cracks_that_stick_has_no_error(told: Callable[[StepResult], float]) -> None:
    stuck = {"sticks": True, "K_I": 9e9, "K_I_error": 9e9, "K_I_spread": 9e9}
    assert math.isnan(told(with_tips(0, stuck)))
    assert told(with_tips(0, stuck, {})) == told(with_tips(0, {}))


def test_the_summary_has_the_first_and_the_last_error_and_the_worst_spread() -> None:
    tally = Tally()
    for step, spread in enumerate((0.08, 0.12, 0.04)):
        result = with_tips(step, {"K_II_spread": spread, "K_I_error": 5.0 * spread})
        tally.add(replace(result, norm_error=1.5 if step == 0 else math.nan))
    end = replace(make_end(2), norm_error=2.25)
    summary = json.loads(summary_text(summarize(make_case(), Tally.of(tally.record()), end, 1.0, 1.0)))[
        "error_estimate"
    ]
    assert summary["energy_norm_percent"] == {"first": 1.5, "last": 2.25}
    np.testing.assert_allclose(summary["K_spread_percent"], 2.4)
    np.testing.assert_allclose(summary["K_percent_at_most"], 12.0)
    assert error_line(tally, end) == "estimated error: 2.2 % of the energy norm, K by at most 12 % of the largest"


def test_the_error_of_K_that_is_expected_is_told_before_its_bound() -> None:
    """Of the step where it is largest; K is 5 Pa sqrt(m) at most there."""
    tally = Tally()
    for step, expected in enumerate((0.1, 0.2, 0.05)):
        tally.add(with_tips(step, {"K_I": 3.0, "K_II": -4.0, "K_I_error": 0.5, "K_error_expected": expected}))
    found = json.loads(summary_text(summarize(make_case(), Tally.of(tally.record()), make_end(2), 1.0, 1.0)))
    np.testing.assert_allclose(found["error_estimate"]["K_percent_expected"], 4.0)
    assert error_line(tally, make_end(2)).startswith("estimated error: K by an expected 4 %, at most ")


def test_directions_loads_and_the_goal_have_the_worst_of_all_steps_and_are_told() -> None:
    """Directions count at tips that grow."""
    tally = Tally()
    for step, size in enumerate((2.0, 3.0, 1.0)):
        grows, waits = {"advanced": True, "kink_error_deg": size}, {"advanced": False, "kink_error_deg": 90.0}
        tally.add(replace(with_tips(step, grows, waits), load_factor_error=4.0 * size, goal_error=0.5 * size))
    end = make_end(2)
    summary = json.loads(summary_text(summarize(make_case(), Tally.of(tally.record()), end, 1.0, 1.0)))
    found = summary["error_estimate"]
    names = ("kink_degrees_at_most", "load_factor_percent_at_most", "goal_percent_at_most")
    assert [found[name] for name in names] == [3.0, 12.0, 1.5]
    line = error_line(tally, end)
    assert "directions of growth by 3 degrees" in line
    assert "critical load factors by 12 %" in line
    assert "numerics.goal by at most 1.5 %" in line


def test_what_is_unknown_is_null_and_not_told() -> None:
    tally = Tally()
    tally.add(with_tips(0))
    summary = json.loads(summary_text(summarize(make_case(), tally, make_end(0), 1.0, 1.0)))["error_estimate"]
    unknown = {"energy_norm_percent": {"first": None, "last": None}, "K_percent_at_most": None}
    unknown["K_percent_expected"] = None
    others = ("K_spread_percent", "kink_degrees_at_most", "load_factor_percent_at_most", "goal_percent_at_most")
    assert summary == unknown | dict.fromkeys(others)
    assert error_line(tally, make_end(0)) == ""
    tally.add(with_tips(1, {}))
    assert error_line(tally, make_end(0)) == "estimated error: K by at most 8 % of the largest"


def test_the_lines_of_a_run_keep_the_unit_of_K_while_K_falls() -> None:
    said: list[str] = []
    progress = Progress(make_case(), lambda text, end: said.append(text), width=None)
    for step, K in enumerate((114.0, 1.1e6, 0.9e6)):
        progress.show(with_tips(step, {"K_I": K, "K_II": 0.0, "advanced": True}))
    told = [text.partition("K_I ")[2].partition(",")[0] for text in said if text.startswith("step")]
    assert told == ["114 K_II 0 Pa sqrt(m)", "1.10 K_II 0.00 MPa sqrt(m)", "0.900 K_II 0.000 MPa sqrt(m)"]


def test_a_stage_is_told_by_its_name() -> None:
    names = ("at rest", "excavated")
    stages = Stages(Stage("", 0.0, (), ()), tuple(Stage(name, 1.0, (), ()) for name in names))
    said: list[str] = []
    progress = Progress(replace(make_case(), loading=stages), lambda text, end: said.append(text), width=None)
    for factor in (1.0, 2.0, 1.5):
        progress.show(replace(with_tips(0, {}), load_factor=factor))
    told = [text.split(", ")[1] for text in said if text.startswith("step")]
    assert told == ["stage 'at rest'", "stage 'excavated'", "load factor 1.5"]
