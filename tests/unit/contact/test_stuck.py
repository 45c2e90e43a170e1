"""Points among others that stick: the states are those that Newton's method with all points finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.contact.coulomb import STICK, active_set, complementarity_residual
from crackgrow.contact.newton import solve_settled
from crackgrow.contact.problem import CondensedPoints, ContactProblem
from crackgrow.contact.stuck import solve_among_stuck

pytestmark = pytest.mark.physics


def pressed_block(n: int, pieces: int, seed: int) -> ContactProblem:
    """Blocks of rock on points of unequal lengths that most of them stick on; `pieces` of them contact alone holds."""
    rng = np.random.default_rng(seed)
    x, lengths = np.sort(rng.uniform(0.0, 1.0, n)), rng.uniform(0.5, 2.0, n) / n
    rock = np.exp(-9.0 * np.abs(x[:, None] - x)) + 0.1 * np.eye(n)
    coupling = 0.1 * np.exp(-9.0 * np.abs(x[:, None] - x)) * np.sin(x + x[:, None])
    weights, own = np.tile(lengths, 2), np.arange(n) * (pieces + 1) // n  # the last piece is held
    A = np.block([[rock, coupling], [coupling, rock]]) * weights
    jump = np.zeros((2 * n, 3 * pieces))
    for piece in range(pieces):
        some = np.flatnonzero(own == piece)
        jump[some, 3 * piece], jump[n + some, 3 * piece + 1], jump[some, 3 * piece + 2] = 1.0, 1.0, x[some]
    force = (jump * weights[:, None]).T
    pressure = np.concatenate([-1.0 - 0.3 * np.sin(20.0 * x), 0.45 * np.cos(9.0 * x)])
    law = np.full(n, 0.4), np.zeros(n), np.zeros(n), np.zeros(n)
    free = A @ pressure + 0.002 * np.append(np.sin(60.0 * x), np.zeros(n))
    return ContactProblem(CondensedPoints(A, jump, force, weights), free, *law, force @ pressure)


@pytest.mark.parametrize("pieces", [0, 2])
@pytest.mark.parametrize("seed", range(3))
def test_the_states_are_those_of_newtons_method_with_all_points(pieces: int, seed: int) -> None:
    problem = pressed_block(80, pieces, seed)
    known, found = solve_settled(problem), solve_among_stuck(problem)
    assert found is not None
    assert known.status == found.status == "solved"
    assert 0 < np.sum(known.state != STICK) < 40
    np.testing.assert_array_equal(found.state, known.state)
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())
    assert complementarity_residual(problem, found.unknowns) < 1e-12


@pytest.mark.parametrize("pieces", [0, 2])
def test_a_state_leads_to_one_that_is_near_and_to_that_on_its_branches(pieces: int) -> None:
    problem = pressed_block(80, pieces, 1)
    near = solve_settled(replace(problem, free=1.1 * problem.free, pull=1.2 * problem.pull))
    known, found = solve_settled(problem), solve_among_stuck(problem, near.unknowns)
    assert found is not None
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())
    branches = active_set(problem, known.traction, problem.jump(known.unknowns))
    found = solve_among_stuck(problem, active=branches)
    assert found is not None
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())


@pytest.mark.parametrize("pieces", [0, 2])
def test_points_that_all_stick_take_one_solution(pieces: int) -> None:
    problem = replace(pressed_block(40, pieces, 0), friction=np.full(40, 5.0))
    known, found = solve_settled(problem), solve_among_stuck(problem)
    assert found is not None
    assert found.iterations == 0
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())


def test_where_most_points_slip_all_are_left_to_newtons_method() -> None:
    problem = pressed_block(40, 0, 0)
    assert solve_among_stuck(replace(problem, friction=np.full(40, 0.01))) is None


def test_faces_that_dilate_and_have_slipped_are_left_to_newtons_method() -> None:
    """They stand open while they stick."""
    problem = pressed_block(40, 0, 0)
    assert solve_among_stuck(problem) is not None
    assert solve_among_stuck(replace(problem, dilation=np.full(40, 0.1), slipped=np.full(40, 1e-3))) is None
