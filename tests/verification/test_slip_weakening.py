"""Friction and cohesion that fall linearly over a length of slip (Ida 1972), in direct shear.

A stiff block on a joint of shear stiffness k moves as one: under a displacement d the shear of each of its points
rises to b_0 = c + mu p, falls by (b_0 - b_r) s / D with the slip s = d - shear / k, and stays at b_r = mu_r p. It is
pulled at its top, a height h above the joint: the pressure p is P + 12 h F x / w^3 along a joint of width w, force F.
"""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.run.result import History
from tests.whole_run import steps_of

PRESSURE, SHEAR, WEAKENING, WIDTH, HEIGHT = 2e6, 1e10, 2e-3, 0.1, 0.002  # Pa, Pa/m, m, m, m
PEAK, RESIDUAL = 0.8 * PRESSURE + 5e5, 0.6 * PRESSURE  # Pa

STIFF = """
title: a flat, stiff block, sheared
plane: stress
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e14, poisson: 0}}
supports:
  - on: {body: top, edge: bottom}
    contact: {friction: 0.8, residual_friction: 0.6, cohesion: 5e5, weakening_length: 0.002,
              stiffness: {normal: 1e12, shear: 1e10}}
  - {on: {body: top, edge: top}, displacement: {x: 0.003}}
loads: [{on: {body: top, edge: top}, traction: [0, -2e6], held: true}]
loading: {history: [0.4, 1]}
numerics: {spacing: 0.001, contact: {spacing: 4}}
output: {frames: none, figures: false, points: {middle: {at: [0, 0.002]}}}
"""

DIRECT_SHEAR = """
title: two blocks in direct shear
plane: strain
units: {length: mm, stress: MPa}
bodies:
  low: {shape: {rectangle: {center: [0, -25], width: 200, height: 50}}, material: {young: 10000, poisson: 0.2}}
  top: {shape: {rectangle: {center: [0, 25], width: 200, height: 50}}, material: {young: 10000, poisson: 0.2}}
interfaces:
  - between: [top, low]
    contact: {friction: 0.8, residual_friction: 0.6, cohesion: 0.5, weakening_length: 0.5}
supports:
  - {on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}
  - {on: {body: top, edge: top}, displacement: {x: 1}}
loads: [{on: {body: top, edge: top}, traction: [0, -2], held: true}]
numerics: {spacing: 20}
output: {frames: none, figures: false, points: {middle: {at: [0, 50]}}}
"""


def force(history: History | None) -> tuple[np.ndarray, np.ndarray]:
    """Load factors and the force (N/m) of the support that pulls."""
    assert history is not None
    return history.load_factor, history.values[:, history.columns.index("supports.1.force_x")]


PLACES = WIDTH * (np.linspace(-0.5, 0.5, 401)[1:] - 0.5 / 400)  # m: midpoints of pieces of the joint


def shear_along(d: float) -> np.ndarray:
    """Shear (Pa) at `PLACES` under a displacement d (m) from rest on."""
    shear = np.zeros(len(PLACES))
    for _ in range(6):
        pressure = PRESSURE + 12.0 * HEIGHT * np.mean(shear) * PLACES / WIDTH**2
        peak, residual = 0.8 * pressure + 5e5, 0.6 * pressure
        fall = (peak - residual) / WEAKENING
        slip = (SHEAR * d - peak) / (SHEAR - fall)  # of a point whose shear is b_0 - fall s = k (d - s)
        shear = np.where(slip < 0.0, SHEAR * d, np.maximum(peak - fall * slip, residual))
    return shear


def test_force_follows_the_closed_form() -> None:
    found = [force(result.history) for result in steps_of(STIFF)]
    d = 0.003 * np.concatenate([factor for factor, _ in found])
    pull = np.concatenate([each for _, each in found]) / WIDTH
    assert pull[-1] == pytest.approx(RESIDUAL, rel=1e-7)
    np.testing.assert_allclose(pull, [np.mean(shear_along(each)) for each in d], rtol=2e-3)
    assert np.sum((pull < 0.99 * PEAK) & (pull > 1.01 * RESIDUAL)) > 20


def test_friction_and_fall_take_what_the_law_says() -> None:
    """The residual friction over all of the slip, and the triangle above it over the weakening length."""
    last = steps_of(STIFF)[-1]
    slip = 0.003 - RESIDUAL / SHEAR
    expected = WIDTH * (RESIDUAL * slip + 0.5 * (PEAK - RESIDUAL) * WEAKENING)
    assert last.energy.dissipated == pytest.approx(expected, rel=1e-3)
    assert abs(last.energy.released) < 1e-8 * expected
    assert last.energy.error < 1e-8


def test_partly_worn_joint_takes_what_the_law_says() -> None:
    """Forth, back without slip, and on: friction has taken what shear has done on slip, and nothing is released."""
    factors = (0.1, 0.2, 0.15, 0.5, 0.45, 0.6)
    farthest = np.maximum.accumulate(factors)
    found = steps_of(STIFF, f"loading.history={list(factors)}")
    d = 0.003 * np.linspace(0.0, 0.6, 1201)
    shear = np.array([shear_along(each) for each in d])
    slip = d[:, None] - shear / SHEAR
    total = WIDTH * np.cumsum(np.mean(0.5 * (shear[1:] + shear[:-1]) * np.diff(slip, axis=0), axis=1))
    for factor, result in zip(farthest, found, strict=True):
        taken = np.interp(0.003 * factor, d[1:], total)
        assert result.energy.dissipated == pytest.approx(taken, rel=1e-3)
        assert abs(result.energy.released) < 1e-8 * taken
        assert result.energy.error < 1e-8


def test_peak_is_a_property_of_the_joint_and_not_of_the_lattice() -> None:
    found = [steps_of(DIRECT_SHEAR, f"numerics.spacing={h}")[-1] for h in (20, 14, 10)]
    peaks = np.array([force(result.history)[1].max() for result in found])
    np.testing.assert_allclose(peaks, peaks.mean(), rtol=0.01)
    assert np.all(peaks < 0.2 * PEAK)  # its ends have slipped before its middle
    assert np.all(peaks > 0.2 * RESIDUAL)
    np.testing.assert_allclose([force(result.history)[1][-1] for result in found], 0.2 * RESIDUAL, rtol=1e-6)


def test_a_joint_remembers_how_much_it_has_lost() -> None:
    """Pushed back after a part of the weakening length it yields at what is left, and loses on."""
    half = 0.003 * 0.5
    there, back = steps_of(STIFF, "loading.history=[0.5, -0.05]")
    fall = (PEAK - RESIDUAL) / WEAKENING
    slip = (SHEAR * half - PEAK) / (SHEAR - fall)
    assert force(there.history)[1][-1] == pytest.approx(WIDTH * (PEAK - fall * slip), rel=0.01)
    assert np.abs(force(back.history)[1]).max() == pytest.approx(WIDTH * (PEAK - fall * slip), rel=0.01)
    more = abs(force(back.history)[1][-1])
    assert more < 0.999 * WIDTH * (PEAK - fall * slip)


def test_brittle_joints_are_as_without_a_length() -> None:
    """A length that is next to nothing beside the elastic slip is none: the force falls at once."""
    found = steps_of(STIFF.replace("weakening_length: 0.002,", "weakening_length: 1e-7,"))
    assert force(found[-1].history)[1][-1] == pytest.approx(WIDTH * RESIDUAL, rel=1e-4)
