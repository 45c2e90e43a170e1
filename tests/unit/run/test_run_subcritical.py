"""Runs whose tips grow below their toughness: who grows, how far, when, and how that ends."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from crackgrow.fracture.subcritical import WAITS, mean_velocity
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.run.warning_causes import WarningCause
from tests.slow_cracks import SHORTER, slow_cracks
from tests.whole_run import whole_run

INCREMENT, V_MAX, N = 1e-3, 0.01, 10  # m, m/s, -


@pytest.fixture(scope="module")
def two() -> tuple[list[StepResult], RunEnd]:
    """Two cracks, of 6 and of 4 mm."""
    return whole_run(slow_cracks(SHORTER, "growth.steps=8", "growth.subcritical.exponent=4"))


def crack_lengths(result: StepResult) -> dict[str, float]:
    return {path.name: float(np.hypot(*np.diff(path.points, axis=0).T).sum()) for path in result.cracks}


def test_a_slow_tip_waits_and_then_advances_by_all_it_has_gathered(two: tuple[list[StepResult], RunEnd]) -> None:
    results, _ = two
    steps = np.diff([crack_lengths(result)["shorter"] for result in results])
    velocity = [{tip.crack: tip.velocity for tip in result.tips} for result in results]
    gathered = 0.0
    for step, (before, after) in zip(steps, pairwise(velocity), strict=True):
        due = gathered + INCREMENT * before["shorter"] / before["notch"]
        if step > 0.0:
            assert step == pytest.approx(due, rel=1e-9)
        else:
            assert due < WAITS * INCREMENT
        mean = {crack: mean_velocity(before[crack], after[crack]) for crack in before}
        gathered += INCREMENT * mean["shorter"] / mean["notch"] - step
    assert 0 < np.count_nonzero(steps) < len(steps)  # it does both


def test_below_its_threshold_a_crack_stands_still() -> None:
    results, end = whole_run(slow_cracks("growth.subcritical.threshold=0.9"))
    assert (len(results), end.status) == (1, "arrested")
    assert "no tip has a velocity; the most critical is at 0.375" in end.reason
    assert end.reason.endswith("of its toughness, the threshold is 0.9")
    assert (results[0].time, results[0].tips[0].velocity) == (0.0, 0.0)


def test_a_tip_beyond_its_toughness_is_told_and_has_no_more_than_the_largest_velocity() -> None:
    results, _ = whole_run(slow_cracks("growth.steps=1", "loading={history: [3.0]}"))
    assert results[0].tips[0].criticality > 1.0
    assert results[0].tips[0].velocity == V_MAX
    assert results[1].time == pytest.approx(INCREMENT / V_MAX)
    (told,) = [warning.words for warning in results[0].step_warnings if warning.cause == WarningCause.UNSTABLE]
    assert told.startswith(f"the end of crack 'notch' is at {results[0].tips[0].criticality:.3g} of its toughness")


WALL = "{path: {points: [[-6.5, -6], [-6.5, 6]]}, tips: none, contact: none}"
SAME_VELOCITY = "growth.subcritical.exponent=0"


@pytest.mark.parametrize(
    ("more", "times"), [((), [0.0, 0.1, 0.2, 0.25]), ((SHORTER,), [0.0, 0.1, 0.2, 0.3, 0.4])], ids=["alone", "of two"]
)
def test_a_tip_takes_no_longer_than_to_what_it_meets(more: tuple[str, ...], times: list[float]) -> None:
    """The notch has 2.5 mm to go, at 10 mm/s whatever K is; time goes on with tips that meet nothing."""
    results, _ = whole_run(slow_cracks(f"cracks.wall={WALL}", SAME_VELOCITY, *more))
    assert [event.kind for result in results for event in result.events] == ["coalescence"]
    np.testing.assert_allclose([result.time for result in results], times, rtol=1e-9)
    assert np.diff([crack_lengths(result)["notch"] for result in results])[2] == pytest.approx(0.5 * INCREMENT)
    if more:
        shorter = [crack_lengths(result)["shorter"] for result in results]
        np.testing.assert_allclose(np.diff(shorter), INCREMENT, rtol=1e-9)
