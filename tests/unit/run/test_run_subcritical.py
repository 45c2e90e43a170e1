"""Tips that grow below their toughness: who, how far, when; the search for the direction in which K_II vanishes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely

from crackgrow.case.model import Crack
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.stress_intensity import StressIntensity
from crackgrow.fracture.subcritical import mean_velocity
from crackgrow.geometry.polyline import kink_angles
from crackgrow.results.log import criticality_words
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.propagation import MOST_SOLVES, AfterAdvance, BeforeAdvance, advance_tips
from crackgrow.run.result import StepResult
from tests.scenes import CYCLES, SHORTER, shipped_case, slow_cracks
from tests.solving import solve_case, whole_run

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
    (told,) = [warning.words for warning in results[0].step_warnings if warning.cause == "UNSTABLE"]
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


Cracks = tuple[GrowingCrack, ...]
BOTH = np.array([0, 1])


@pytest.fixture(scope="module")
def start() -> StepSolution:
    implicit = ["growth.criterion=max_hoop_stress", "growth.direction=implicit", "numerics.spacing=3"]
    return solve_case(shipped_case("compression30", [*implicit, "growth.tip_stress.radius=2"]))


def advance(
    start: StepSolution,
    K_II: Callable[[float], float],
    chosen: np.ndarray = BOTH,
    fails_at: int = -1,
    walls: Sequence[GrowingCrack] = (),
) -> tuple[AfterAdvance, int]:
    """The advance where the new tips have K_I = 1 and K_II as a function of the kink (degrees); number of solves."""
    before = BeforeAdvance(
        replace(start.scene, crack_bodies=(0,) * (1 + len(walls))), (*start.configuration.cracks, *walls), 1
    )
    solves = []

    def made_up(grown: Cracks) -> StepSolution:
        solves.append(grown)
        if len(solves) - 1 == fails_at:
            raise SolveError("no solution")
        kinks = np.rad2deg(kink_angles(grown[0].crack.points))
        states = []
        for state, kink in zip(start.tips, (-kinks[0], kinks[-1]), strict=True):
            intensity = StressIntensity(1.0, K_II(kink), 0.0, 0.0, 0.0, 0.0, 1.0, False, "")
            states.append(replace(state, intensity=intensity))
        return replace(start, tips=tuple(states))

    return advance_tips(before, start, chosen, made_up), len(solves)


@pytest.mark.parametrize("slope", [0.005, 0.01, 0.04])
def test_two_tips_are_corrected_together(slope: float, start: StepSolution) -> None:
    """The kink of the start's tip is counted from its own direction: against the polyline."""
    found, n_solves = advance(start, lambda kink: slope * (kink - 60.0) + 1e-5 * (kink - 60.0) ** 2)
    assert np.rad2deg(kink_angles(found.cracks[0].crack.points)) == pytest.approx([-60.0, 60.0], abs=0.3)
    assert n_solves <= 5
    assert found.solution is not None
    assert found.solution.doubts == ()


def test_where_K_II_does_not_vanish_the_best_direction_is_kept_and_told(start: StepSolution) -> None:
    found, n_solves = advance(start, lambda kink: 0.1 + 1e-4 * abs(kink), np.array([1]))
    assert n_solves == MOST_SOLVES
    assert found.solution is not None
    assert "left K_II at 0.1" in found.solution.doubts[0]


def test_a_trial_that_cannot_be_solved_ends_the_search(start: StepSolution) -> None:
    found, n_solves = advance(start, lambda kink: 0.01 * (kink - 60.0), np.array([1]), fails_at=1)
    assert n_solves == 2
    assert found.solution is not None
    assert "search for the direction of growth ended at trial 2" in found.solution.doubts[0]
    first, _ = advance(start, lambda kink: 0.0, np.array([1]), fails_at=0)
    assert first.solution is None  # the loop solves it again and says why that fails


def wall(*ends_mm: tuple[float, float]) -> GrowingCrack:
    """A crack through two points beside the flaw's end, in mm along and across the flaw from there."""
    along = np.array([np.cos(np.deg2rad(30.0)), np.sin(np.deg2rad(30.0))])
    across = np.array([-along[1], along[0]])
    points = 1e-3 * np.array([(5.0 + a) * along + b * across for a, b in ends_mm])
    return GrowingCrack(Crack("wall", points, True, True, None, "rock"), np.zeros(2, dtype=np.int64))


@pytest.mark.parametrize("solved", [True, False])
def test_a_corrected_kink_that_leads_to_a_crack_ends_there_if_it_is_taken(solved: bool, start: StepSolution) -> None:
    """The first trial, at 70 degrees, passes the wall. It is taken where the next, at 41, meets it but has no state."""
    beside = wall((1.0, -1.0), (1.0, 1.5))
    found, n_solves = advance(
        start, lambda kink: 0.01 * (kink - 20.0), np.array([1]), fails_at=-1 if solved else 1, walls=[beside]
    )
    assert n_solves == 2
    assert found.cracks[0].can_grow(True) != solved
    told = [(event.kind, event.crack, event.tip, event.met) for event in found.events]
    assert told == ([("coalescence", "flaw", "end", "crack 'wall'")] if solved else [])
    for event in found.events:
        np.testing.assert_array_equal(event.point, found.cracks[0].crack.points[-1])
        assert shapely.distance(shapely.LineString(beside.crack.points), shapely.Point(event.point)) < 1e-15


def facing(gap: float) -> StepSolution:
    """Two flaws in line, `gap` mm apart, pulled open; all four tips of the explicit advance."""
    flaw = "{{path: {{points: [[{}, 0], [{}, 0]]}}, contact: none}}"
    cracks = f"cracks={{a: {flaw.format(-8 - gap, -gap)}, b: {flaw.format(0, 8)}}}"
    return solve_case(shipped_case("tension0", [cracks, "growth.advance=all", "numerics.spacing=3"]))


@pytest.mark.parametrize(("gap", "who"), [(3.0, "b"), (1.9, "a"), (2.1, "a")])
def test_two_tips_that_meet_in_the_same_step_join(gap: float, who: str) -> None:
    """Increments of 2 mm: b meets what a has just made, or a meets b's tip, which then stays. Both tips end there."""
    solution = facing(gap)
    before = BeforeAdvance(solution.scene, solution.configuration.cracks, 1)
    found = advance_tips(before, solution, np.arange(4), pytest.fail)  # explicit directions need no solves
    told = {"a": ("a", "end", "crack 'b'"), "b": ("b", "start", "crack 'a'")}
    first, second = ((event.crack, event.tip, event.met) for event in found.events)
    assert first == told.pop(who)
    assert [second] == list(told.values())
    np.testing.assert_array_equal(found.events[0].point, found.events[1].point)
    a, b = (growing.crack for growing in found.cracks)
    np.testing.assert_array_equal(a.points[-1], b.points[0])
    assert (a.tip_at_start, a.tip_at_end, b.tip_at_start, b.tip_at_end) == (True, False, False, True)
    assert found.cracks[0].steps.tolist() == [1, 0, 0, 1]
    assert found.cracks[1].steps.tolist() == ([1, 0, 0, 1] if who == "b" else [0, 0, 1])
    assert shapely.LineString(a.points).crosses(shapely.LineString(b.points)) is False
