"""Newton on active sets, beside Lemke and from any start; the way it takes out of circles; problems on some points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import crackgrow.contact.newton as module
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import SLIP, ActiveSet, active_set, complementarity_residual
from crackgrow.contact.equations import ActiveEquations
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import CondensedPoints, ContactProblem, ContactSolution
from tests.contact_problems import crack_problem, dilating, random_problem, smooth, spread_problem
from tests.stability.contact_at_random import drawn

EXACT = 1e-10
"""Complementarity residual of a solution."""

NO_CURE = smooth(np.array([[1.0, -2.0], [-2.0, 1.0]]), np.array([-1.0, -1.0]))
"""Pressure on one point closes the other."""


def solved(problem: ContactProblem, start: np.ndarray | None = None) -> ContactSolution:
    solution = solve_by_newton(problem, start)
    assert solution.status == "solved"
    assert complementarity_residual(problem, solution.unknowns) < EXACT
    return solution


def agrees(problem: ContactProblem) -> None:
    """With Lemke, which accumulates round-off until its last solve."""
    newton, lemke = solved(problem), solve_by_lemke(problem)
    assert lemke.status == "solved"
    assert complementarity_residual(problem, lemke.traction) < EXACT
    scale = np.abs(newton.traction).max()
    np.testing.assert_allclose(newton.traction, lemke.traction, rtol=0.0, atol=1e-8 * scale)


@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e5, 1e8])
@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0, 3.0])
@pytest.mark.parametrize(("cohesion", "coupling"), [(0.0, 0.0), (0.1, 0.0), (0.0, 0.5), (0.1, 0.5)])
def test_crack_agrees_with_lemke(friction, cohesion, ratio, coupling) -> None:
    for n in (2, 9, 30):
        agrees(crack_problem(n, friction, cohesion, ratio, coupling, seed=n))


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(5))
def test_random_problem_agrees_with_lemke(friction, seed) -> None:
    agrees(random_problem(12, friction, seed))


@pytest.mark.parametrize("seed", range(40))
def test_faces_that_dilate_agree_with_lemke(seed: int) -> None:
    """Both hold the law; where slip passes the place that the faces have come from, Lemke's linear law ends."""
    problem = dilating(random_problem(4, 0.5, seed), seed)
    newton = solved(problem)
    through = ((problem.slipped + problem.jump(newton.traction)[4:]) * problem.slipped < -1e-12).any()
    if not through:
        agrees(problem)


@pytest.mark.parametrize("seed", [4, 8, 33, 48, 78, 97, 179])
def test_cycles_are_left(seed) -> None:
    """Strongly coupled problems with noise: these seeds return to an earlier active set for ever."""
    problem = crack_problem(3, 5.0, 0.1, 1e6, 0.8, seed)
    noise = np.random.default_rng(seed).normal(size=6) * np.repeat([1.0, 3.0], 3)
    solved(replace(problem, free=noise * np.abs(problem.free).max()), np.zeros(6))


def test_a_reversing_point_sticks_first_and_keeps_what_slip_has_opened() -> None:
    """This ends most cycles."""
    slipped = np.array([-0.3, 0.2, 0.1, 0.0])
    problem = replace(random_problem(4, 0.5, 1), dilation=np.full(4, 0.1), slipped=slipped)
    before, after = (
        ActiveSet(np.ones(4, dtype=bool), *[np.array(slip)] * 2) for slip in ([-1, 1, 1, 0], [1, -1, 1, -1])
    )
    following = module._through_stick(problem, before, after)
    assert following.slip.tolist() == [0, 0, 1, -1]
    assert following.sense.tolist()[:2] == [-1, 1]


@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_every_start_gives_the_same(friction) -> None:
    problem = crack_problem(50, friction, 0.05, 1e3, 0.4, 7)
    expected = solved(problem).traction
    scale = np.abs(expected).max()
    rng = np.random.default_rng(1)
    starts = [np.zeros(100), expected, np.full(100, -scale), np.full(100, scale), 1e3 * scale * rng.normal(size=100)]
    for start in starts:
        before = start.copy()
        np.testing.assert_allclose(solved(problem, start).traction, expected, rtol=0.0, atol=1e-11 * scale)
        np.testing.assert_array_equal(start, before)
    assert solve_by_newton(problem, expected).iterations == 1


