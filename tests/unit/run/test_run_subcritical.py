"""Runs whose tips grow below their toughness: who grows, how far, when, and how that ends."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.fracture.subcritical import mean_velocity
from crackgrow.results.log import criticality_words
from crackgrow.run.result import StepResult
from crackgrow.run.warning_causes import WarningCause
from tests.scenes import CYCLES, SHORTER, slow_cracks
from tests.solving import whole_run

INCREMENT, V_MAX = 1e-3, 0.01  # m, m/s


def crack_lengths(result: StepResult) -> dict[str, float]:
    return {path.name: float(np.hypot(*np.diff(path.points, axis=0).T).sum()) for path in result.cracks}


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


@pytest.mark.parametrize(("first", "share"), [(-0.5, 1.0), (0.0, 1.0), (0.5, 0.5)])
def test_a_cycle_counts_between_its_first_and_its_last_load_as_far_as_they_open_the_crack(
    first: float, share: float
) -> None:
    """What comes between, and pressure on closed faces, is nothing to it: K_range is a share of K, here in mode I."""
    settings = (f"loading={{history: [{first}, 0.25, 1]}}", "growth.steps=1")
    (before, after), _ = whole_run(slow_cracks(*CYCLES, *settings))
    tip = before.tips[0]
    assert tip.K_range == pytest.approx(share * np.hypot(tip.K_I, tip.K_II), rel=1e-3)
    assert tip.growth_per_cycle == pytest.approx(1e-9 * (1e-6 * tip.K_range) ** 3, rel=1e-12)
    mean = mean_velocity(tip.growth_per_cycle, after.tips[0].growth_per_cycle)
    assert after.cycles == pytest.approx(INCREMENT / mean, rel=1e-9)
    assert np.isnan([after.time, tip.velocity]).all()


def test_along_bedding_a_crack_grows_in_a_cycle_as_at_the_range_that_is_as_critical_across_it() -> None:
    """A level crack in bedding of half the toughness: twice the range, and growth in a cycle 2^3 times as much."""
    weak = "bodies.rock.strength.bedding={angle: 0, toughness: 0.25 MPa sqrt(m)}"
    bare, bedded = (whole_run(slow_cracks(*CYCLES, *more, "growth.steps=0"))[0][0].tips[0] for more in ((), (weak,)))
    assert bedded.kink_deg == pytest.approx(bare.kink_deg, abs=0.1)
    assert bedded.K_range == pytest.approx(2.0 * bare.K_range, rel=1e-4)
    assert bedded.growth_per_cycle == pytest.approx(8.0 * bare.growth_per_cycle, rel=1e-3)


def test_below_the_threshold_of_its_range_a_crack_stands_still() -> None:
    least = {share: f"growth.fatigue.threshold={share * 0.1875} MPa sqrt(m)" for share in (0.9, 1.1)}
    runs = {share: whole_run(slow_cracks(*CYCLES, setting, "growth.steps=1")) for share, setting in least.items()}
    assert [len(results) for results, _ in runs.values()] == [2, 1]
    (only,), end = runs[1.1]
    assert (only.cycles, only.tips[0].growth_per_cycle, end.status) == (0.0, 0.0, "arrested")
    assert "no tip grows in a cycle; " in end.reason
    assert criticality_words(only)[1] == "unstable at K 500 kPa sqrt(m)"
    assert f"the largest range of K is {only.tips[0].K_range:.4g} Pa sqrt(m), the threshold is" in end.reason


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
