"""Newton on active sets, beside Lemke and from any start; the way it takes out of circles; problems on some points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import crackgrow.contact.newton as module
from crackgrow.contact.condensed import Condensed
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.continuation import solve_by_continuation
from crackgrow.contact.coulomb import OPEN, SLIP, ActiveSet, active_set, complementarity_residual
from crackgrow.contact.equations import ActiveEquations
from crackgrow.contact.loose import deflated
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import ContactProblem, ContactSolution
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
    assert solve_by_continuation(NO_CURE) is None


def test_without_load_nothing_acts() -> None:
    unloaded = solved(ContactProblem(np.eye(4), np.zeros(4), np.full(2, 0.3), np.zeros(2)))
    assert not unloaded.traction.any()


@pytest.mark.parametrize("start", [np.zeros(3), np.array([np.nan, 0.0])])
def test_wrong_start_is_refused(start) -> None:
    with pytest.raises(ValueError, match="contact start"):
        solve_by_newton(ContactProblem(np.eye(2), np.zeros(2), np.zeros(1)), start)


def one_point(friction: float, free_n: float, free_t: float) -> ContactProblem:
    A = np.array([[1.0, 0.5], [0.5, 1.0]])
    return ContactProblem(A, np.array([free_n, free_t]), np.array([friction]))


def on_its_way(problem: ContactProblem, exact: float = 1e-12) -> tuple[np.ndarray, ActiveSet]:
    """The solution that the way from points that all stick leads to."""
    found = solve_by_continuation(problem)
    assert found is not None
    assert complementarity_residual(problem, found[0]) < exact
    return found[0], found[1]


def test_the_only_solution_is_found_beyond_a_fold() -> None:
    """Slip that presses the point less: on the branch that Newton comes to the point would pull."""
    x, active = on_its_way(one_point(10.0, -1.0, -5.0))
    np.testing.assert_allclose(x, [-1.0 / 6.0, -10.0 / 6.0])
    assert active.states().tolist() == [SLIP]
    _, apart = on_its_way(ContactProblem(np.eye(4), np.ones(4), np.full(2, 0.3)))
    assert apart.states().tolist() == [OPEN, OPEN]


@pytest.mark.parametrize("seed", range(25))
def test_rock_of_any_friction_always_has_a_state(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    cohesion = np.where(rng.random(n) < 0.3, rng.uniform(0.0, 1.0, n), 0.0)
    on_its_way(spread_problem(n, rng.uniform(0.0, 30.0, n), seed, cohesion), exact=1e-9)


def test_all_of_a_symmetric_scene_at_once() -> None:
    """Points that all change under the same load would leave no way to go on by one of them."""
    n = 8
    A = np.kron(np.array([[1.0, 0.3], [0.3, 1.0]]), np.eye(n))
    for load in ((-1.0, 0.9), (1.0, 0.2), (-1.0, -0.9)):
        x, _ = on_its_way(ContactProblem(A, np.repeat(load, n), np.full(n, 0.5)))
        assert np.ptp(x.reshape(2, n), axis=1).max() < 1e-12


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("friction", [0.0, 0.4, 1.0])
def test_points_that_are_solved_for_alone_lead_to_the_solution_of_all(friction: float, seed: int) -> None:
    """All others are on the branches that they have in the end."""
    for problem in (
        random_problem(12, friction, seed),
        crack_problem(40, friction, 0.3, np.inf, 0.6, seed),
        dilating(random_problem(12, max(friction, 0.3), seed), seed),
    ):
        known = solved(problem)
        branches = active_set(problem, known.traction, problem.jump(known.unknowns))
        some = np.arange(problem.n_points) % 3 == seed % 3
        wrong = replace(branches, closed=np.where(some, ~branches.closed, branches.closed))
        equations = ActiveEquations(problem, wrong)
        part = Condensed.onto(equations, equations.solution(), some)
        assert part is not None
        x = part.expanded(solve_by_newton(part.problem))
        assert complementarity_residual(problem, x) < 1e-11
        np.testing.assert_allclose(x, known.unknowns, atol=1e-9 * np.abs(known.traction).max())


@pytest.mark.parametrize("seed", [0, 16, 26, 39, 45, 61, 70, 73, 90, 99, 109, 129])
def test_what_slides_outside_works_on_the_motions_that_remain(seed: int) -> None:
    """Blocks on faces that slip: their shear changes with the tractions of the points that are solved for."""
    problem, _ = deflated(drawn(seed).problem)
    known = solve_by_newton(problem)
    branches = active_set(problem, known.traction, problem.jump(known.unknowns))
    slides = branches.states() == SLIP
    some = ~slides
    some[np.flatnonzero(slides)[::3]] = True
    equations = ActiveEquations(problem, replace(branches, slip=np.where(some & slides, 0, branches.slip)))
    part = Condensed.onto(equations, equations.solution(), some)
    assert part is not None
    assert part.problem.motions is not None
    assert (problem.friction[slides & ~some] > 0.0).any()
    assert complementarity_residual(problem, part.expanded(solve_by_newton(part.problem))) < EXACT
