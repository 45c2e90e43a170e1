"""Tractions between contact points where the elastic law holds, and short waves of tractions."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.contact.ripple import ripple, worst_ripple
from crackgrow.contact.tractions import elastic_tractions
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import from_state, increment, unloaded
from tests.scenes import shipped_case
from tests.solving import solve_case
from tests.unit.run.test_run_held import inside, on_plane, plate

KEPT = {"cohesion": 10, "cohesion_after_slip": "kept"}
LAWS = [
    ({"cohesion": 0}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0,), SLIP),
    ({"cohesion": 0, "dilation_angle": 10}, (1.0, 0.9), STICK),
    (KEPT, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0,), SLIP),
    ({**KEPT, "dilation_angle": 5}, (1.0, 0.9), STICK),
    ({"cohesion": 40}, (1.0,), STICK),
]


def solved(
    discretization: str, pressure: float, factors: tuple[float, ...], angle: float = 30.0, **law: object
) -> StepSolution:
    """A crack under shear of 30 MPa, with elastic contact, at the last of some load factors."""
    contact = f"numerics.contact={{stiffness: 100, discretization: {discretization}}}"
    scene = plate(inside(angle), on_plane(angle, pressure, 30.0), "numerics.spacing=2", contact, **law)
    start = unloaded(scene)
    for factor in factors:
        state = increment(scene, start, factor)
        start = from_state(state)
    return evaluated(state)


@pytest.mark.physics
@pytest.mark.parametrize(("law", "factors", "state"), LAWS)
def test_at_the_contact_points_they_are_those_of_the_contact_points(law: dict, factors: tuple, state: int) -> None:
    """Dilation is no overlap, and the part of the shear that cohesion carries is none of friction's."""
    solution = solved("gauss", 20.0, factors, **law)
    outcome, faces = solution.outcome, solution.faces
    assert set(outcome.points.state.tolist()) == {state}
    normal, tangential = elastic_tractions(solution.cover, faces, 0, faces.s, solution.contact.law, outcome)
    np.testing.assert_allclose(normal, outcome.points.normal, rtol=1e-6)
    np.testing.assert_allclose(tangential, outcome.points.tangential, rtol=1e-6)


@pytest.mark.physics
def test_shear_on_a_bond_does_not_ask_for_the_pressure() -> None:
    """All sticks: K_II is that of the shear, also where the pressure is round-off."""
    K_II = [[tip.K[1] for tip in solved("gauss", p, (1.0,), angle=0.0, cohesion=40).tips] for p in (0.0, 1.0, 20.0)]
    np.testing.assert_allclose(K_II, np.tile(K_II[2], (3, 1)), rtol=1e-3)
    assert min(np.abs(K_II[2])) > 1e5


S = np.linspace(0.0, 6.0, 61)
"""Ten points a cell."""


@pytest.mark.parametrize("length", [0.3, 0.5, 1.0, 1.6])
@pytest.mark.parametrize("amplitude", [0.1, 2.0])
def test_a_short_wave_is_measured_whatever_it_rides_on(length: float, amplitude: float) -> None:
    s = np.linspace(0.0, 6.0, 601)
    for smooth in (np.zeros(601), np.full(601, -75.0), -75.0 + 0.002 * s**2):
        swing = ripple(s, smooth + amplitude * np.sin(2.0 * np.pi * s / length))
        assert swing == pytest.approx(2.0 * amplitude, rel=0.1)


def test_what_rock_does_and_waves_that_the_lattice_carries_are_none() -> None:
    for length in (2.5, 4.0, 12.0):
        assert ripple(S, np.sin(2.0 * np.pi * S / length)) == 0.0
    root = np.sqrt(S * (6.0 - S))
    step = np.where(S < 3.0, -75.0, -20.0)
    peak = -75.0 - 500.0 * np.eye(61)[30]
    for smooth in (-75.0 * np.ones(61), -75.0 + S, root, -1.0 / (S + 0.01), step, peak, -np.abs(S - 2.0)):
        assert ripple(S, smooth) == 0.0


def test_of_two_waves_the_larger_counts_and_few_points_have_none() -> None:
    p = np.zeros(61)
    p[40:44] = [1.0, -1.0, 1.0, -1.0]
    p[10:14] = [0.2, -0.2, 0.2, -0.2]
    assert ripple(S, p) == 2.0
    assert [ripple(S[:n], p[40 : 40 + n]) for n in range(5)] == [0.0, 0.0, 0.0, 0.0, 2.0]


def test_the_ripple_of_a_surface_is_held_against_its_own_pressure() -> None:
    settings = ("numerics.contact={discretization: gauss, stiffness: 1}", "numerics.spacing=3", "growth.steps=0")
    solution = solve_case(shipped_case("compression30", settings))
    cover, faces, none = solution.cover, solution.faces, np.zeros(solution.faces.n)
    calm = none - 75e6
    wave = calm + 15e6 * (-1.0) ** np.arange(faces.n)
    for normal, tangential in ((wave, none), (1e-9 * wave, none), (calm, wave)):
        assert worst_ripple(cover, faces, normal, tangential).part == pytest.approx(30.0 / 75.0, rel=0.01)
    assert worst_ripple(cover, faces, none, none) is None
