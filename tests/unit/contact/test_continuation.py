"""The way to a solution from points that all stick: by hand, beside all that there are, and where there is none."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from crackgrow.contact.continuation import followed
from crackgrow.contact.coulomb import OPEN, SLIP, ActiveSet, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.problem import ContactProblem, Motions
from tests.contact_problems import crack_problem, smooth


def one_point(friction: float, free_n: float, free_t: float, coupling: float) -> ContactProblem:
    A = np.array([[1.0, coupling], [coupling, 1.0]])
    return ContactProblem(A, np.array([free_n, free_t]), np.array([friction]))


@pytest.mark.parametrize("free_t", [-5.0, -1.0, 0.3, 7.0, 40.0])
@pytest.mark.parametrize("free_n", [-1.0, 0.5])
@pytest.mark.parametrize("friction", [0.0, 0.4, 1.9, 3.0, 10.0])
def test_one_point_ends_on_one_of_its_branches(friction: float, free_n: float, free_t: float) -> None:
    """With friction above 2 it may wedge itself: branches lead back, and there may be three solutions."""
    found = followed(one_point(friction, free_n, free_t, 0.5))
    assert found is not None
    assert complementarity_residual(one_point(friction, free_n, free_t, 0.5), found[0]) < 1e-12


def test_the_only_solution_is_found_beyond_a_fold() -> None:
    """Slip that presses the point less: on the branch that Newton comes to the point would pull."""
    x, active, _ = followed(one_point(10.0, -1.0, -5.0, 0.5)) or pytest.fail("no way")
    np.testing.assert_allclose(x, [-1.0 / 6.0, -10.0 / 6.0])
    assert active.states().tolist() == [SLIP]


@pytest.mark.parametrize("seed", range(25))
def test_rock_of_any_friction_always_has_a_state(seed: int) -> None:
    """Points coupled at random, as strongly as no rock couples them; bonds, and slip from before."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    B = rng.normal(size=(2 * n, 2 * n + 1))
    cohesion = np.where(rng.random(n) < 0.3, rng.uniform(0.0, 1.0, n), 0.0)
    problem = ContactProblem(B @ B.T / (2 * n), rng.normal(size=2 * n), rng.uniform(0.0, 30.0, n), cohesion)
    found = followed(problem)
    assert found is not None
    assert complementarity_residual(problem, found[0]) < 1e-9


def test_all_of_a_symmetric_scene_at_once() -> None:
    """Points that all change under the same load would leave no way to go on by one of them."""
    n = 8
    A = np.kron(np.array([[1.0, 0.3], [0.3, 1.0]]), np.eye(n))
    for load in ((-1.0, 0.9), (1.0, 0.2), (-1.0, -0.9)):
        problem = ContactProblem(A, np.repeat(load, n), np.full(n, 0.5))
        found = followed(problem)
        assert found is not None
        assert complementarity_residual(problem, found[0]) < 1e-12
        assert np.ptp(found[0].reshape(2, n), axis=1).max() < 1e-12


def test_it_is_the_solution_where_there_is_one() -> None:
    problem = crack_problem(12, 0.4, 0.0, np.inf, 0.3, 5)
    found = followed(problem)
    assert found is not None
    assert complementarity_residual(problem, found[0]) < 1e-12


def rocking(friction: float, pull: tuple[float, float, float]) -> ContactProblem:
    """A block on two points, one at each end of its base; motions: up, along, and rotation about the middle."""
    jump = np.array([[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    motions = Motions(jump, jump.T, np.array(pull))
    return ContactProblem(np.eye(4), np.zeros(4), np.full(2, friction), motions=motions)


def test_a_block_turns_about_a_corner_until_it_lies_on_the_other() -> None:
    """Off both its points, or on one alone, it is free to move: there the unknowns change and the loads do not."""
    problem = replace(rocking(2.0, (-1.0, 0.2, 0.4)), free=np.array([0.7, -0.2, 0.0, 0.3]))
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < 1e-12


@pytest.mark.parametrize("pull", [(1.0, 0.0, 0.0), (-1.0, 0.0, 1.3), (-1.0, 0.6, 0.0)])
def test_what_contact_does_not_hold_has_no_state(pull: tuple[float, float, float]) -> None:
    """Lifted off, tipped over, and dragged along."""
    assert solve_by_newton(rocking(0.5, pull)).status == "limit"


@pytest.mark.parametrize("gaps", [(0.7, -0.2), (-0.3, -0.3), (0.5, 0.4)])
def test_a_block_that_nothing_presses_lies_somewhere_without_tractions(gaps: tuple[float, float]) -> None:
    """Its place is not determined; that nothing acts between its faces is."""
    problem = replace(rocking(0.5, (0.0, 0.0, 0.0)), free=np.array([*gaps, 0.3, -0.1]))
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert np.abs(found.traction).max() < 1e-12
    assert complementarity_residual(problem, found.unknowns) < 1e-12


def test_no_way_leads_to_an_overlap_without_cure() -> None:
    assert followed(smooth(np.array([[1.0, -2.0], [-2.0, 1.0]]), np.array([-1.0, -1.0]))) is None


def test_open_points_and_no_points() -> None:
    found = followed(ContactProblem(np.eye(4), np.ones(4), np.full(2, 0.3)))
    assert found is not None
    assert not found[0].any()
    assert found[1].states().tolist() == [OPEN, OPEN]
    assert followed(ContactProblem(np.zeros((0, 0)), np.zeros(0), np.zeros(0))) is not None


@pytest.mark.parametrize("seed", range(10))
def test_it_ends_on_one_of_all_solutions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(4, 5))
    problem = ContactProblem(B @ B.T / 4.0, rng.normal(size=4) - 0.5, np.full(2, 10.0))
    every = []
    for branches in itertools.product(((False, 1), (True, 0), (True, 1), (True, -1)), repeat=2):
        closed, slip = zip(*branches, strict=True)
        p = solve_active(problem, ActiveSet(np.array(closed), np.array(slip), np.array(slip)))
        if complementarity_residual(problem, p) < 1e-9:
            every.append(p)
    found = followed(problem)
    assert found is not None
    assert min(float(np.abs(found[0] - p).max()) for p in every) < 1e-9 * np.abs(found[0]).max()
