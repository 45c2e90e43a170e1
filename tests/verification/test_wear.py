"""Friction and dilation that wear with slip, exponentially or by a table, in direct shear, against closed forms.

A stiff block on a joint of shear stiffness k moves as one: under a displacement d and a pressure p the shear stress is
p mu(s) with the slip s = d - shear / k. It rises by the integral of tan(dilation angle) over all slip, less p / k_n.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.contact.coulomb import ContactLaw
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.whole_run import whole_run

JOINT = "rough_joint_sheared"
PRESSURE, SHEAR, NORMAL, PULLED, DECAY = 2e6, 1e10, 1e12, 6e-3, 2e-3
STEEP = np.tan(np.deg2rad(15.0))

TABLE = """
title: a flat, stiff block, sheared
plane: strain
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e14, poisson: 0}}
supports:
  - on: {body: top, edge: bottom}
    contact: {friction: 0.8, dilation_angle: 15, stiffness: {normal: 1e12, shear: 1e10},
              wear: {slip: [1 mm, 3 mm], friction: [0.6, 0.5], dilation_angle: [6, 0]}}
  - {on: {body: top, edge: top}, displacement: {x: 0.006}}
loads: [{on: {body: top, edge: top}, traction: [0, -2e6], held: true}]
loading: {history: [0.25, 0.5, 1]}
numerics: {spacing: 0.001, contact: {spacing: 4}}
output: {frames: none, figures: false, points: {joint: {at: [0, 0.002]}}}
"""


def seen(results: Sequence[StepResult], width: float = 0.4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement of the support that pulls (m), shear stress (Pa), and rise (m), on the way of all steps."""
    found = []
    for result in results:
        told = result.history
        assert told is not None
        force, rise = (told.values[:, told.columns.index(name)] for name in ("supports.1.force_x", "joint.u_y"))
        found.append(np.stack([PULLED * told.load_factor, force / width, rise + PRESSURE / NORMAL]))
    d, shear, rise = np.concatenate(found, axis=1)
    return d, shear, rise


def test_friction_and_dilation_decay_with_slip() -> None:
    results = whole_run(shipped_case(JOINT, ["loading.follow=events"]))[0]
    d, shear, rise = seen(results[:2])
    slip = d - shear / SHEAR
    slides = slip > 1e-4
    assert np.sum(slides) > 20
    decayed = np.exp(-slip / DECAY)
    np.testing.assert_allclose(shear[slides], (PRESSURE * (0.5 + 0.3 * decayed))[slides], rtol=1e-3)
    expected = (STEEP * DECAY * (1.0 - decayed))[slides]
    np.testing.assert_allclose(rise[slides], expected, atol=1e-3 * expected.max())
    assert max(result.energy.error for result in results) < 1e-7
    assert abs(results[-1].energy.released) < 1e-8 * results[-1].energy.work


def test_faces_that_slip_back_close_by_the_dilation_that_is_left() -> None:
    results = whole_run(shipped_case(JOINT, ["loading.follow=events"]))[0]
    there, back = (seen(some) for some in (results[:2], results[2:]))
    slip, returned = there[0][-1] - there[1][-1] / SHEAR, back[0][-1] - back[1][-1] / SHEAR
    worn = DECAY * (np.exp(-slip / DECAY) - np.exp(-(2.0 * slip - returned) / DECAY))
    assert back[2][-1] == pytest.approx(there[2][-1] - STEEP * worn, rel=1e-3)
    assert back[1][-1] == pytest.approx(-PRESSURE * (0.5 + 0.3 * np.exp(-(2.0 * slip - returned) / DECAY)), rel=1e-3)


def test_a_few_increments_come_to_the_same() -> None:
    """The share that an increment takes, and its mean dilation, are exact for slip one way."""
    results = whole_run(shipped_case(JOINT, ["loading={history: [0.3, 1], follow: 1}"]))[0]
    d, shear, rise = seen(results)
    decayed = np.exp(-(d[-1] - shear[-1] / SHEAR) / DECAY)
    assert shear[-1] == pytest.approx(PRESSURE * (0.5 + 0.3 * decayed), rel=1e-3)
    assert rise[-1] == pytest.approx(STEEP * DECAY * (1.0 - decayed), rel=1e-3)


@pytest.mark.parametrize("follow", ["events", 1])
def test_a_table_is_followed(follow: str | int, tmp_path: Path) -> None:
    path = tmp_path / "shear.yaml"
    path.write_text(TABLE, encoding="utf-8")
    results = whole_run(load_case(path, [f"loading.follow={follow}"]))[0]
    d, shear, rise = seen(results, 0.1)
    slip, at = d - shear / SHEAR, [0.0, 1e-3, 3e-3]
    places = np.linspace(0.0, PULLED, 60001)
    steep = np.interp(places, at, np.tan(np.deg2rad([15.0, 6.0, 0.0])))
    risen = np.append(0.0, np.cumsum(0.5 * (steep[1:] + steep[:-1]) * np.diff(places)))
    slides = slip > 1e-4
    np.testing.assert_allclose(shear[slides], PRESSURE * np.interp(slip, at, [0.8, 0.6, 0.5])[slides], rtol=1e-3)
    np.testing.assert_allclose(rise[slides], np.interp(slip, places, risen)[slides], rtol=1e-3)
    if follow == "events":
        assert max(result.energy.error for result in results) < 1e-7


def test_the_mean_dilation_is_that_of_its_integral() -> None:
    """By differences: the mean over slip from a share on, times the slip, has the rate of the law as its derivative."""
    shares = np.array([[0.0, 0.0], [0.4, 1.0], [1.0, 1.0]])
    one, rows = np.ones((3, 2)), np.array([[0.3, 0.3], [0.1, 0.05], [0.05, 0.05]])
    decays = np.array([False, True])
    law = ContactLaw(
        np.zeros(2), np.zeros(2), np.full(2, 2.0), decays, shares, one, 0.0 * one, 0.0 * one, rows, *np.ones((3, 2))
    )
    first, step = np.full(2, 0.1), 1e-6

    def after(slip: float) -> np.ndarray:
        return first + law.worn(first, np.full(2, slip))

    def risen(slip: float) -> np.ndarray:
        return law.dilation_between(first, after(slip)) * slip

    for slip in (1e-3, 0.2, 0.5, 1.0, 1.7, 2.5):
        rate = (risen(slip + step) - risen(slip - step)) / (2.0 * step)
        np.testing.assert_allclose(rate, law.dilation_of(after(slip)), rtol=1e-7)
    np.testing.assert_array_equal(law.dilation_between(first, first), law.dilation_of(first))
