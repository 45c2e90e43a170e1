"""Joints that are elastic (Goodman, Taylor, Brekke 1968), close by a hyperbola (Bandis), or bear tension: closed forms.

A block on a joint under a pressure p and a shear q closes by p / k_n, or by p / (k + p / v_m), and slips by q / k_s.
Rough joints slide at p tan(phi + JRC log10(JCS / p)) (Barton). Nothing depends on the lattice.
"""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.coulomb import SLIP, ContactLaw
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.verification.solutions import case_of, solved
from tests.verification.stiff_block import sheared
from tests.whole_run import seen, whole_run

YOUNG = 1e10  # Pa; Poisson's ratio is zero: shear modulus E/2
NORMAL, SHEAR = 2e10, 5e9  # Pa/m
PRESSURE, STRESS = 3e6, 1e6  # Pa

TWO_BLOCKS = """
title: two blocks and a joint
plane: stress
units: {stress: MPa}
bodies:
  low: {shape: {rectangle: {center: [0, -0.05], width: 0.1, height: 0.1}}, material: {young: 1e4, poisson: 0}}
  top: {shape: {rectangle: {center: [0, 0.05], width: 0.1, height: 0.1}}, material: {young: 1e4, poisson: 0}}
interfaces:
  - {between: [top, low], contact: {friction: 0.6, cohesion: 0, stiffness: {normal: 20 GPa/m, shear: 5000}}}
supports: [{on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}]
loads:
  - {on: {body: top, edge: top}, traction: [1, -3]}
  - {on: {body: top, edge: left}, traction: [0, -1]}
  - {on: {body: top, edge: right}, traction: [0, 1]}
  - {on: {body: low, edge: left}, traction: [0, -1]}
  - {on: {body: low, edge: right}, traction: [0, 1]}
output: {points: {joint: {interface: [top, low], at: [0.02, 0]}}}
"""

FOUNDATION = """
title: a block on an elastic foundation
plane: stress
units: {stress: MPa}
bodies:
  top: {shape: {rectangle: {center: [0, 0.05], width: 0.1, height: 0.1}}, material: {young: 10000, poisson: 0}}
supports:
  - {on: {body: top, edge: bottom}, contact: {friction: 0.6, cohesion: 0, stiffness: {normal: 20000, shear: 5000}}}
loads:
  - {on: {body: top, edge: top}, traction: [1, -3]}
  - {on: {body: top, edge: left}, traction: [0, -1]}
  - {on: {body: top, edge: right}, traction: [0, 1]}
numerics: {spacing: 0.013}
output: {points: {top: {at: [0.03, 0.1]}}}
"""


def last(result: StepResult, column: str) -> float:
    """A column of history.csv at the end of a step."""
    return float(seen([result], column)[-1])


@pytest.mark.parametrize("spacing", [0.05, 0.02, 0.013])
def test_a_joint_between_blocks_closes_and_slips_by_its_stiffness(spacing: float) -> None:
    (result,) = whole_run(case_of(TWO_BLOCKS, f"numerics.spacing={spacing}"))[0]
    assert last(result, "joint.opening") == pytest.approx(-PRESSURE / NORMAL, rel=1e-8)
    assert abs(last(result, "joint.slip")) == pytest.approx(STRESS / SHEAR, rel=1e-8)
    np.testing.assert_allclose(result.contact.normal_traction, -PRESSURE, rtol=1e-7)
    np.testing.assert_allclose(np.abs(result.contact.tangential_traction), STRESS, rtol=1e-7)
    strain_energy = 0.1 * (PRESSURE**2 / NORMAL + STRESS**2 / SHEAR) / 2.0
    strain_energy += 0.02 * (PRESSURE**2 + 2.0 * STRESS**2) / (2.0 * YOUNG)
    assert result.energy.strain == pytest.approx(strain_energy, rel=1e-8)
    assert result.energy.error < 1e-9


