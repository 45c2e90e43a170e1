"""The search for the direction in which K_II vanishes: on a made-up tip whose K is a known function of the kink."""

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
from crackgrow.geometry.polyline import kink_angles
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.propagation import MOST_SOLVES, AfterAdvance, BeforeAdvance, advance_tips
from tests.scenes import shipped_case
from tests.solving import solve_case

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
        return replace(start, tips=tuple(states), seconds={"contact": 1.0})

    return advance_tips(before, start, chosen, made_up), len(solves)


def kinks_of(found: AfterAdvance) -> list[float]:
    kinks = np.rad2deg(kink_angles(found.cracks[0].crack.points))
    return [float(-kinks[0]), float(kinks[-1])] if len(kinks) == 2 else kinks.tolist()


@pytest.mark.parametrize("slope", [0.005, 0.01, 0.04])
def test_two_tips_are_corrected_together(slope: float, start: StepSolution) -> None:
    """The kink of the start's tip is counted from its own direction: against the polyline."""
    found, n_solves = advance(start, lambda kink: slope * (kink - 60.0) + 1e-5 * (kink - 60.0) ** 2)
    assert kinks_of(found) == pytest.approx([60.0, 60.0], abs=0.3)
    assert n_solves <= 5
    assert found.solution is not None
    assert found.solution.factorizations == n_solves
    assert found.solution.seconds == {"contact": float(n_solves)}
    assert found.solution.notes == ()


def test_where_K_II_does_not_vanish_the_best_direction_is_kept_and_told(start: StepSolution) -> None:
    found, n_solves = advance(start, lambda kink: 0.1 + 1e-4 * abs(kink), np.array([1]))
    assert n_solves == MOST_SOLVES
    assert found.solution is not None
    assert "left K_II at 0.1" in found.solution.notes[0]


def test_a_trial_that_cannot_be_solved_ends_the_search(start: StepSolution) -> None:
    found, n_solves = advance(start, lambda kink: 0.01 * (kink - 60.0), np.array([1]), fails_at=1)
    assert n_solves == 2
    assert found.solution is not None
    assert found.solution.factorizations == 1
    assert "search for the direction of growth ended at trial 2" in found.solution.notes[0]
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
