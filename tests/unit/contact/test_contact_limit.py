"""What contact can hold, by hand: a block on a slope, one that tips over; points among others that stick."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.contact.coulomb import STICK, active_set, complementarity_residual
from crackgrow.contact.hold import alone, least_unbalanced
from crackgrow.contact.lemke import solve_by_lemke
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.points import CondensedPoints
from crackgrow.contact.problem import ContactProblem
from crackgrow.contact.stuck import solve_among_stuck
from crackgrow.solid.rigid_modes import FreePiece

pytestmark = pytest.mark.physics

WEIGHT, LENGTH = 3.0, 2.0


def block_on_slope(angle: float, height: float, friction: float, cohesion: float = 0.0) -> tuple[float, np.ndarray]:
    """A block on a slope (degrees), its base of length 2 at two points, its weight at `height`: up, along, rotation."""
    a = np.deg2rad(angle)
    gap = np.array([[1.0, 0.0, -1.0], [1.0, 0.0, 1.0]])
    slip = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    pull = WEIGHT * np.array([-np.cos(a), np.sin(a), -height * np.sin(a)])
    jump = np.concatenate([gap, slip])
    motions = 0.5 * LENGTH * jump.T, pull
    return least_unbalanced(motions, WEIGHT, LENGTH, np.full(2, friction), np.full(2, cohesion), np.zeros(2))


SLOPE = np.deg2rad(20.0)
LACKING = WEIGHT * np.sin(SLOPE) / LENGTH
LIMITS = [
    (20.0, 0.1, np.tan(SLOPE), 0.0, np.sin(SLOPE)),
    (40.0, 0.1, np.tan(2.0 * SLOPE), 0.0, np.sin(2.0 * SLOPE)),
    (20.0, 0.1, 0.0, LACKING, np.sin(SLOPE)),
]
"""Slope, height, the friction and cohesion that just hold the block, and the part of its weight that these bear."""


@pytest.mark.parametrize(("angle", "height", "friction", "cohesion", "borne"), LIMITS)
def test_a_block_slides_where_friction_and_cohesion_lack(
    angle: float, height: float, friction: float, cohesion: float, borne: float
) -> None:
    assert block_on_slope(angle, height, 1.001 * friction, 1.001 * cohesion)[0] == pytest.approx(0.0, abs=1e-9)
    left, way = block_on_slope(angle, height, 0.9 * friction, 0.9 * cohesion)
    assert left == pytest.approx(0.1 * borne, rel=1e-6)
    assert np.argmax(np.abs(way)) == 1  # it goes along the slope


def test_a_tall_block_tips_over_however_much_friction_and_one_upside_down_falls() -> None:
    assert block_on_slope(30.0, 1.7, 5.0)[0] == pytest.approx(0.0, abs=1e-9)  # up to 1 / tan(30 degrees) = 1.73
    assert block_on_slope(30.0, 1.8, 5.0)[0] > 0.01
    assert block_on_slope(180.0, 0.0, 1.0)[0] == pytest.approx(1.0)


def block_on_points(friction: float, pull: tuple[float, float, float], cohesion: float = 0.0) -> ContactProblem:
    """A block of rock on a row of points that it does not sink into evenly; motions: up, along, and rotation."""
    n = 5
    x = np.linspace(-1.0, 1.0, n)
    rock = np.exp(-2.0 * np.abs(x[:, None] - x)) + 0.1 * np.eye(n)
    A = np.block([[rock, 0.2 * np.eye(n)], [0.2 * np.eye(n), rock]])
    none = np.zeros(n)
    jump = np.column_stack([np.append(none + 1.0, none), np.append(none, none + 1.0), np.append(x, none)])
    weights = np.full(2 * n, 2.0 / n)
    laws = (np.full(n, friction), np.full(n, cohesion), none, none)
    points = CondensedPoints(A, jump, (jump * weights[:, None]).T)
    return ContactProblem(points, np.append(0.02 * np.sin(9.0 * x), none), *laws, np.array(pull))


HELD = [
    (0.4, (-3.0, 1.1, 0.0), 0.0),
    (0.4, (-3.0, -1.19999, 0.3), 0.0),  # all but sliding
    (0.4, (-3.0, 0.2, 2.3), 0.0),  # nearly on one edge
    (0.0, (-3.0, 0.9, 0.0), 0.5),
    (1.5, (-3.0, 3.9, -1.0), 0.0),
]


@pytest.mark.parametrize(("friction", "pull", "cohesion"), HELD)
def test_a_block_that_contact_alone_holds_is_balanced(friction: float, pull: tuple, cohesion: float) -> None:
    """Forces along its motions are those of the loads, by hand; both solvers find the same state."""
    problem = block_on_points(friction, pull, cohesion)
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < 1e-10
    normal, shear = found.traction.reshape(2, -1) * 0.4
    x = np.linspace(-1.0, 1.0, 5)
    np.testing.assert_allclose([normal.sum(), shear.sum(), x @ normal], pull, atol=1e-10)
    lemke = solve_by_lemke(problem)
    assert lemke.status == "solved"
    np.testing.assert_allclose(lemke.traction, found.traction, atol=1e-8)


@pytest.mark.parametrize("softness", [0.0, 1.0, 1e4, 1e8])
@pytest.mark.parametrize(("friction", "pull", "cohesion"), HELD)
def test_how_supports_hold_a_block_once_does_not_matter(
    friction: float, pull: tuple, cohesion: float, softness: float
) -> None:
    """They add rigid motions to what tractions do; a settled block loses no digits however far it turns."""
    problem = block_on_points(friction, pull, cohesion)
    points, known = problem.points, solve_by_newton(problem)
    turned = np.random.default_rng(4).normal(size=(3, 3))
    moved = softness * points.jump @ (turned @ turned.T)
    points = replace(points, matrix=points.compliance + moved @ points.force)
    held = replace(problem, points=points, free=problem.free + moved @ problem.pull)
    lying, unknowns = held.settled()
    found = solve_by_newton(lying)
    assert found.status == "solved"
    du, exact = problem.jump(known.unknowns), 1e-13 * max(softness, 1e4)
    np.testing.assert_allclose(found.traction, known.traction, atol=exact)
    np.testing.assert_allclose(held.jump(unknowns(found.unknowns)), du, atol=exact)
    if softness < 1e4:
        alone = solve_by_newton(held)
        np.testing.assert_allclose(alone.traction, known.traction, atol=1e-9)
        np.testing.assert_allclose(held.jump(alone.unknowns), du, atol=1e-9)


@pytest.mark.parametrize("pull", [(-3.0, 1.3, 0.0), (3.0, 0.0, 0.0), (-3.0, 0.0, 3.1)])
def test_a_block_that_contact_does_not_hold_has_no_solution(pull: tuple) -> None:
    """It slides, is lifted, and turns over its edge."""
    problem = block_on_points(0.4, pull)
    assert solve_by_newton(problem).status == "limit"
    assert solve_by_lemke(problem).status != "solved"


def test_a_motion_that_nothing_sees_stays_where_it_is() -> None:
    """A smooth level base: along it nothing acts and nothing holds, and points do not see it (`ContactSystem`)."""
    problem, seen = block_on_points(0.0, (-3.0, 0.0, 0.5)), np.repeat([1.0, 0.0], 5)
    points = replace(problem.points, jump=problem.points.jump * seen[:, None], force=problem.points.force * seen)
    found = solve_by_newton(replace(problem, points=points))
    assert found.status == "solved"
    assert found.traction.sum() * 0.4 == pytest.approx(-3.0)
    assert abs(found.motion[1]) < 1e-12


@pytest.mark.parametrize(
    ("friction", "pull", "free"),
    [
        (2.0, (-1.0, 0.2, 0.4), [0.7, -0.2, 0.0, 0.3]),
        *((0.5, (0.0, 0.0, 0.0), [*gaps, 0.3, -0.1]) for gaps in ((0.7, -0.2), (-0.3, -0.3), (0.5, 0.4))),
    ],
)
def test_a_block_turns_about_a_corner_until_it_lies_on_the_other(friction: float, pull: tuple, free: list) -> None:
    """Off both its points, or on one alone, it is free to move; where nothing presses it it lies somewhere."""
    jump = np.array([[1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])  # up, along, rotation
    points = CondensedPoints(np.eye(4), jump, jump.T)
    problem = ContactProblem(points, np.array(free), np.full(2, friction), pull=np.array(pull))
    found = solve_by_newton(problem)
    assert found.status == "solved"
    assert complementarity_residual(problem, found.unknowns) < 1e-12
    assert any(pull) or np.abs(found.traction).max() < 1e-12


def test_of_many_pieces_that_contact_alone_holds_three_are_named_with_the_remedy() -> None:
    pieces = [FreePiece(k, np.arange(2), "rock", False, np.eye(3), np.array([k, 2.0]), 1.0) for k in range(13)]
    told = alone(pieces)
    assert told.startswith("contact alone holds the piece of body 'rock' round (0 m, 2 m), ")
    assert told.count("round (") == 3
    assert " and 10 more pieces, perhaps only just: they need supports, friction, or loads that press" in told
    assert "more" not in alone(pieces[:1])


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
    known, found = solve_by_newton(problem), solve_among_stuck(problem)
    assert found is not None
    assert known.status == found.status == "solved"
    assert 0 < np.sum(known.state != STICK) < 40
    np.testing.assert_array_equal(found.state, known.state)
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())
    assert complementarity_residual(problem, found.unknowns) < 1e-12


@pytest.mark.parametrize("pieces", [0, 2])
def test_a_state_leads_to_one_that_is_near_and_to_that_on_its_branches(pieces: int) -> None:
    problem = pressed_block(80, pieces, 1)
    near = solve_by_newton(replace(problem, free=1.1 * problem.free, pull=1.2 * problem.pull))
    known, found = solve_by_newton(problem), solve_among_stuck(problem, near.unknowns)
    assert found is not None
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())
    branches = active_set(problem, known.traction, problem.jump(known.unknowns))
    found = solve_among_stuck(problem, active=branches)
    assert found is not None
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())


@pytest.mark.parametrize("pieces", [0, 2])
def test_points_that_all_stick_take_one_solution(pieces: int) -> None:
    problem = replace(pressed_block(40, pieces, 0), friction=np.full(40, 5.0))
    known, found = solve_by_newton(problem), solve_among_stuck(problem)
    assert found is not None
    assert found.iterations == 0
    np.testing.assert_allclose(found.unknowns, known.unknowns, atol=1e-9 * np.abs(known.unknowns).max())


def test_where_most_points_slip_all_are_left_to_newtons_method() -> None:
    problem = pressed_block(40, 0, 0)
    assert solve_among_stuck(replace(problem, friction=np.full(40, 0.01))) is None


@pytest.mark.physics
def test_faces_that_dilate_and_have_slipped_are_left_to_newtons_method() -> None:
    """They stand open while they stick."""
    problem = pressed_block(40, 0, 0)
    assert solve_among_stuck(problem) is not None
    assert solve_among_stuck(replace(problem, dilation=np.full(40, 0.1), slipped=np.full(40, 1e-3))) is None
