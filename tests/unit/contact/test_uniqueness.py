"""Coulomb friction with several solutions or none: Klarbring's examples of one and two points in closed form."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from crackgrow.contact.coulomb import STICK
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.points import CondensedPoints
from crackgrow.contact.problem import ContactProblem
from crackgrow.contact.solve import solve_contact_problem
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import SolveError
from crackgrow.run.uniqueness import SecondSolution, friction_limit, other_solutions, second_solution, unique_text
from tests.contact_problems import contact_law, every_solution, rock_of, spread_problem
from tests.scenes import shipped_case
from tests.solving import solve_contact

ONE = np.ones(1)
C = 0.5
"""Coupling of the one point's gap and slip: a slipping point wedges itself where friction is above 1 / C = 2."""


def one_point(friction: float, free_n: float, free_t: float, c: float = C) -> ContactProblem:
    return ContactProblem(
        CondensedPoints(np.array([[1.0, c], [c, 1.0]])), np.array([free_n, free_t]), np.array([friction])
    )


def by_hand(friction: float, free_n: float, free_t: float, c: float = C) -> list[tuple[float, float]]:
    """All (p_n, p_t) of the one point: open, stuck, and slipping either way, each kept where its signs are right."""
    found = [(0.0, 0.0)] if free_n >= 0.0 else []
    p_n, p_t = (free_n - c * free_t) / (1.0 - c * c), (free_t - c * free_n) / (1.0 - c * c)
    if p_n < 0.0 and abs(p_t) < -friction * p_n:
        found.append((p_n, p_t))
    for way in (1.0, -1.0):
        p_n = free_n / (1.0 - way * friction * c)
        slip = free_t - (c - way * friction) * p_n
        if p_n < 0.0 and way * slip > 0.0:
            found.append((p_n, -way * friction * p_n))
    return found


def close(p: np.ndarray, solutions: list[tuple[float, float]]) -> bool:
    return any(np.allclose(p, q, rtol=1e-9, atol=1e-9) for q in solutions)


@pytest.mark.parametrize("friction", [0.0, 0.5, 1.7, 1.99, 2.5, 3.0, 10.0, 1e3])
def test_one_point_has_the_solutions_found_by_hand(friction: float) -> None:
    numbers = set()
    for free_n, free_t in itertools.product((-1.0, 1.0), (-7.3, -2.1, -0.4, 0.3, 1.9, 4.7, 5.3, 11.0, 23.0)):
        problem, known = one_point(friction, free_n, free_t), by_hand(friction, free_n, free_t)
        numbers.add(len(known))
        found = solve_contact_problem(problem, "newton")
        assert close(found.traction, known)
        others = list(other_solutions(problem, found.traction))
        assert all(close(p, known) for p in others)
        assert (len(known) > 1) == bool(others)
    assert numbers == ({1} if friction < 2.0 else {1, 3})


def test_the_limit_of_one_point_is_just_below_the_first_friction_with_several_solutions() -> None:
    for c in (0.01, 0.1, 0.5, 0.9):
        compliance = np.array([[1.0, c], [c, 1.0]])
        limit = friction_limit(compliance, ONE)
        assert limit == pytest.approx(np.sqrt(1.0 - c * c) / c)
        far = 1e3 / c
        assert len(by_hand(1.01 / c, 1.0, far, c)) == 3
        assert len(by_hand(0.99 / c, 1.0, far, c)) == 1
        assert limit < 1.0 / c


@pytest.mark.physics
@pytest.mark.parametrize("n", [1, 2, 3])
def test_below_the_limit_there_is_exactly_one_and_always_at_least_one(n: int) -> None:
    below = several = 0
    for seed, friction in itertools.product(range(20), (0.1, 0.3, 1.0, 30.0)):
        problem = spread_problem(n, friction, seed)
        number = len(every_solution(problem))
        assert number >= 1
        several += number > 1
        if friction < friction_limit(problem.points.compliance, np.ones(n)):
            below += 1
            assert number == 1
    assert below >= 10  # so that both happen
    assert several >= 1


def test_points_that_share_a_load_in_any_way_are_no_second_solution() -> None:
    """Two points at one place: how they share the pressure is open, where the faces lie is not."""
    compliance = np.kron(np.diag([1.0, 1.0]), np.ones((2, 2)))
    problem = ContactProblem(CondensedPoints(compliance), np.array([-1.0, -1.0, 0.1, 0.1]), np.full(2, 0.5))
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert friction_limit(compliance, np.ones(2)) == 0.0
    assert not list(other_solutions(problem, found.traction))


