"""A closed flaw, or one shorter than a cell, wherever it, its tips and the outline lie in the lattice: K is exact.

It is that of cases/compression30.yaml before growth, laid, turned and loaded as a test wants it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from crackgrow.arrays import Floats
from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import STICK
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.loop import grow
from crackgrow.run.scene import make_scene
from tests.scenes import one_size, shipped_case
from tests.solving import solve_case, whole_run
from tests.verification.slit_body import closed_plate
from tests.verification.solutions import REFERENCES

QUIET = ("output.frames=none", "output.figures=false", "growth.steps=0")
HALF_LENGTH, WIDTH, HEIGHT = 5e-3, 31e-3, 55e-3  # m
IN_CRACK_AXES = (-25.0, -75.0, 25.0 * np.sqrt(3.0))
"""MPa: stress xx, yy, xy of the scene in axes along the flaw at 30 degrees."""

Stress = tuple[float, float, float]


def case(*settings: str) -> Case:
    """The static scene in mm and MPa; later settings go before earlier ones."""
    return shipped_case("compression30", [*QUIET, *one_size("compression30"), *settings])


def K(solution: StepSolution) -> Floats:
    """K_I and K_II (tips, 2) Pa sqrt(m) by the interaction integral."""
    return np.array([(tip.intensity.K_I, tip.intensity.K_II) for tip in solution.tips])


def offset_with(case: Case, point: ArrayLike, wanted: ArrayLike, beyond: ArrayLike) -> tuple[float, float]:
    """Offset of the lattice that puts `point` (m) at fractions `wanted` of a cell, and `beyond` spacings further."""
    place = make_scene(case).lattice.to_lattice(np.asarray(point)) - np.asarray(wanted)
    x, y = place - np.rint(place) - np.asarray(beyond)
    return float(x), float(y)


def tip_of(angle: float) -> Floats:
    """The start (2,) m of the flaw at an angle (degrees)."""
    return -HALF_LENGTH * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])


def loads(stress: Stress) -> str:
    """The setting that puts tractions of a uniform stress xx, yy, xy (MPa) on all sides."""
    return f"loads=[{{far_field: {list(map(float, stress))}}}]"


@cache
def exact_K_II(
    angle: float,
    friction: float = 0.0,
    stress: Stress = (0.0, -100.0, 0.0),
    half_length: float = HALF_LENGTH,
    size: tuple[float, float] = (WIDTH, HEIGHT),
) -> float:
    """K_II (Pa sqrt(m)) of the sliding flaw in its plate under a stress in MPa, by collocation."""
    pascals = (1e6 * stress[0], 1e6 * stress[1], 1e6 * stress[2])
    return closed_plate(half_length, angle, *size, pascals, friction).K_II


SPREAD = 5e-3
"""Largest difference of K_II between positions, and from the exact value."""

ROUND_OFF = 1e-11
"""Relative residual of equilibrium: patches that cracks and outlines leave slivers of are as good as any."""


FEW = (0.0, 1e-9, -1e-9)
MANY = (0.0, *(sign * size for size in (1e-12, 3e-10, 1e-9, 5e-9, 1e-7, 1e-6, 1e-3) for sign in (-1, 1)), 0.5)
"""Spacings, from a lattice line."""

HORIZONTAL = ("cracks.flaw.path.angle=0", loads(IN_CRACK_AXES))
"""The flaw along x, and the stress turned with it."""
OUTLINE = (
    "bodies.rock.shape.rectangle={center: [0, 0], width: 30, height: 54}",
    "supports=[{at: [-15, -27], displacement: {x: 0, y: 0}}, {at: [15, -27], displacement: {y: 0}}]",
)
CORNER = np.array([-15e-3, -27e-3])  # m
AWKWARD: dict[str, tuple[tuple[str, ...], dict[str, Any], Floats, list[tuple[float, float]]]] = {
    "a tip on a node, the crack on a line, the tip on one": (
        HORIZONTAL, {"angle": 0.0, "stress": IN_CRACK_AXES}, tip_of(0.0), [(0.0, 0.0), (0.37, 0.0), (0.0, 0.41)]
    ),
    "at 45 degrees through nodes, or the middles of sides": (
        ("cracks.flaw.path.angle=45",), {"angle": 45.0}, tip_of(45.0), [(0.0, 0.0), (0.5, 0.0)]
    ),
    "a corner of the outline": (
        ("numerics.spacing=3", *OUTLINE), {"angle": 30.0, "size": (30e-3, 54e-3)}, CORNER, [(0.0, 0.0)]
    ),
}  # fmt: skip
"""Settings, what `exact_K_II` is asked for, a place (m), and where in a cell it is to lie."""


def check(solutions: list[StepSolution], expected: float) -> None:
    """K_II of all tips is exact within the spread, and equilibrium holds to round-off."""
    K_II = np.array([K(solution)[:, 1] for solution in solutions])
    np.testing.assert_allclose(K_II, expected, rtol=SPREAD)
    assert np.ptp(K_II) < SPREAD * abs(expected)
    assert max(solution.outcome.residual for solution in solutions) < ROUND_OFF


@pytest.mark.parametrize(
    ("spacing", "friction", "step"),
    [(3.0, 0.0, 22.5), (3.0, 0.3, 36.0), pytest.param(1.5, 0.3, 2.0, marks=pytest.mark.slow)],
)
def test_crack_at_all_angles(spacing: float, friction: float, step: float) -> None:
    """K_II follows the closed form wherever the lattice lies; where faces stick integration leaves 8e-6 at most."""
    random = np.random.default_rng(11)
    for angle in np.arange(0.0, 180.1, step):
        settings = (f"cracks.flaw.contact.friction={friction}", f"cracks.flaw.path.angle={angle}")
        x, y = random.uniform(-0.5, 0.5, 2)
        solution = solve_case(case(f"numerics.spacing={spacing}", *settings), (x, y))
        expected = exact_K_II(float(angle), friction)
        np.testing.assert_allclose(K(solution)[:, 1], expected, rtol=SPREAD, atol=2e-5 * exact_K_II(150.0))
        assert solution.outcome.residual < ROUND_OFF


@pytest.mark.parametrize("distances", [FEW, pytest.param(MANY, marks=pytest.mark.slow)], ids=len)
@pytest.mark.parametrize("where", AWKWARD)
def test_a_tip_or_a_corner_at_nodes_and_lines(where: str, distances: tuple[float, ...]) -> None:
    """A tip 1e-9 beyond a line, in patches that the crack neither cuts through nor opens, cost 8 % of K_II."""
    settings, exact, point, cells = AWKWARD[where]
    scene = case(*settings)
    for wanted in cells:
        places = [offset_with(scene, point, wanted, [distance, distance]) for distance in distances]
        check([solve_case(scene, place) for place in places], exact_K_II(**exact))


def warnings(scene: Case) -> str:
    """All that the first step says."""
    return "\n".join(next(grow(scene)).warnings)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(
    ("length", "spacing", "error"),
    [
        (0.006, 3.0, 0.2),
        (0.75, 3.0, 0.2),
        (1.5, 3.0, 0.08),
        (3.0, 3.0, 0.025),
        (6.0, 3.0, 0.01),
        (15.0, 3.0, 5e-3),
        pytest.param(25.0, 0.25, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_cracks_of_half_a_spacing_to_a_hundred(length: float, spacing: float, error: float, friction: float) -> None:
    """Lengths and spacings in mm; where the lattice lies decides over the error."""
    scene = case(
        f"numerics.spacing={spacing}", f"cracks.flaw.path.length={length}", f"cracks.flaw.contact.friction={friction}"
    )
    expected = exact_K_II(30.0, friction, half_length=0.5e-3 * length)
    for offset in ((0.0, 0.0), (0.3, 0.1), (-0.25, 0.45)):
        solution = solve_case(scene, offset)
        np.testing.assert_allclose(K(solution)[:, 1], expected, rtol=error)
        assert solution.outcome.residual < 1e-11


def bent(turn: float, first: float, second: float) -> str:
    """The setting of a crack with arms of two lengths (mm) and a turn (degrees) at the origin, its first arm at 30."""
    a, b = np.deg2rad(30.0), np.deg2rad(30.0 + turn)
    points = [[-first * np.cos(a), -first * np.sin(a)], [0.0, 0.0], [second * np.cos(b), second * np.sin(b)]]
    return f"cracks.flaw.path={{points: {[[float(x), float(y)] for x, y in points]}}}"


def test_no_traction_runs_away_at_a_closed_kink_close_behind_a_tip() -> None:
    """At 1e-3 spacings K_I was 100 times K_II: the short stretch had a contact point of its own."""
    for short in (0.01, 0.1, 0.5):
        scene = case(bent(-30.0, 8.0, short))
        assert np.abs(K(solve_case(scene))).max() < 1.5 * abs(exact_K_II(30.0, half_length=4e-3))


@pytest.mark.parametrize("friction", [0.0, pytest.param(0.3, marks=pytest.mark.slow)])
def test_a_thousand_segments_are_one(friction: float) -> None:
    """Of 0.015 spacings; the disc of the integral is smaller, since it doesn't know that the crack is straight."""
    ends = 7.5 * np.array([np.cos(np.pi / 6.0), 0.5])
    points = (np.linspace(-1.0, 1.0, 1001)[:, None] * ends).tolist()
    settings = (f"cracks.flaw.contact.friction={friction}", "numerics.spacing=1.5")
    many = solve_case(case(*settings, f"cracks.flaw.path={{points: {points}}}"))
    np.testing.assert_allclose(K(many)[:, 1], exact_K_II(30.0, friction, half_length=7.5e-3), rtol=1e-3)
    one = solve_case(case(*settings, "cracks.flaw.path.length=15"))
    np.testing.assert_allclose(many.outcome.points.normal, one.outcome.points.normal, rtol=1e-4)


