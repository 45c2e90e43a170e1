"""Where the lattice lies under a scene, and how a scene lies in the plane, must not matter."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.run.judging import StepSolution
from tests.stability.condition import condition_estimate
from tests.stability.flaw import IN_CRACK_AXES, K, case, exact_K_II, loads, offset_with, solve, tip_of

SPREAD = 5e-3
"""Largest difference of K_II between positions, and from the exact value."""

FACTOR = 100.0
"""Largest ratio of condition numbers between positions."""

HORIZONTAL = ("cracks.flaw.path.angle=0", loads(IN_CRACK_AXES))
"""The flaw along x, and the stress turned with it."""


MANY = (0.0, *(sign * size for size in (1e-12, 3e-10, 1e-9, 5e-9, 1e-7, 1e-6, 1e-3) for sign in (-1, 1)))
"""Spacings, from a lattice line."""


def check(solutions: list[StepSolution], expected: float) -> None:
    """K_II of all tips is exact within the spread, and condition numbers are within their factor."""
    K_II = np.array([K(solution)[:, 1] for solution in solutions])
    np.testing.assert_allclose(K_II, expected, rtol=SPREAD)
    assert np.ptp(K_II) < SPREAD * abs(expected)
    conditions = [condition_estimate(solution.contact.system) for solution in solutions]
    assert max(conditions) < FACTOR * min(conditions)


@pytest.mark.parametrize(
    ("spacing", "friction", "n"),
    [
        (3.0, 0.0, 6),
        (3.0, 0.3, 6),
        pytest.param(1.5, 0.0, 200, marks=pytest.mark.slow),
        pytest.param(1.5, 0.3, 200, marks=pytest.mark.slow),
    ],
)
def test_lattice_at_random_positions(spacing: float, friction: float, n: int) -> None:
    scene = case(f"numerics.spacing={spacing}", f"cracks.flaw.contact.friction={friction}")
    offsets = np.random.default_rng(11).uniform(-0.5, 0.5, (n, 2))
    check([solve(scene, (x, y)) for x, y in offsets], exact_K_II(30.0, friction))


@pytest.mark.parametrize(
    ("spacing", "friction", "step"),
    [
        (3.0, 0.0, 22.5),
        (3.0, 0.3, 36.0),
        pytest.param(1.5, 0.0, 2.0, marks=pytest.mark.slow),
        pytest.param(1.5, 0.3, 2.0, marks=pytest.mark.slow),
    ],
)
def test_crack_at_all_angles(spacing: float, friction: float, step: float) -> None:
    """K_II follows the closed form: per angle within the spread, and where there is none by that of the largest."""
    conditions = []
    for angle in np.arange(0.0, 180.1, step):
        settings = (f"cracks.flaw.contact.friction={friction}", f"cracks.flaw.path.angle={angle}")
        solution = solve(case(f"numerics.spacing={spacing}", *settings))
        expected = exact_K_II(float(angle), friction)
        np.testing.assert_allclose(K(solution)[:, 1], expected, rtol=SPREAD, atol=1e-6 * exact_K_II(150.0))
        conditions.append(condition_estimate(solution.contact.system))
    assert max(conditions) < FACTOR * min(conditions)


@pytest.mark.parametrize(
    ("distances", "beyond"),
    [
        ((0.0, 1e-9, -1e-9), (1.0, 1.0)),
        pytest.param(MANY, (0.0, 1.0), marks=pytest.mark.slow),
        pytest.param(MANY, (1.0, 1.0), marks=pytest.mark.slow),
    ],
    ids=["few", "beside", "beside and beyond"],
)
@pytest.mark.parametrize("wanted", [(0.0, 0.0), (0.37, 0.0), (0.0, 0.41)], ids=["tip on node", "line", "tip on line"])
def test_crack_along_a_lattice_line(
    distances: tuple[float, ...], beyond: tuple[float, float], wanted: tuple[float, float]
) -> None:
    """With support 2 lattice lines are the edges of patches too. A tip 1e-9 beyond one, in patches that the crack
    neither cuts through nor opens, cost 8 % of K_II."""
    scene = case(*HORIZONTAL)
    places = [offset_with(scene, tip_of(0.0), wanted, np.array(beyond) * distance) for distance in distances]
    check([solve(scene, place) for place in places], exact_K_II(0.0, stress=IN_CRACK_AXES))


@pytest.mark.parametrize("wanted", [(0.0, 0.0), (0.5, 0.0)])
@pytest.mark.parametrize(
    ("angle", "distances"),
    [
        (45.0, (0.0, 1e-9)),
        pytest.param(30.0, (0.0, 1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3), marks=pytest.mark.slow),
        pytest.param(45.0, (0.0, 1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3), marks=pytest.mark.slow),
    ],
)
def test_slanted_crack_with_its_tip_at_nodes_and_lines(
    angle: float, distances: tuple[float, ...], wanted: tuple[float, float]
) -> None:
    """At 45 degrees it leads through nodes, or through the middles of the sides of cells."""
    scene = case(f"cracks.flaw.path.angle={angle}")
    places = [offset_with(scene, tip_of(angle), wanted, (distance, distance)) for distance in distances]
    check([solve(scene, place) for place in places], exact_K_II(angle))


@pytest.mark.parametrize("spacing", [3.0, pytest.param(1.5, marks=pytest.mark.slow)])
def test_outline_on_lattice_lines(spacing: float) -> None:
    supports = "[{at: [-15, -27], displacement: {x: 0, y: 0}}, {at: [15, -27], displacement: {y: 0}}]"
    size = ("bodies.rock.shape.rectangle.width=30", "bodies.rock.shape.rectangle.height=54", f"supports={supports}")
    scene = case(f"numerics.spacing={spacing}", *size)
    corner = np.array([-15e-3, -27e-3])
    distances = (0.0, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, 1e-3, 0.5)
    places = [offset_with(scene, corner, (0.0, 0.0), (distance, distance)) for distance in distances]
    check([solve(scene, place) for place in places], exact_K_II(30.0, width=30e-3, height=54e-3))
