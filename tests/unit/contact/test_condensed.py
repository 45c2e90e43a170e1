"""The contact problem condensed onto some of its points: the same as on all of them, at the cost of few."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import crackgrow.contact.newton as module
from crackgrow.contact.condensed import Condensed
from crackgrow.contact.coulomb import SLIP, STICK, active_set, complementarity_residual
from crackgrow.contact.equations import ActiveEquations
from crackgrow.contact.loose import settled
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import ContactProblem
from tests.contact_problems import crack_problem, random_problem
from tests.stability.contact_at_random import drawn


def dilating(problem: ContactProblem, seed: int) -> ContactProblem:
    """The problem with faces that dilate and have slipped before."""
    slipped = np.random.default_rng(seed).normal(size=problem.n_points) * np.abs(problem.free).max()
    return replace(problem, dilation=np.full(problem.n_points, 0.1), slipped=slipped)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_points_that_are_solved_for_alone_lead_to_the_solution_of_all(friction: float, seed: int) -> None:
    """All others are on the branches that they have in the end."""
    for problem in (
        random_problem(12, friction, seed),
        crack_problem(40, friction, 0.3, np.inf, 0.6, seed),
        dilating(random_problem(12, max(friction, 0.3), seed), seed),
    ):
        known = solve_by_newton(problem)
        assert known.status == "solved"
        branches = active_set(problem, known.traction, problem.jump(known.unknowns))
        some = np.arange(problem.n_points) % 3 == seed % 3
        wrong = replace(branches, closed=np.where(some, ~branches.closed, branches.closed))
        equations = ActiveEquations(problem, wrong)
        part = Condensed.onto(equations, equations.solution(), some)
        assert part is not None
        x = part.expanded(solve_by_newton(part.problem))
        assert complementarity_residual(problem, x) < 1e-11
        np.testing.assert_allclose(x, known.unknowns, atol=1e-9 * np.abs(known.traction).max())


def test_compliance_of_stuck_surroundings_is_a_schur_complement() -> None:
    problem = random_problem(12, 0.5, 1)
    stuck = active_set(problem, np.repeat([-1e9, 0.0], 12), np.zeros(24))
    assert (stuck.states() == STICK).all()
    equations = ActiveEquations(problem, stuck)
    some = np.arange(12) < 4
    part = Condensed.onto(equations, equations.solution(), some)
    at = np.flatnonzero(np.tile(some, 2))
    rest = np.setdiff1d(range(24), at)
    A, own = problem.compliance, problem.compliance[np.ix_(at, at)]
    expected = own - A[np.ix_(at, rest)] @ np.linalg.solve(A[np.ix_(rest, rest)], A[np.ix_(rest, at)])
    assert part is not None
    np.testing.assert_allclose(part.problem.compliance, expected, atol=1e-12 * np.abs(expected).max())


def test_problems_that_are_solved_again_and_again_are_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here 200 points stick but for those next to a place where the faces are pressed less."""
    n, sizes, step = 200, [], module._stepped

    def sized(problem, active):
        sizes.append(problem.n_points)
        return step(problem, active)

    monkeypatch.setattr(module, "_stepped", sized)
    A = crack_problem(n, 0.5, 0.0, np.inf, 0.0, 0).compliance
    x = np.linspace(-1.0, 1.0, n)
    pressure, shear = 1.0 - 0.8 * np.exp(-100.0 * x**2), np.full(n, 0.3)
    problem = ContactProblem(A, A @ np.concatenate([-pressure, shear]), np.full(n, 0.5))
    found = solve_by_newton(problem)
    moving = int((found.state != STICK).sum())
    assert 0 < moving < 0.2 * n
    assert sizes[0] == n
    assert 0 < max(sizes[1:]) <= moving + 4
    assert complementarity_residual(problem, found.unknowns) < 1e-12


def test_a_cycle_is_solved_on_the_points_that_go_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """One point goes round in circles among 30 that do not: the way of that one is followed."""
    sizes, follow = [], module.followed

    def sized(problem):
        sizes.append(problem.n_points)
        return follow(problem)

    monkeypatch.setattr(module, "followed", sized)
    many = random_problem(30, 0.4, 5)
    one = ContactProblem(np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([-1.0, -5.0]), np.array([10.0]))
    size = np.abs(many.free).max()  # the one is as large as the others
    at = np.append(np.arange(60) + np.repeat([0, 1], 30), [30, 61])
    compliance, free = np.zeros((62, 62)), np.zeros(62)
    compliance[np.ix_(at[:60], at[:60])], compliance[np.ix_(at[60:], at[60:])] = many.compliance, one.compliance
    free[at[:60]], free[at[60:]] = many.free, size * one.free
    compliance[at[0], at[60]] = compliance[at[60], at[0]] = 1e-3 * many.compliance[0, 0]
    problem = ContactProblem(compliance, free, np.append(many.friction, one.friction))
    found = solve_by_newton(problem)
    assert complementarity_residual(problem, found.unknowns) < 1e-10
    assert sizes
    assert max(sizes) <= 3


def test_wedged_points_are_solved_for_with_those_that_feel_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of these blocks one point alone has no solution while the others slip; with its neighbours it has one."""
    taken, more = [], Condensed.most_sensitive
    monkeypatch.setattr(
        Condensed, "most_sensitive", lambda part, points: taken.append(points.sum()) or more(part, points)
    )
    monkeypatch.setattr(module, "_by_springs", lambda *problem: pytest.fail("all by springs"))
    problem, _ = settled(drawn(105).problem)
    found = solve_by_newton(problem)
    assert taken[0] < 0.2 * problem.n_points
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < 1e-10


@pytest.mark.parametrize("seed", [0, 16, 26, 39, 45, 61, 70, 73, 90, 99, 109, 129])
def test_what_slides_outside_works_on_the_motions_that_remain(seed: int) -> None:
    """Blocks on faces that slip: their shear changes with the tractions of the points that are solved for."""
    problem, _ = settled(drawn(seed).problem)
    known = solve_by_newton(problem)
    branches = active_set(problem, known.traction, problem.jump(known.unknowns))
    slides = branches.states() == SLIP
    some = ~slides
    some[np.flatnonzero(slides)[::3]] = True
    equations = ActiveEquations(problem, replace(branches, slip=np.where(some & slides, 0, branches.slip)))
    part = Condensed.onto(equations, equations.solution(), some)
    assert part is not None
    assert part.problem is not None
    assert part.problem.motions is not None
    assert (problem.friction[slides & ~some] > 0.0).any()
    x = part.expanded(solve_by_newton(part.problem))
    assert complementarity_residual(problem, x) < 1e-10
