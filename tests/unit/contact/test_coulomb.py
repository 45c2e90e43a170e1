"""Contact law, residual and active-set solve, on problems solved by hand."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ActiveSet, active_set, complementarity_residual, project
from crackgrow.contact.equations import solve_active
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import CondensedPoints, ContactProblem
from crackgrow.errors import NotSolvedError
from tests.contact_problems import dilating, random_problem, smooth

ROUND_OFF = 1e-14


def one_point(free_n: float, free_t: float, friction: float, cohesion: float = 0.0, unit: float = 1.0):
    """A_nn = 2, A_tt = 4, no coupling: p_n = free_n / 2, p_t = free_t / 4 where closed and sticking."""
    compliance, free = np.diag([2.0, 4.0]) / unit, np.array([free_n, free_t])
    return ContactProblem(CondensedPoints(compliance), free, np.array([friction]), np.array([cohesion * unit]))


# free_n, free_t, friction, cohesion -> p_n, p_t, state
BY_HAND = [
    (1.0, 3.0, 0.5, 0.0, 0.0, 0.0, OPEN),
    (1.0, 3.0, 0.5, 0.2, 0.0, 0.2, OPEN),  # law (6) as written: cohesion acts at an open point
    (1.0, 0.4, 0.5, 0.2, 0.0, 0.1, OPEN),
    (-2.0, 1.0, 0.5, 0.0, -1.0, 0.25, STICK),
    (-2.0, 8.0, 0.5, 0.0, -1.0, 0.5, SLIP),
    (-2.0, -8.0, 0.5, 0.0, -1.0, -0.5, SLIP),
    (-2.0, -8.0, 0.5, 0.25, -1.0, -0.75, SLIP),
    (-2.0, 8.0, 0.0, 0.0, -1.0, 0.0, SLIP),
    (-2.0, 8.0, 5.0, 0.0, -1.0, 2.0, STICK),
]


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize(("free_n", "free_t", "friction", "cohesion", "p_n", "p_t", "state"), BY_HAND)
def test_one_point_by_hand(free_n, free_t, friction, cohesion, p_n, p_t, state, unit) -> None:
    """It has no residual, is what its branch gives, and what both solvers find."""
    problem = one_point(free_n, free_t, friction, cohesion, unit)
    p = np.array([p_n, p_t]) * unit
    near = {"rtol": ROUND_OFF, "atol": ROUND_OFF * unit}
    assert complementarity_residual(problem, p) <= ROUND_OFF
    active = active_set(problem, p, problem.jump(p))
    assert active.states().tolist() == [state]
    np.testing.assert_allclose(project(problem, p, problem.jump(p)), p, **near)
    np.testing.assert_allclose(solve_active(problem, active), p, **near)
    for solution in (solve_by_lemke(problem), solve_by_newton(problem)):
        assert solution.status == "solved"
        assert solution.state.tolist() == [state]
        np.testing.assert_allclose(solution.traction, p, atol=1e-12 * unit)


@pytest.mark.parametrize(
    ("free_n", "free_t", "p_n", "p_t", "violation"),
    [
        (-2.0, 0.0, -0.5, 0.0, "overlap alone"),
        (-2.0, 0.0, -2.0, 0.0, "pressure across a gap alone"),
        (2.0, 0.0, 0.5, 0.0, "tension alone"),
        (-2.0, 4.0, -1.0, 1.0, "no slip, shear beyond the bound alone"),
        (-2.0, -4.0, -1.0, -1.0, "the same backward"),
        (-2.0, 8.0, -1.0, 0.1, "forward slip below the bound alone"),
        (-2.0, -8.0, -1.0, -0.1, "backward slip below the bound alone"),
    ],
)
def test_each_violation_alone_is_detected(free_n, free_t, p_n, p_t, violation) -> None:
    assert complementarity_residual(one_point(free_n, free_t, 0.5), np.array([p_n, p_t])) > 0.1, violation


def test_singular_active_set_gets_the_least_tractions() -> None:
    problem = smooth(np.ones((3, 3)), np.array([-1.0, -1.0, -1.0]))
    p = solve_active(problem, ActiveSet(np.ones(3, dtype=bool), *np.ones((2, 3), dtype=np.int64)))
    np.testing.assert_allclose(p[:3], np.full(3, -1.0 / 3.0), rtol=1e-13)


@pytest.mark.parametrize("traction_unit", [1e-9, 1.0, 1e8])
@pytest.mark.parametrize("length_unit", [1e-9, 1.0, 1e6])
def test_residual_does_not_depend_on_units(traction_unit, length_unit) -> None:
    A, free, p = np.array([[2.0, 0.5], [0.5, 4.0]]), np.array([-2.0, 8.0]), np.array([-0.7, 0.9])
    friction, cohesion = np.array([0.5]), np.array([0.1])
    plain = complementarity_residual(ContactProblem(CondensedPoints(A), free, friction, cohesion), p)
    scaled = ContactProblem(
        CondensedPoints(A * length_unit / traction_unit), free * length_unit, friction, cohesion * traction_unit
    )
    assert complementarity_residual(scaled, p * traction_unit) == pytest.approx(plain, rel=1e-12)


def test_the_equations_of_a_branch_are_the_derivative_of_the_projection() -> None:
    """A Newton step for p = project(p), with a matrix by differences, ends where the branch's equations do."""
    compared, dilates = 0, 0
    for seed in range(400):
        rng = np.random.default_rng(seed + 1000)
        problem = dilating(random_problem(4, 0.5, seed), seed)
        p = np.append(-rng.random(4), rng.normal(size=4)) * 0.7

        def change(p: np.ndarray, problem: ContactProblem = problem) -> np.ndarray:
            return project(problem, p, problem.jump(p)) - p

        active = active_set(problem, p, problem.jump(p))
        if (active.sense != np.sign(problem.slipped + problem.jump(p)[4:])).any():
            continue  # where slip is about to end, faces dilate as they will then
        step = 1e-7
        J = np.stack([(change(p + step * e) - change(p - step * e)) / (2.0 * step) for e in np.eye(8)], axis=1)
        by_differences = p - np.linalg.solve(J, change(p))
        np.testing.assert_allclose(solve_active(problem, active), by_differences, atol=1e-5 * np.abs(p).max())
        compared += 1
        dilates += bool((active.closed & (active.slip != 0)).any())
    assert compared > 10
    assert dilates > 5