def test_an_overlap_without_cure_ends_at_the_limit() -> None:
    assert solve_by_newton(NO_CURE).status == "limit"


def test_without_load_nothing_acts() -> None:
    unloaded = solved(ContactProblem(CondensedPoints(np.eye(4)), np.zeros(4), np.full(2, 0.3), np.zeros(2)))
    assert not unloaded.traction.any()


@pytest.mark.parametrize("start", [np.zeros(3), np.array([np.nan, 0.0])])
def test_wrong_start_is_refused(start) -> None:
    with pytest.raises(ValueError, match="contact start"):
        solve_by_newton(ContactProblem(CondensedPoints(np.eye(2)), np.zeros(2), np.zeros(1)), start)


def one_point(friction: float, free_n: float, free_t: float) -> ContactProblem:
    A = np.array([[1.0, 0.5], [0.5, 1.0]])
    return ContactProblem(CondensedPoints(A), np.array([free_n, free_t]), np.array([friction]))


def test_the_only_solution_is_found_beyond_a_fold() -> None:
    """Slip that presses the point less: on the branch that Newton comes to the point would pull."""
    found = solved(one_point(10.0, -1.0, -5.0))
    np.testing.assert_allclose(found.traction, [-1.0 / 6.0, -10.0 / 6.0])
    assert found.state.tolist() == [SLIP]


@pytest.mark.parametrize("seed", range(25))
def test_rock_of_any_friction_always_has_a_state(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    cohesion = np.where(rng.random(n) < 0.3, rng.uniform(0.0, 1.0, n), 0.0)
    solved(spread_problem(n, rng.uniform(0.0, 30.0, n), seed, cohesion))


@pytest.mark.parametrize("seed", [437, 509, 585, 765, 795, 895, 1453, 1563, 3511])
def test_where_active_sets_come_back_there_is_a_way_out(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = drawn(seed).problem.settled()
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < EXACT
    monkeypatch.setattr(module, "MOST_TIMES", 0)
    assert solve_by_newton(problem).status == "limit"


@pytest.mark.parametrize("seed", [*range(6), 16, 26, 39, 45, 61, 70, 73, 90, 99, 109, 129])
def test_an_update_of_the_factors_solves_the_equations_of_the_other_active_set(seed: int) -> None:
    """Also where contact alone holds blocks; points open, close, slip one way or the other, stick, and dilate."""
    tried = 0
    for problem in (
        drawn(seed).problem.settled()[0],
        random_problem(12, 0.4, seed),
        crack_problem(40, 0.4, 0.3, np.inf, 0.6, seed),
        dilating(random_problem(12, 0.4, seed), seed),
    ):
        known = solve_by_newton(problem)
        branches = active_set(problem, known.traction, problem.jump(known.unknowns))
        some = np.arange(problem.n_points) % 5 == seed % 5
        slip = np.where(some, (branches.slip + 2) % 3 - 1, branches.slip)
        other = ActiveSet(branches.closed ^ some, slip, np.where(slip == 0, branches.sense, slip))
        for first, last in ((branches, other), (other, branches)):
            fresh = ActiveEquations(problem, last)
            x = ActiveEquations(problem, first).solution(problem, last)
            if x is None or fresh.singular:
                continue
            exact = fresh.solution(problem, last)
            np.testing.assert_allclose(x, exact, rtol=0.0, atol=1e-7 * np.abs(exact).max())
            tried += 1
    assert tried >= 4


def test_an_update_is_made_where_few_points_leave_their_branches_alone() -> None:
    problem = random_problem(12, 0.4, 0)
    active = active_set(problem, np.full(24, -1.0), np.zeros(24))
    other = ActiveSet(~active.closed, active.slip, active.sense)
    assert ActiveEquations(problem, active).solution(problem, other, 0.5) is None
    assert ActiveEquations(problem, active).solution(problem, active, 0.0) is not None


def test_equations_of_other_points_serve_none() -> None:
    """However many points these are: more are dealt with where faces close on the way."""
    problem, other = (random_problem(n, 0.3, 1) for n in (7, 6))
    found, alone = (solve_by_newton(problem, near=near) for near in (solve_by_newton(other).equations, None))
    np.testing.assert_array_equal(found.traction, alone.traction)
