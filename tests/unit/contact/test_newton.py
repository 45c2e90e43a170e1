"""Newton on active sets: by hand, on random and crack-like problems, against Lemke, from any start."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import ActiveSet, complementarity_residual
from crackgrow.contact.newton import _through_stick, solve_by_newton
from crackgrow.contact.problem import ContactProblem
from tests.contact_problems import crack_problem, random_problem, smooth

AGREEMENT = 1e-8  # of two solvers, relative; Lemke accumulates round-off until its last solve
EXACT = 1e-10  # complementarity residual of a solution


def check_both(problem):
    newton, other = solve_by_newton(problem), solve_by_lemke(problem)
    assert newton.status == other.status == "solved"
    assert complementarity_residual(problem, newton.traction) < EXACT
    assert complementarity_residual(problem, other.traction) < EXACT
    scale = np.abs(newton.traction).max()
    np.testing.assert_allclose(newton.traction, other.traction, rtol=0.0, atol=AGREEMENT * scale)


@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e5, 1e8])
@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0, 3.0])
@pytest.mark.parametrize(("cohesion", "coupling"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.5), (0.1, 0.5)])
def test_crack_agrees_with_lemke(friction, cohesion, ratio, coupling):
    for n in (2, 9, 30):
        check_both(crack_problem(n, friction, cohesion, ratio, coupling, seed=n))


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_random_problem_agrees_with_lemke(friction, seed):
    check_both(random_problem(12, friction, seed))


def test_rough_free_jump_at_high_friction_is_solved():
    for seed in range(10):
        problem = crack_problem(120, 5.0, 0.0, 1e3, 0.3, seed)
        noise = np.random.default_rng(seed).normal(size=240) * np.abs(problem.free).max()
        rough = ContactProblem(problem.compliance, problem.free + noise, problem.friction, problem.cohesion)
        solution = solve_by_newton(rough)
        assert solution.status == "solved"
        assert complementarity_residual(rough, solution.traction) < EXACT


@pytest.mark.parametrize("seed", [4, 8, 33, 48, 78, 97, 179])
def test_cycles_are_left(seed):
    """Strongly coupled problems with noise: these seeds return to an earlier active set for ever."""
    smooth = crack_problem(3, 5.0, 0.1, 1e6, 0.8, seed)
    noise = np.random.default_rng(seed).normal(size=6) * np.repeat([1.0, 3.0], 3)
    free = noise * np.abs(smooth.free).max()
    problem = ContactProblem(smooth.compliance, free, smooth.friction, smooth.cohesion)
    solution = solve_by_newton(problem, np.zeros(6))
    assert solution.status == "solved"
    assert complementarity_residual(problem, solution.traction) < EXACT


def test_a_reversing_point_sticks_first():
    closed, problem = np.ones(4, dtype=bool), random_problem(4, 0.5, 1)
    before, after = (ActiveSet(closed, *[np.array(slip)] * 2) for slip in ([1, -1, 1, 0], [-1, 1, 1, -1]))
    assert _through_stick(problem, before, after).slip.tolist() == [0, 0, 1, -1]


def test_a_reversing_point_that_sticks_keeps_what_slip_has_opened():
    closed, plain = np.ones(2, dtype=bool), random_problem(2, 0.5, 1)
    slipped, dilation = np.array([-0.3, 0.2]), np.full(2, 0.1)
    problem = ContactProblem(plain.compliance, plain.free, plain.friction, plain.cohesion, dilation, slipped)
    reversed_ = ActiveSet(closed, np.array([1, -1]), np.array([1, -1]))
    following = _through_stick(problem, ActiveSet(closed, -reversed_.slip, -reversed_.slip), reversed_)
    assert following.sense.tolist() == [-1, 1]


@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_every_start_gives_the_same(friction):
    problem = crack_problem(50, friction, 0.05, 1e3, 0.4, 7)
    expected = solve_by_newton(problem).traction
    scale = np.abs(expected).max()
    rng = np.random.default_rng(1)
    starts = [np.zeros(100), expected, np.full(100, -scale), np.full(100, scale), 1e3 * scale * rng.normal(size=100)]
    for start in starts:
        before = start.copy()
        solution = solve_by_newton(problem, start)
        assert solution.status == "solved"
        np.testing.assert_allclose(solution.traction, expected, rtol=0.0, atol=1e-11 * scale)
        np.testing.assert_array_equal(start, before)
    assert solve_by_newton(problem, expected).iterations == 1


def test_problem_without_solution_ends_at_the_limit():
    A = np.array([[1.0, -2.0], [-2.0, 1.0]])  # pressure on one point closes the other: the overlap has no cure
    solution = solve_by_newton(smooth(A, np.array([-1.0, -1.0])))
    assert solution.status == "limit"


def test_redundant_points_of_rigid_contact_share_the_load():
    problem = smooth(np.ones((3, 3)), np.array([-1.0, -1.0, -1.0]))
    solution = solve_by_newton(problem)
    assert solution.status == "solved"
    assert solution.traction.sum() == pytest.approx(-1.0)


def test_free_of_load_and_no_points():
    unloaded = solve_by_newton(ContactProblem(np.eye(4), np.zeros(4), np.full(2, 0.3), np.zeros(2)))
    assert unloaded.status == "solved"
    assert not unloaded.traction.any()
    assert solve_by_newton(ContactProblem(np.zeros((0, 0)), np.zeros(0), np.zeros(0))).status == "solved"


@pytest.mark.parametrize("start", [np.zeros(3), np.array([np.nan, 0.0])])
def test_wrong_start_is_refused(start):
    with pytest.raises(ValueError, match="contact start"):
        solve_by_newton(ContactProblem(np.eye(2), np.zeros(2), np.zeros(1)), start)