@pytest.mark.parametrize("name", ["compliance", "free", "friction", "cohesion"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_value_that_is_not_finite_names_its_field(name, value) -> None:
    arrays = {"compliance": np.eye(4), "free": np.zeros(4), "friction": np.zeros(2), "cohesion": np.zeros(2)}
    arrays[name].flat[1] = value
    with pytest.raises(NotSolvedError, match=f"contact {name}"):
        ContactProblem(CondensedPoints(arrays.pop("compliance")), **arrays)


def test_rock_that_does_not_resist_and_tractions_that_are_not_finite_are_refused() -> None:
    with pytest.raises(NotSolvedError, match="diagonal: entry 2"):
        ContactProblem(CondensedPoints(np.diag([1.0, 1.0, 0.0, 1.0])), np.zeros(4), np.zeros(2))
    with pytest.raises(NotSolvedError, match="traction"):
        complementarity_residual(one_point(1.0, 1.0, 0.5), np.array([np.nan, 0.0]))


def test_no_points_at_all() -> None:
    problem = ContactProblem(CondensedPoints(np.zeros((0, 0))), np.zeros(0), np.zeros(0))
    assert complementarity_residual(problem, np.zeros(0)) == 0.0
    for solve in (solve_by_newton, solve_by_lemke):
        assert solve(problem).status == "solved"