def test_a_block_on_a_foundation_with_a_stiffness() -> None:
    (result,) = whole_run(case_of(FOUNDATION))[0]
    assert last(result, "top.u_y") == pytest.approx(-PRESSURE / NORMAL - 0.1 * PRESSURE / YOUNG, rel=1e-8)
    assert last(result, "top.u_x") == pytest.approx(STRESS / SHEAR + 0.1 * STRESS / (0.5 * YOUNG), rel=1e-8)


def test_slip_beyond_friction_is_not_elastic() -> None:
    """Sheared by d and back to none, a joint that has slipped by s = d - mu p / k_s is sheared by k_s s the other way.

    The block turns a little, by its height times which its base slips less than its top: 0.2 % of the slip, each way.
    """
    law = "friction: 0.6, cohesion: 0, stiffness: {normal: 2e10, shear: 5e9}"
    there, back = (
        last(result, "supports.1.force_x") / 0.1
        for result in sheared(law, "x: 0.0006", "loading={history: [1, 0]}", pressure=PRESSURE)
    )
    assert there == pytest.approx(0.6 * PRESSURE, rel=1e-4)
    assert back == pytest.approx(-(SHEAR * 0.0006 - 0.6 * PRESSURE), rel=5e-3)


def test_stiffness_of_a_crack_is_that_of_the_numerics_where_it_is_the_same() -> None:
    """kappa E / h, given in one way or the other."""
    given = [f"cracks.flaw.contact.stiffness.{way}={100.0 * 10000.0}" for way in ("normal", "shear")]  # MPa/mm
    one, other = (
        solved("compression30", "numerics.spacing=1", *more).result
        for more in (["numerics.contact.stiffness=100"], given)
    )
    for tip, like in zip(one.tips, other.tips, strict=True):
        assert pytest.approx((like.K_I, like.K_II), rel=1e-9) == (tip.K_I, tip.K_II)
    np.testing.assert_allclose(one.contact.normal_traction, other.contact.normal_traction, rtol=1e-9)


# Bandis and Barton.

BANDIS_WIDTH, STIFFNESS, CLOSURE = 0.4, 20e9, 2e-4  # m, Pa/m, m


def stored(pressure: float) -> float:
    """J/m^2: the integral of p dv."""
    k = STIFFNESS * CLOSURE
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    return pressure * closure - CLOSURE * (pressure - k * np.log1p(pressure / k))


@pytest.mark.parametrize("follow", ["events", 5])
def test_closure_is_a_hyperbola_there_and_back(follow: str | int) -> None:
    pressed = ["loads.0.held=false", "supports.1.displacement.x=0", "loads.0.traction=[0, -20]"]
    loading = f"loading={{history: [0.1, 0.5, 1, 0.3], follow: {follow}}}"
    results = whole_run(shipped_case("barton_bandis", [*pressed, loading]))[0]
    rise, pressure = seen(results, "joint.u_y"), np.abs(seen(results, "top.bottom.force_y")) / BANDIS_WIDTH
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    assert len(pressure) >= 20
    assert closure.max() > 0.8 * CLOSURE
    np.testing.assert_allclose(-rise, closure, rtol=1e-3)
    energy = results[-1].energy
    assert energy.strain == pytest.approx(BANDIS_WIDTH * stored(0.3 * 20e6), rel=1e-3)
    assert energy.dissipated == 0.0
    assert follow != "events" or energy.error < 1e-6


@pytest.mark.parametrize("pressure", [0.5, 5, 50])
def test_shear_strength_is_that_of_the_pressure(pressure: float) -> None:
    settings = [f"loads.0.traction=[0, {-pressure}]", "supports.1.displacement.x=20", "loading.follow=events"]
    (result,) = whole_run(shipped_case("barton_bandis", settings))[0]
    strength = 1e6 * pressure * np.tan(np.deg2rad(30.0 + 10.0 * np.log10(100.0 / pressure)))
    assert last(result, "supports.1.force_x") == pytest.approx(BANDIS_WIDTH * strength, rel=1e-3)
    assert result.energy.error < 1e-6


