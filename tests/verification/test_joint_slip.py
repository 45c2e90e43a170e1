"""Friction, tensile strength and dilation that slip takes: linearly, exponentially, by a table; in closed form.

A stiff block on a joint of shear stiffness k moves as one: under a displacement d its slip is s = d - shear / k. Under
wear the shear is p mu(s), and the block rises by the integral of tan(dilation angle) over all slip, less p / k_n.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.verification.stiff_block import NORMAL, SHEAR, SOFT, WIDTH, sheared
from tests.whole_run import seen, steps_of, whole_run

PRESSURE = 2e6  # Pa
PEAK, RESIDUAL = 0.8 * PRESSURE + 5e5, 0.6 * PRESSURE  # Pa


def pull(results: Sequence[StepResult]) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (m) and mean shear (Pa) of the support that pulls, on the way of all steps."""
    factors = np.concatenate([result.history.load_factor for result in results if result.history is not None])
    return 0.003 * factors, seen(results, "supports.1.force_x") / WIDTH


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
output: {frames: none, figures: false, points: {middle: {at: [0, 50]}}}
"""


def test_the_peak_is_a_property_of_the_joint_and_not_of_the_lattice() -> None:
    found = [steps_of(DIRECT_SHEAR, f"numerics.spacing={h}")[-1] for h in (20, 14, 10)]
    forces = [seen([result], "supports.1.force_x") for result in found]
    peaks = np.array([force.max() for force in forces])
    np.testing.assert_allclose(peaks, peaks.mean(), rtol=0.01)
    assert np.all(peaks < 0.2 * PEAK)  # its ends have slipped before its middle
    assert np.all(peaks > 0.2 * RESIDUAL)
    np.testing.assert_allclose([force[-1] for force in forces], 0.2 * RESIDUAL, rtol=1e-6)


def test_slip_takes_tensile_strength_as_it_takes_cohesion() -> None:
    """Under displacements d and g of a stiff block slip s takes s / D of c and T; it opens where k_n g is what is left.

    With k the shear stiffness k (d - s) = c (1 - s / D) - mu k_n g where it slips.
    """
    law = f"friction: 0.8, cohesion: 5e6, tension: 2e6, weakening_length: 0.002, {SOFT}"
    found = sheared(law, "x: 0.003, y: 1e-6", pressure=0.0)
    d, shear = pull(found)
    factor = d / 0.003
    slip = (1e10 * d - 5e6 + 0.8 * 1e6 * factor) / (1e10 - 5e6 / 0.002)
    expected = np.where(slip < 0.0, 1e10 * d, 1e10 * (d - slip))
    opens = factor[np.argmax(2e6 * (1.0 - slip / 0.002) < 1e6 * factor)]
    before = factor < 0.999 * opens
    assert np.sum(before) > 20
    np.testing.assert_allclose(shear[before], expected[before], rtol=1e-3)
    assert np.abs(shear[factor > 1.001 * opens]).max() < 1e-6 * shear.max()
    assert 0.5 < opens < 0.55


# Wear: `rough_joint_sheared`, whose friction and dilation decay, and a table.

PULLED, DECAY, STEEP = 6e-3, 2e-3, np.tan(np.deg2rad(15.0))


def worn(results: Sequence[StepResult], width: float = 0.4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slip (m), shear stress (Pa) and rise (m), on the way of all steps."""
    factors = np.concatenate([result.history.load_factor for result in results if result.history is not None])
    shear = seen(results, "supports.1.force_x") / width
    return PULLED * factors - shear / SHEAR, shear, seen(results, "joint.u_y") + PRESSURE / NORMAL


def test_friction_and_dilation_decay_with_slip_and_faces_close_again_by_what_is_left() -> None:
    results = whole_run(shipped_case("rough_joint_sheared", ["loading.follow=events"]))[0]
    slip, shear, rise = worn(results[:2])
    slides, decayed = slip > 1e-4, np.exp(-slip / DECAY)
    assert np.sum(slides) > 20
    np.testing.assert_allclose(shear[slides], (PRESSURE * (0.5 + 0.3 * decayed))[slides], rtol=1e-3)
    expected = (STEEP * DECAY * (1.0 - decayed))[slides]
    np.testing.assert_allclose(rise[slides], expected, atol=1e-3 * expected.max())
    assert max(result.energy.error for result in results) < 1e-7
    assert abs(results[-1].energy.released) < 1e-8 * results[-1].energy.work
    back = [each[-1] for each in worn(results[2:])]
    left = np.exp(-(2.0 * slip[-1] - back[0]) / DECAY)
    assert back[1] == pytest.approx(-PRESSURE * (0.5 + 0.3 * left), rel=1e-3)
    assert back[2] == pytest.approx(rise[-1] - STEEP * DECAY * (decayed[-1] - left), rel=1e-3)


@pytest.mark.parametrize("follow", ["events", 1])
def test_a_table_is_followed(follow: str | int) -> None:
    wear = "wear: {slip: [1 mm, 3 mm], friction: [0.6, 0.5], dilation_angle: [6, 0]}"
    law = f"friction: 0.8, dilation_angle: 15, {SOFT}, {wear}"
    results = sheared(law, "x: 0.006", f"loading={{history: [0.25, 0.5, 1], follow: {follow}}}")
    slip, shear, rise = worn(results, WIDTH)
    at, places = [0.0, 1e-3, 3e-3], np.linspace(0.0, PULLED, 60001)
    steep = np.interp(places, at, np.tan(np.deg2rad([15.0, 6.0, 0.0])))
    risen = np.append(0.0, np.cumsum(0.5 * (steep[1:] + steep[:-1]) * np.diff(places)))
    slides = slip > 1e-4
    np.testing.assert_allclose(shear[slides], PRESSURE * np.interp(slip, at, [0.8, 0.6, 0.5])[slides], rtol=1e-3)
    np.testing.assert_allclose(rise[slides], np.interp(slip, places, risen)[slides], rtol=1e-3)
    assert follow != "events" or max(result.energy.error for result in results) < 1e-7