def test_repeated_vertices_and_segments_of_no_length_are_left_out_and_told() -> None:
    """Vertices within 1e-3 spacings (0.003 mm) are one; the ends of the crack stay where they are."""
    clean = "cracks.flaw.path={points: [[-4, -2], [0, 0.5], [4, 2]]}"
    dirty = "cracks.flaw.path={points: [[-4, -2], [-4, -2], [0, 0.5], [0.001, 0.5], [3.999, 2], [4, 2]]}"
    scene = case("numerics.spacing=3", dirty)
    np.testing.assert_array_equal(K(solve_case(scene)), K(solve_case(case("numerics.spacing=3", clean))))
    assert "crack 'flaw': 3 of its vertices repeat the one before them" in warnings(scene)
    assert "repeat" not in warnings(case("numerics.spacing=3", clean))


def stuck(spacing: float) -> Case:
    """A flaw that sticks everywhere under a pressure that varies along it: K_I = K_II = 0."""
    return load_case(REFERENCES / "stuck_flaw.yaml", [f"numerics.spacing={spacing}"])


def test_a_flaw_that_sticks_everywhere_does_not_grow_and_its_K_falls_with_the_spacing() -> None:
    """Contact holds on average along the faces: what is left of K is zero in the limit."""
    results, end = whole_run(stuck(3.0))
    assert (end.status, len(results)) == ("arrested", 1)
    assert (results[0].contact.state == STICK).all()
    found = [float(np.hypot(*K(solve_case(stuck(spacing))).T).max()) for spacing in (3.0, 1.5, 1.0)]
    assert found[1] < 0.7 * found[0]
    assert found[2] < 0.7 * found[1]
    assert found[2] < 0.005 * 97e6 * np.sqrt(np.pi * 7.5e-3)  # of the open crack under the mean pressure
