"""A problem of half as many points: what it keeps of the whole, and that many points need no more steps than few."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.coarse import doubled, halved
from crackgrow.contact.coulomb import active_set
from crackgrow.contact.newton import first_guess, solve_by_newton
from crackgrow.contact.problem import ContactProblem
from tests.contact_problems import crack_problem, random_problem


def means(values: np.ndarray, n: int) -> np.ndarray:
    """Means of every two of n, block by block."""
    return np.concatenate([[block[i : i + 2].mean() for i in range(0, n, 2)] for block in values.reshape(-1, n)])


@pytest.mark.parametrize("n", [1, 2, 7, 12])
def test_tractions_alike_in_twos_have_the_mean_jumps(n: int) -> None:
    problem = random_problem(n, 0.4, n)
    coarse = halved(problem)
    assert coarse is not None
    assert coarse.n_points == (n + 1) // 2
    p = np.random.default_rng(n).normal(size=len(coarse.free))
    whole = doubled(problem, p)
    assert whole.shape == problem.free.shape
    np.testing.assert_allclose(means(whole, n), p)
    np.testing.assert_allclose(coarse.jump(p), means(problem.jump(whole), n), atol=1e-13)
    np.testing.assert_allclose(coarse.friction, 0.4)
    np.testing.assert_allclose(coarse.cohesion, means(problem.cohesion, n))


def test_points_that_have_no_resistance_together_are_not_halved() -> None:
    compliance = np.kron(np.eye(2), np.array([[1.0, -2.0], [-2.0, 1.0]]))
    assert halved(ContactProblem(compliance, -np.ones(4), np.zeros(2))) is None


@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_the_number_of_iterations_does_not_grow_with_the_points(friction: float) -> None:
    iterations = [solve_by_newton(crack_problem(n, friction, 0.0, np.inf, 0.3, 3)).iterations for n in (50, 200, 400)]
    assert max(iterations) <= 6  # 14 from sweeps alone for a thousand


@pytest.mark.parametrize("friction", [0.4, 1.0])
def test_the_first_guess_has_nearly_all_points_on_their_branches(friction: float) -> None:
    problem = crack_problem(200, friction, 0.0, np.inf, 0.3, 3)
    guess, solution = first_guess(problem), solve_by_newton(problem)
    found = active_set(problem, guess, problem.jump(guess)).states()
    assert np.mean(found != solution.state) < 0.1