@pytest.mark.parametrize("solver", ["newton", "lemke"])
def test_no_solution_is_an_error_that_names_the_friction(solver: str) -> None:
    """No rock has this compliance (1 < 2): open, stuck and slipping all contradict themselves."""
    assert by_hand(3.0, -1.0, 0.0, 2.0) == []
    assert every_solution(one_point(3.0, -1.0, 0.0, 2.0)) == []
    with pytest.raises(SolveError, match=rf"{solver}: status.*less friction: of 3 it may leave several solutions"):
        solve_contact_problem(one_point(3.0, -1.0, 0.0, 2.0), solver)


def in_rock(problem: ContactProblem) -> tuple[ContactSystem, np.ndarray]:
    """Rock whose contact points have a given compliance, and the loads that give their free jumps."""
    stiffness, none = np.linalg.inv(problem.points.compliance), np.zeros(problem.n_points)
    return rock_of(stiffness, contact_law(problem.friction, none, none)), stiffness @ problem.free


@pytest.mark.physics
def test_a_second_solution_of_an_increment_is_found_with_its_place() -> None:
    """Two points, pressed and sheared: the solutions that starts lead to, held against all there are."""
    n_found = n_several = 0
    for seed in range(60):
        problem = spread_problem(2, 10.0, seed)
        contact, loads = in_rock(problem)
        outcome = solve_contact(contact, loads, np.zeros(0))
        number = len(every_solution(problem)) if len(outcome.points.rows) == 2 else 1
        second = second_solution(contact, outcome)
        n_several += number > 1
        assert second is None or number > 1
        if second is None:
            continue
        n_found += 1
        assert friction_limit(problem.points.compliance, np.ones(2)) < 10.0
        assert second.change[0] == second.change.max() > 0.0
        known = np.concatenate([outcome.points.normal, outcome.points.tangential])
        moved = [problem.points.compliance @ (p - known) for p in every_solution(problem)]
        largest = [np.hypot(*x.reshape(2, 2)) for x in moved]
        assert any(np.allclose(x[second.points], second.change, atol=1e-8) for x in largest)
    assert n_several >= 4
    assert n_found >= 0.75 * n_several


def told_of_the_flaw(*settings: str) -> list[str]:
    return list(unique_text(shipped_case("compression30", ["numerics.spacing=3", "growth.steps=0", *settings])))


@pytest.mark.physics
def test_every_load_factor_of_a_case_is_told_of() -> None:
    told = told_of_the_flaw("cracks.flaw.contact.friction=0.3", "loading.history=[0.5, -1, 1]")
    assert told == [
        "  at load factor 0.5: there is exactly one solution",
        "  at load factor -1: no faces touch: there is exactly one solution",
        "  at load factor 1: there is exactly one solution",
    ]
    (smooth_faces,) = told_of_the_flaw("cracks.flaw.contact.friction=0")
    assert "there is no friction" in smooth_faces
    (dilating,) = told_of_the_flaw("cracks.flaw.contact.friction=0.3", "cracks.flaw.contact.dilation_angle=5")
    assert "not known: faces that dilate" in dilating
    (beyond,) = told_of_the_flaw("cracks.flaw.contact.friction=50")
    assert "no second solution was found, which is no proof that there is none" in beyond
    assert "only where friction is below" in beyond


def test_a_scene_that_asks_for_its_safety_is_examined_with_the_strength_that_it_has() -> None:
    (told,) = unique_text(shipped_case("slope_safety", ["numerics.spacing=2"]))
    assert told.startswith("  at load factor 1: ")


@pytest.mark.physics
def test_a_second_solution_is_told_with_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    found = SecondSolution(np.array([2, 0]), np.array([3e-5, 1e-6]), np.array([STICK, STICK]))
    monkeypatch.setattr("crackgrow.run.uniqueness.second_solution", lambda contact, outcome: found)
    monkeypatch.setattr("crackgrow.run.uniqueness.friction_limit", lambda compliance, weights: 0.25)
    (told,) = told_of_the_flaw("cracks.flaw.contact.friction=0.3")
    assert "more than one solution (it is certain only where friction is below 0.25)" in told
    assert "of 'flaw', which slips, sticks, its faces moved by 30 um" in told
