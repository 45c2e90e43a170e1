"""Cracks and distances of a spacing or less, in cells by hand: K is as good as they let it be."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.model import Case
from crackgrow.run import grow
from tests.solving import solve_case
from tests.stability.flaw import K, case, exact_K_II


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
