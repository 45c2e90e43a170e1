"""The search for the direction in which K_II vanishes: on a made-up tip whose K is a known function of the kink."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.interaction_integral import StressIntensity
from crackgrow.geometry.polyline import kink_angles
from crackgrow.run import direction
from crackgrow.run.direction import MOST_SOLVES, Advance, advance_tips
from crackgrow.run.scene import Scene, make_scene
from crackgrow.run.step import StepSolution, solve_step

CASE = Path(__file__).parents[3] / "cases" / "compression30.yaml"
Cracks = tuple[GrowingCrack, ...]
BOTH = np.array([0, 1])


@pytest.fixture(scope="module")
def start() -> tuple[Scene, Cracks, StepSolution]:
    implicit = ["growth.criterion=max_hoop_stress", "growth.direction=implicit", "numerics.spacing=3"]
    case = load_case(CASE, [*implicit, "growth.tip_stress.radius=2"])
    scene = make_scene(case)
    cracks = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    return scene, cracks, solve_step(scene, cracks, 1.0)


def advance(
    start: tuple[Scene, Cracks, StepSolution],
    monkeypatch: pytest.MonkeyPatch,
    K_II: Callable[[float], float],
    chosen: np.ndarray = BOTH,
    fails_at: int = -1,
) -> tuple[Advance, int]:
    """The advance where the new tips have K_I = 1 and K_II as a function of the kink (degrees); number of solves."""
    scene, cracks, solution = start
    solves = []

    def made_up(_: Scene, grown: Cracks, __: float) -> StepSolution:
        solves.append(grown)
        if len(solves) - 1 == fails_at:
            raise SolveError("no solution")
        kinks = np.rad2deg(kink_angles(grown[0].crack.points))
        states = []
        for state, kink in zip(solution.tips, (-kinks[0], kinks[-1]), strict=True):
            intensity = StressIntensity(1.0, K_II(kink), 0.0, 0.0, 1.0, False, "")
            states.append(replace(state, intensity=intensity))
        return replace(solution, tips=tuple(states), seconds={"contact": 1.0})

    monkeypatch.setattr(direction, "solve_step", made_up)
    return advance_tips(scene, cracks, solution, chosen, 1, 1.0), len(solves)


def kinks_of(found: Advance) -> list[float]:
    kinks = np.rad2deg(kink_angles(found.cracks[0].crack.points))
    return [float(-kinks[0]), float(kinks[-1])] if len(kinks) == 2 else kinks.tolist()


@pytest.mark.parametrize("slope", [0.005, 0.01, 0.04])
def test_two_tips_are_corrected_together(
    slope: float, start: tuple[Scene, Cracks, StepSolution], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kink of the start's tip is counted from its own direction: against the polyline."""
    found, n_solves = advance(start, monkeypatch, lambda kink: slope * (kink - 60.0) + 1e-5 * (kink - 60.0) ** 2)
    assert kinks_of(found) == pytest.approx([60.0, 60.0], abs=0.3)
    assert n_solves <= 5
    assert found.solution is not None
    assert found.solution.factorizations == n_solves
    assert found.solution.seconds == {"contact": float(n_solves)}
    assert found.solution.notes == ()


def test_where_K_II_does_not_vanish_the_best_direction_is_kept_and_told(
    start: tuple[Scene, Cracks, StepSolution], monkeypatch: pytest.MonkeyPatch
) -> None:
    found, n_solves = advance(start, monkeypatch, lambda kink: 0.1 + 1e-4 * abs(kink), np.array([1]))
    assert n_solves == MOST_SOLVES
    assert found.solution is not None
    assert "left K_II at 0.1" in found.solution.notes[0]


def test_a_trial_that_cannot_be_solved_ends_the_search(
    start: tuple[Scene, Cracks, StepSolution], monkeypatch: pytest.MonkeyPatch
) -> None:
    found, n_solves = advance(start, monkeypatch, lambda kink: 0.01 * (kink - 60.0), np.array([1]), fails_at=1)
    assert n_solves == 2
    assert found.solution is not None
    assert found.solution.factorizations == 1
    assert found.solution.notes
    first, _ = advance(start, monkeypatch, lambda kink: 0.0, np.array([1]), fails_at=0)
    assert first.solution is None  # the loop solves it again and says why that fails


def test_explicit_directions_are_the_criterions(start: tuple[Scene, Cracks, StepSolution]) -> None:
    scene, cracks, solution = start
    growth = scene.case.growth
    assert growth is not None
    explicit = replace(scene, case=replace(scene.case, growth=replace(growth, direction="explicit")))
    found = advance_tips(explicit, cracks, solution, BOTH, 1, 1.0)
    assert found.solution is None
    assert kinks_of(found) == pytest.approx([70.5, 70.5], abs=0.3)
