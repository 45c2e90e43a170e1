"""What a step says of contact that is not to be trusted."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.ripple import worst_ripple
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.unit.cell_sizes import with_sizes

CASE = "compression30"


def flaw(*overrides: str) -> StepSolution:
    case = shipped_case(CASE, ["numerics.spacing=3", "growth.steps=0", *overrides])
    return solve_step(make_scene(case), (GrowingCrack.given(case.cracks[0]),), 1.0)


def test_the_ripple_of_a_surface_is_held_against_its_own_pressure() -> None:
    solution = flaw("numerics.contact.discretization=gauss", "numerics.contact.stiffness=1")
    n = solution.faces.n
    calm = np.full(n, -75e6)
    wave = calm + 15e6 * (-1.0) ** np.arange(n)
    for factor in (1.0, 1e-9):
        worst = worst_ripple(solution.cover, solution.faces, factor * wave, np.zeros(n))
        assert worst is not None
        assert worst.part == pytest.approx(30.0 / 75.0, rel=0.01)
    sheared = worst_ripple(solution.cover, solution.faces, calm, wave)
    assert sheared is not None
    assert sheared.part == pytest.approx(30.0 / 75.0, rel=0.01)
    assert worst_ripple(solution.cover, solution.faces, np.zeros(n), np.zeros(n)) is None
    smaller = with_sizes(solution.cover, 1.0 / 64.0)
    carried = worst_ripple(smaller, solution.faces, wave, np.zeros(n))
    assert carried is not None
    assert carried.part == 0.0  # so small cells carry that wave
