"""Joints that close by a hyperbola (Bandis) and slide at a friction that falls with pressure (Barton), in closed form.

A stiff block on a joint moves as one: it closes by v = p / (k + p / v_m), slides at p tan(phi + JRC log10(JCS / p)).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import SLIP, ContactLaw
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from tests.whole_run import seen, whole_run

JOINT = Path(__file__).parents[2] / "cases" / "barton_bandis.yaml"
FLAW = JOINT.with_name("compression30.yaml")
WIDTH, STIFFNESS, CLOSURE = 0.4, 20e9, 2e-4  # m, Pa/m, m
PRESSED = ("loads.0.held=false", "supports.1.displacement.x=0", "loads.0.traction=[0, -20]")


def steps(*overrides: str) -> list[StepResult]:
    return whole_run(load_case(JOINT, overrides))[0]


def strength(pressure: float) -> float:
    return pressure * np.tan(np.deg2rad(30.0 + 10.0 * np.log10(100e6 / pressure)))


def stored(pressure: float) -> float:
    """J/m^2: the integral of p dv."""
    k = STIFFNESS * CLOSURE
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    return pressure * closure - CLOSURE * (pressure - k * np.log1p(pressure / k))


@pytest.mark.parametrize("follow", ["events", 5])
def test_closure_is_a_hyperbola_there_and_back(follow: str | int) -> None:
    results = steps(*PRESSED, f"loading={{history: [0.1, 0.5, 1, 0.3], follow: {follow}}}")
    rise, pressure = seen(results, "joint.u_y"), np.abs(seen(results, "top.bottom.force_y")) / WIDTH
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    assert len(pressure) >= 20
    assert closure.max() > 0.8 * CLOSURE
    np.testing.assert_allclose(-rise, closure, rtol=1e-3)
    last = results[-1].energy
    assert last.strain == pytest.approx(WIDTH * stored(0.3 * 20e6), rel=1e-3)
    assert last.dissipated == 0.0
    assert follow != "events" or last.error < 1e-6


@pytest.mark.parametrize("pressure", [0.5, 5, 50])
def test_shear_strength_is_that_of_the_pressure(pressure: float) -> None:
    (result,) = steps(f"loads.0.traction=[0, {-pressure}]", "supports.1.displacement.x=20", "loading.follow=events")
    force = seen([result], "supports.1.force_x")[-1]
    assert force == pytest.approx(WIDTH * strength(1e6 * pressure), rel=1e-3)
    assert result.energy.error < 1e-6


@pytest.mark.parametrize(("jrc", "jcs"), [(10, 50), (5, 100)])
@pytest.mark.parametrize("loading", ["{history: [1]}"])
def test_under_loads_that_press_and_shear_at_once_faces_slip_at_their_strength(
    jrc: float, jcs: float, loading: str
) -> None:
    """Near no pressure friction bends so much that events were looked for in vain, and faces stuck beyond it."""
    law = f"cracks.flaw.contact={{friction: 0.2, cohesion: 0, barton: {{jrc: {jrc}, jcs: {jcs}}}}}"
    case = load_case(FLAW, [law, "numerics.spacing=1", "growth.steps=0", f"loading={loading}", "output.frames=none"])
    *_, (_, solution) = solved_steps(case)
    points = solution.state.outcome.points
    friction, _ = solution.configuration.contact.law.bound_of(points.trial.lost, points.normal)
    assert (points.state == SLIP).all()
    np.testing.assert_allclose(np.abs(points.tangential), -friction * points.normal, rtol=1e-6)


def test_faces_are_no_steeper_than_70_degrees_and_no_flatter_than_flat() -> None:
    law, none = law_of(np.array([1.0, 10e6, 1e9])), np.zeros(3)
    found = law.bound_of(none, -np.array([1.0, 10e6, 1e9]))[0]
    np.testing.assert_allclose(np.rad2deg(np.arctan(found)), [70.0, 40.0, 30.0], rtol=1e-12)


def law_of(pressure: np.ndarray) -> ContactLaw:
    n = len(pressure)
    one, none, rows = np.ones(n), np.zeros(n), np.zeros((2, n))
    shares, friction = np.array([none, one]), np.full((2, n), np.tan(np.deg2rad(30.0)))
    soft = one / STIFFNESS
    rough = np.deg2rad(10.0) * one
    return ContactLaw(
        soft, soft, none, none > 0.0, shares, friction, rows, rows, rows, CLOSURE * one, rough, 100e6 * one
    )


def test_softness_and_energy_are_derivative_and_integral_of_closure() -> None:
    """By differences, under pressure and tension."""
    normal = np.array([2e6, -1e4, -3e6, -5e7])
    law, step = law_of(normal), 1e-5 * np.abs(normal)
    slope = (law.closure(normal - step) - law.closure(normal + step)) / (2.0 * step)
    np.testing.assert_allclose(law.softness(normal) * law.compliance, slope, rtol=1e-8)
    energy = [law.stored(some) - 0.5 * some * law.closure(some) for some in (normal - step, normal + step)]
    np.testing.assert_allclose((energy[0] - energy[1]) / (2.0 * step), -normal * slope, rtol=1e-4)
