"""Newton on the points that move: the same as on all points, at the cost of few."""

from __future__ import annotations

import crackgrow.contact.stuck as module
import numpy as np
import pytest
from crackgrow.contact.stuck import solve_where_points_move

from crackgrow.contact.coulomb import STICK, complementarity_residual
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import ContactProblem
from tests.contact_problems import crack_problem, random_problem


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_it_agrees_with_steps_on_all_points(friction: float, seed: int) -> None:
    for problem in (random_problem(12, friction, seed), crack_problem(40, friction, 0.3, np.inf, 0.6, seed)):
        found, known = solve_where_points_move(problem, most_moving=1.0), solve_by_newton(problem)
        assert found is not None
        assert known.status == "solved"
        assert complementarity_residual(problem, found.unknowns) < 1e-12
        np.testing.assert_allclose(found.traction, known.traction, atol=1e-9 * np.abs(known.traction).max())
        np.testing.assert_array_equal(found.state, known.state)


def test_dilating_points_that_stick_keep_their_gap() -> None:
    rng, n = np.random.default_rng(3), 12
    problem = random_problem(n, 0.6, 3)
    dilation, slipped = np.full(n, 0.1), rng.normal(size=n) * np.abs(problem.free).max()
    problem = ContactProblem(problem.compliance, problem.free, problem.friction, problem.cohesion, dilation, slipped)
    found, known = solve_where_points_move(problem, most_moving=1.0), solve_by_newton(problem)
    assert found is not None
    assert (found.state == STICK).any()
    np.testing.assert_allclose(found.traction, known.traction, atol=1e-9 * np.abs(known.traction).max())


def test_problems_that_are_solved_again_and_again_are_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here 200 points stick but for those next to a place where the faces are pressed less."""
    n, sizes, solve = 200, [], module.solve_by_newton

    def sized(problem, start):
        sizes.append(problem.n_points)
        return solve(problem, start)

    monkeypatch.setattr(module, "solve_by_newton", sized)
    A = crack_problem(n, 0.5, 0.0, np.inf, 0.0, 0).compliance
    x = np.linspace(-1.0, 1.0, n)
    pressure, shear = 1.0 - 0.8 * np.exp(-50.0 * x**2), np.full(n, 0.3)
    problem = ContactProblem(A, A @ np.concatenate([-pressure, shear]), np.full(n, 0.5))
    found = solve_where_points_move(problem)
    assert found is not None
    moving = int((found.state != STICK).sum())
    assert 0 < moving < 0.3 * n
    assert max(sizes) <= moving + 4
    assert complementarity_residual(problem, found.unknowns) < 1e-12
