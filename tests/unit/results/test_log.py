"""The line that tells of a step to who looks on."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.results.log import step_line, told_line
from crackgrow.run.result import StartResult
from tests.unit.results.synthetic import make_case, make_result


@pytest.mark.parametrize(("before_the_end", "told"), [(1, True), (0, False)])
def test_that_no_tip_advanced_is_told_of_steps_after_which_one_could(before_the_end: int, told: bool) -> None:
    case = make_case()
    assert case.growth is not None
    result = make_result(case.growth.steps - before_the_end)
    still = [tip for tip in result.tips if not tip.advanced]
    line = told_line(make_result(result.step, tips=tuple(still)), case, 0.0)
    assert ("no tip advanced" in line) is told


def test_every_step_tells_how_critical_it_is_and_the_K_at_which_the_tip_grows() -> None:
    case, result = make_case(), make_result(1)
    told = ", criticality 1.2, grows at K 1.67 MPa sqrt(m), "
    assert told in told_line(result, case, 0.0)
    assert told in step_line(result, 3)
    still = make_result(1, tips=tuple(tip for tip in result.tips if not tip.advanced))
    assert ", criticality 0.2, no tip advanced" in told_line(still, case, 0.0)
    assert "criticality" not in told_line(make_result(1, tips=()), case, 0.0)


def test_where_no_tip_advances_the_most_critical_start_is_told() -> None:
    case, result = make_case(), make_result(1)
    still = tuple(tip for tip in result.tips if not tip.advanced)
    start = StartResult(np.array([8e-17, -0.02]), "tension", 0.8712)
    told = "most critical start at (0 m, -20 mm) (tension), criticality 0.871"
    for tips, words in (((), True), (still, True), (result.tips, not any(tip.advanced for tip in result.tips))):
        stopped = make_result(1, tips=tips, start=start)
        assert (told in told_line(stopped, case, 0.0)) is words
        assert (told in step_line(stopped, 3)) is words
