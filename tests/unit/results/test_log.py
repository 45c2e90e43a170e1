"""The line that tells of a step to who looks on."""

from __future__ import annotations

import pytest

from crackgrow.results.log import told_line
from tests.unit.results.synthetic import make_case, make_result


@pytest.mark.parametrize(("before_the_end", "told"), [(1, True), (0, False)])
def test_that_no_tip_advanced_is_told_of_steps_after_which_one_could(before_the_end: int, told: bool) -> None:
    case = make_case()
    assert case.growth is not None
    result = make_result(case.growth.steps - before_the_end)
    still = [tip for tip in result.tips if not tip.advanced]
    line = told_line(make_result(result.step, tips=tuple(still)), case, 0.0)
    assert ("no tip advanced" in line) is told
