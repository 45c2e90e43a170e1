"""Runs whose tips grow below their toughness: who grows, how far, when, and how that ends."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from crackgrow.fracture.subcritical import WAITS, mean_velocity
from crackgrow.run.caution import Cause
from crackgrow.run.leaving import COARSE_TIME
from crackgrow.run.result import RunEnd, StepResult
from tests.slow_cracks import GROWTH, SHORTER, slow_cracks
from tests.whole_run import whole_run

INCREMENT, V_MAX, N = 1e-3, 0.01, 10  # m, m/s, -


@pytest.fixture(scope="module")
def two() -> tuple[list[StepResult], RunEnd]:
    """Two cracks, of 6 and of 4 mm."""
    return whole_run(slow_cracks(SHORTER, "growth.steps=8", "growth.subcritical.exponent=4"))


def crack_lengths(result: StepResult) -> dict[str, float]:
    return {path.name: float(np.hypot(*np.diff(path.points, axis=0).T).sum()) for path in result.cracks}


def test_the_longer_crack_runs_away(two: tuple[list[StepResult], RunEnd]) -> None:
    results, _ = two
    lengths = [crack_lengths(result) for result in results]
    ahead = [each["notch"] - each["shorter"] for each in lengths]
    assert np.all(np.diff(ahead) > 0.0)
    np.testing.assert_allclose(np.diff([each["notch"] for each in lengths]), INCREMENT, rtol=1e-9)
    velocity = [{tip.crack: tip.velocity for tip in result.tips} for result in results]
    ratio = [each["notch"] / each["shorter"] for each in velocity]
    assert ratio[-1] > ratio[0] > 2.0


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


def test_velocity_follows_from_the_stress_intensity() -> None:
    results, _ = whole_run(slow_cracks("growth.steps=1"))
    assert results[0].time == 0.0
    velocity = [result.tips[0].velocity for result in results]
    expected = [V_MAX * (result.tips[0].K_I / 0.5e6) ** N for result in results]
    np.testing.assert_allclose(velocity, expected, rtol=1e-2)  # K_II is not quite zero
    assert INCREMENT / velocity[1] < results[1].time < INCREMENT / velocity[0]


def test_twice_the_velocity_takes_half_the_time_on_the_same_path() -> None:
    one, _ = whole_run(slow_cracks("growth.steps=2"))
    other, _ = whole_run(slow_cracks("growth.steps=2", "growth.subcritical.velocity=20 mm/s"))
    np.testing.assert_allclose([result.time for result in one], [2.0 * result.time for result in other], rtol=1e-12)
    np.testing.assert_array_equal(one[-1].cracks[0].points, other[-1].cracks[0].points)


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
    (told,) = [caution.words for caution in results[0].cautions if caution.cause == Cause.UNSTABLE]
    assert told.startswith(f"the end of crack 'notch' is at {results[0].tips[0].criticality:.3g} of its toughness")


def test_coarse_increments_are_told() -> None:
    """K grows by 14 % in an increment, and v by a factor of 1.7 and of 3.8."""
    told = {}
    for exponent in (4, 10):
        results, _ = whole_run(slow_cracks("growth.steps=1", f"growth.subcritical.exponent={exponent}"))
        told[exponent] = [COARSE_TIME in result.warnings for result in results]
    assert told == {4: [False, False], 10: [False, True]}


def test_growth_by_the_criterion_alone_takes_no_time() -> None:
    results, _ = whole_run(slow_cracks(f"growth={{{GROWTH}}}", "growth.steps=0"))
    assert np.isnan(results[0].time)
    assert np.isnan(results[0].tips[0].velocity)


WALL = "{path: {points: [[-6.5, -6], [-6.5, 6]]}, tips: none, contact: none}"
SAME_VELOCITY = "growth.subcritical.exponent=0"


def test_a_tip_takes_no_longer_than_to_what_it_meets() -> None:
    """The notch has 2.5 mm to go, at 10 mm/s whatever K is."""
    results, _ = whole_run(slow_cracks(f"cracks.wall={WALL}", SAME_VELOCITY))
    assert [event.kind for result in results for event in result.events] == ["coalescence"]
    np.testing.assert_allclose([result.time for result in results], [0.0, 0.1, 0.2, 0.25], rtol=1e-9)


def test_time_goes_on_with_tips_that_meet_nothing() -> None:
    results, _ = whole_run(slow_cracks(f"cracks.wall={WALL}", SHORTER, SAME_VELOCITY))
    np.testing.assert_allclose([result.time for result in results], 0.1 * np.arange(5), rtol=1e-9)
    assert np.diff([crack_lengths(result)["notch"] for result in results])[2] == pytest.approx(0.5 * INCREMENT)
    np.testing.assert_allclose(np.diff([crack_lengths(result)["shorter"] for result in results]), INCREMENT, rtol=1e-9)