@pytest.mark.parametrize(("jrc", "jcs"), [(10, 50), (5, 100)])
def test_under_loads_that_press_and_shear_at_once_faces_slip_at_their_strength(jrc: float, jcs: float) -> None:
    """Near no pressure friction bends so much that events were looked for in vain, and faces stuck beyond it."""
    law = f"cracks.flaw.contact={{friction: 0.2, cohesion: 0, barton: {{jrc: {jrc}, jcs: {jcs}}}}}"
    settings = [law, "numerics.spacing=1", "growth.steps=0", "loading={history: [1]}", "output.frames=none"]
    *_, (_, solution) = solved_steps(shipped_case("compression30", settings))
    points = solution.state.outcome.points
    friction, _ = solution.configuration.contact.law.bound_of(points.trial.lost, points.normal)
    assert (points.state == SLIP).all()
    np.testing.assert_allclose(np.abs(points.tangential), -friction * points.normal, rtol=1e-6)


def law_of(n: int) -> ContactLaw:
    """The law of n points."""
    one, none, rows = np.ones(n), np.zeros(n), np.zeros((2, n))
    shares, friction, soft = np.array([none, one]), np.full((2, n), np.tan(np.deg2rad(30.0))), one / STIFFNESS
    wall = (CLOSURE * one, np.deg2rad(10.0) * one, 100e6 * one)
    return ContactLaw(soft, soft, none, none > 0.0, shares, friction, rows, rows, rows, *wall)


def test_faces_are_no_steeper_than_70_degrees_and_no_flatter_than_flat() -> None:
    found = law_of(3).bound_of(np.zeros(3), -np.array([1.0, 10e6, 1e9]))[0]
    np.testing.assert_allclose(np.rad2deg(np.arctan(found)), [70.0, 40.0, 30.0], rtol=1e-12)


# Tension.


def test_a_vein_opens_at_its_tensile_strength_and_then_has_none() -> None:
    """Pulled by half of 40 micrometres, then by all, then pressed: it has the stress of rock before, and pressed."""
    area, length, elastic = 0.05, 0.1, 0.5 * 4e-5 / 0.1 * YOUNG * 0.05  # m, m, N/m
    peak = 2e6 / np.cos(np.deg2rad(20.0)) ** 2  # Pa, of axial stress
    before, broken, pressed = whole_run(shipped_case("vein_in_tension"))[0]
    assert last(before, "supports.1.force_y") == pytest.approx(elastic, rel=1e-9)
    force = seen([broken], "supports.1.force_y")
    assert force.max() == pytest.approx(peak * area, rel=1e-3)
    assert abs(force[-1]) < 1e-9 * peak * area
    assert broken.energy.released == pytest.approx(0.5 * peak**2 / YOUNG * area * length, rel=1e-3)
    assert max(result.energy.error for result in (before, broken, pressed)) < 1e-8
    assert last(pressed, "supports.1.force_y") == pytest.approx(-elastic, rel=1e-9)
    again = whole_run(shipped_case("vein_in_tension", ["loading.history=[1, -0.5, 0.4]"]))[0][-1]
    assert abs(last(again, "supports.1.force_y")) < 1e-9 * peak * area


def test_points_open_one_after_the_other() -> None:
    """A block that is lifted at one edge opens its joint to where p = k g is the strength; the rest holds as before."""
    law = "friction: 0.8, cohesion: 5e6, tension: 1e6, stiffness: {normal: 1e12, shear: 1e12}"
    settings = ("numerics.contact={}", "loading={history: [1]}")
    (result,) = sheared(law, 'y: "2e-6*(0.5+x/0.1)"', *settings, pressure=0.0)
    assert result.energy.released == pytest.approx(0.5 * 1e6**2 / 1e12 * 0.1 * 0.5, rel=0.03)
    assert last(result, "supports.1.force_y") == pytest.approx(0.5 * 1e6 * 0.05, rel=0.06)
    assert result.energy.error < 1e-8
