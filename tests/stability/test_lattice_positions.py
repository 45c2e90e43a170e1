"""Where the lattice lies under a scene, and how a scene lies in the plane, must not matter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crackgrow.run.evaluation import StepSolution
from tests.solving import solve_case
from tests.stability.flaw import IN_CRACK_AXES, K, case, exact_K_II, loads, offset_with, tip_of

SPREAD = 5e-3
"""Largest difference of K_II between positions, and from the exact value."""

ROUND_OFF = 1e-11
"""Relative residual of equilibrium: patches that cracks and outlines leave slivers of are as good as any."""

Exact = dict[str, Any]
"""What `exact_K_II` is asked for."""

SLOW = pytest.mark.slow
FEW = (0.0, 1e-9, -1e-9)
MANY = (0.0, *(sign * size for size in (1e-12, 3e-10, 1e-9, 5e-9, 1e-7, 1e-6, 1e-3) for sign in (-1, 1)))
"""Spacings, from a lattice line."""

HORIZONTAL = ("cracks.flaw.path.angle=0", loads(IN_CRACK_AXES))
"""The flaw along x, and the stress turned with it."""
OUTLINE = (
    "bodies.rock.shape.rectangle={center: [0, 0], width: 30, height: 54}",
    "supports=[{at: [-15, -27], displacement: {x: 0, y: 0}}, {at: [15, -27], displacement: {y: 0}}]",
)
CORNER = (-15e-3, -27e-3)  # m
ALONG_X: Exact = {"angle": 0.0, "stress": IN_CRACK_AXES}
OF_OUTLINE: Exact = {"angle": 30.0, "size": (30e-3, 54e-3)}


def check(solutions: list[StepSolution], expected: float) -> None:
    """K_II of all tips is exact within the spread, and equilibrium holds to round-off."""
    K_II = np.array([K(solution)[:, 1] for solution in solutions])
    np.testing.assert_allclose(K_II, expected, rtol=SPREAD)
    assert np.ptp(K_II) < SPREAD * abs(expected)
    assert max(solution.outcome.residual for solution in solutions) < ROUND_OFF


@pytest.mark.parametrize(("spacing", "n"), [(3.0, 6), pytest.param(1.5, 200, marks=SLOW)])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_lattice_at_random_positions(spacing: float, friction: float, n: int) -> None:
    scene = case(f"numerics.spacing={spacing}", f"cracks.flaw.contact.friction={friction}")
    offsets = np.random.default_rng(11).uniform(-0.5, 0.5, (n, 2))
    check([solve_case(scene, (x, y)) for x, y in offsets], exact_K_II(30.0, friction))


@pytest.mark.parametrize(
    ("spacing", "friction", "step"),
    [
        (3.0, 0.0, 22.5),
        (3.0, 0.3, 36.0),
        pytest.param(1.5, 0.0, 2.0, marks=SLOW),
        pytest.param(1.5, 0.3, 2.0, marks=SLOW),
    ],
)
def test_crack_at_all_angles(spacing: float, friction: float, step: float) -> None:
    """K_II follows the closed form: per angle within the spread, and where there is none by that of the largest."""
    for angle in np.arange(0.0, 180.1, step):
        settings = (f"cracks.flaw.contact.friction={friction}", f"cracks.flaw.path.angle={angle}")
        solution = solve_case(case(f"numerics.spacing={spacing}", *settings))
        expected = exact_K_II(float(angle), friction)
        np.testing.assert_allclose(K(solution)[:, 1], expected, rtol=SPREAD, atol=1e-6 * exact_K_II(150.0))
        assert solution.outcome.residual < ROUND_OFF


@pytest.mark.parametrize(
    ("settings", "exact", "point", "wanted", "direction", "distances"),
    [
        *(
            pytest.param(HORIZONTAL, ALONG_X, tip_of(0.0), wanted, direction, distances, marks=marks)
            for wanted in ((0.0, 0.0), (0.37, 0.0), (0.0, 0.41))  # the tip on a node, the crack on a line, the tip
            for direction, distances, marks in (((1, 1), FEW, ()), ((0, 1), MANY, SLOW), ((1, 1), MANY, SLOW))
        ),
        *(
            pytest.param(
                *((f"cracks.flaw.path.angle={angle}",), {"angle": angle}, tip_of(angle), wanted, (1, 1), distances),
                marks=marks,
            )
            for wanted in ((0.0, 0.0), (0.5, 0.0))  # at 45 degrees through nodes, or through the middles of sides
            for angle, distances, marks in ((45.0, FEW[:2], ()), (30.0, MANY, SLOW), (45.0, MANY, SLOW))
        ),
        (("numerics.spacing=3", *OUTLINE), OF_OUTLINE, CORNER, (0.0, 0.0), (1, 1), (*MANY[:7], 0.5)),
        pytest.param(OUTLINE, OF_OUTLINE, CORNER, (0.0, 0.0), (1, 1), (*MANY, 0.5), marks=SLOW),
    ],
)
def test_a_tip_or_a_corner_at_nodes_and_lines(
    settings: tuple[str, ...],
    exact: Exact,
    point: np.ndarray,
    wanted: tuple[float, float],
    direction: tuple[float, float],
    distances: tuple[float, ...],
) -> None:
    """With support 2 lattice lines are the edges of patches too. A tip 1e-9 beyond one, in patches that the crack
    neither cuts through nor opens, cost 8 % of K_II."""
    scene = case(*settings)
    places = [offset_with(scene, point, wanted, np.array(direction) * distance) for distance in distances]
    check([solve_case(scene, place) for place in places], exact_K_II(**exact))
