"""Coulomb's law and contact problems: by hand, Newton on active sets beside Lemke; problems that are hard for Lemke."""

from __future__ import annotations

import numpy as np
import pytest

import crackgrow.contact.newton as module
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ActiveSet, active_set, complementarity_residual, project
from crackgrow.contact.equations import solve_active
from crackgrow.contact.lemke import LcpResult, lemke, solve_by_lemke
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.points import CondensedPoints
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.errors import NotSolvedError
from tests.contact_problems import crack_problem, dilating, drawn, random_problem

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
    compliance = np.kron(np.eye(2), np.ones((3, 3))) + np.kron(np.diag([0.0, 1.0]), np.eye(3))
    problem = ContactProblem(CondensedPoints(compliance), np.repeat([-1.0, 0.0], 3), np.zeros(3))
    p = solve_active(problem, ActiveSet(np.ones(3, dtype=bool), *np.ones((2, 3), dtype=np.int64)))
    np.testing.assert_allclose(p[:3], np.full(3, -1.0 / 3.0), rtol=1e-13)


@pytest.mark.parametrize("name", ["compliance", "free", "friction", "cohesion"])
def test_values_that_are_not_finite_and_rock_that_does_not_resist_are_refused(name: str) -> None:
    arrays = {"compliance": np.eye(4), "free": np.zeros(4), "friction": np.zeros(2), "cohesion": np.zeros(2)}
    arrays[name].flat[1] = np.nan
    with pytest.raises(NotSolvedError, match=f"contact {name}"):
        ContactProblem(CondensedPoints(arrays.pop("compliance")), **arrays)
    with pytest.raises(NotSolvedError, match="diagonal: entry 2"):
        ContactProblem(CondensedPoints(np.diag([1.0, 1.0, 0.0, 1.0])), np.zeros(4), np.zeros(2))


EXACT = 1e-10
"""Complementarity residual of a solution."""


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


@pytest.mark.parametrize("seed", range(40))
def test_faces_that_dilate_agree_with_lemke(seed: int) -> None:
    """Both hold the law; where slip passes the place that the faces have come from, Lemke's linear law ends."""
    problem = dilating(random_problem(4, 0.5, seed), seed)
    newton = solved(problem)
    through = ((problem.slipped + problem.jump(newton.traction)[4:]) * problem.slipped < -1e-12).any()
    if not through:
        agrees(problem)


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


def test_the_only_solution_is_found_beyond_a_fold() -> None:
    """Slip that presses the point less: on the branch that Newton comes to the point would pull."""
    points = CondensedPoints(np.array([[1.0, 0.5], [0.5, 1.0]]))
    found = solved(ContactProblem(points, np.array([-1.0, -5.0]), np.array([10.0])))
    np.testing.assert_allclose(found.traction, [-1.0 / 6.0, -10.0 / 6.0])
    assert found.state.tolist() == [SLIP]


@pytest.mark.parametrize("seed", [437, 509, 585, 765, 795, 895, 1563])
def test_where_active_sets_come_back_there_is_a_way_out(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = drawn(seed).problem.settled()
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < EXACT
    monkeypatch.setattr(module, "MOST_TIMES", 0)
    assert solve_by_newton(problem).status == "limit"


def violation(M: np.ndarray, q: np.ndarray, result: LcpResult) -> float:
    """Worst violation of w = M z + q, w >= 0, z >= 0, z w = 0 against the terms of a row and the largest z."""
    z, w = result.z, result.w
    terms = np.abs(M) @ np.abs(z) + np.abs(q)
    w, off = (part / np.where(terms > 0.0, terms, 1.0) for part in (w, w - M @ z - q))
    z = z / max(float(np.abs(z).max()), np.finfo(float).tiny)
    return float(np.max([np.abs(off), -w, -z, np.abs(w * z)]))


@pytest.mark.parametrize("degenerate", [0.3, 0.9])
@pytest.mark.parametrize("seed", range(20))
def test_degenerate_integer_problems_end(seed: int, degenerate: float) -> None:
    """Copositive-plus matrices of small integers and right-hand sides full of equal numbers."""
    rng = np.random.default_rng(seed)
    B, S = rng.integers(-1, 2, (2, 10, 10))
    M = (B @ B.T + S - S.T + np.eye(10)).astype(float)
    q = np.where(rng.random(10) < degenerate, -1.0, rng.integers(-1, 2, 10))
    result = lemke(M, q, max_pivots=500)
    assert result.status == "solved"
    assert violation(M, q, result) <= 1e-9


@pytest.mark.parametrize("spread", [6, 60, 600])
@pytest.mark.parametrize("of", [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
def test_units_of_rows_and_columns_do_not_matter(of: tuple[float, float], spread: int) -> None:
    """They differ by `spread` powers of ten: the same problem, the same solution."""
    for seed in range(10):
        rng, n = np.random.default_rng(seed), 20
        B = rng.normal(size=(n, n))
        M = B @ B.T / n + 0.1 * np.eye(n)
        z = np.where(rng.random(n) < 0.5, rng.random(n), 0.0)
        q = np.where(z > 0.0, 0.0, rng.random(n)) - M @ z
        row, column = 10.0 ** (np.array(of)[:, None] * rng.uniform(-0.25 * spread, 0.25 * spread, (2, n)))
        result = lemke(row[:, None] * M * column, row * q)
        assert violation(row[:, None] * M * column, row * q, result) <= 1e-9
        np.testing.assert_allclose(result.z * column, z, atol=1e-12)


@pytest.mark.parametrize(
    ("M", "q"),
    [
        ([[0.0, 0.0], [0.0, 1.0]], [-1e-12, -1.0]),  # a row of zeros can't be made positive, however small q
        ([[1.0, -1.0], [-1.0, 1.0]], [1.0, -2.0]),  # w_1 + w_2 = -1
        ([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [-1.0, -1.0, -1.0]),  # -z_1 - 1 >= 0
    ],
)
def test_problems_without_a_solution_end_in_a_ray(M: list[list[float]], q: list[float]) -> None:
    assert lemke(np.array(M), np.array(q)).status == "ray"


@pytest.mark.parametrize("exponent", range(-14, 15, 4))
def test_solved_is_never_said_of_a_wrong_solution(exponent: int) -> None:
    """Random matrices of no class, near-singular ones among them: any status, but "solved" only if it is."""
    statuses = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        M = rng.normal(size=(8, 8))
        M[:, 1] = M[:, 0] + 10.0**exponent * M[:, 1]
        M[1] = M[0] + 10.0**exponent * M[1]
        q = rng.normal(size=8)
        result = lemke(M, q)
        statuses.add(result.status)
        assert result.status != "solved" or violation(M, q, result) <= 1e-8
    assert {"solved", "ray"} <= statuses
