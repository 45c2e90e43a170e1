"""Joints that bear tension up to their tensile strength, and then none, against closed forms of uniform stress."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from tests.scenes import shipped_case
from tests.whole_run import seen, steps_of, whole_run

VEIN = "vein_in_tension"
STRENGTH, AREA, LENGTH, YOUNG = 2e6, 0.05, 0.1, 10e9  # Pa, m, m, Pa
PEAK = STRENGTH / np.cos(np.deg2rad(20.0)) ** 2  # Pa, of axial stress

SLAB = """
title: a slab hangs under a roof
plane: strain
units: {length: m, stress: MPa}
materials: {rock: {young: 20000, poisson: 0, density: 2600}}
bodies:
  roof: {shape: {rectangle: {center: [0, 1], width: 4, height: 2}}, material: rock}
  slab: {shape: {rectangle: {center: [0, -0.5], width: 4, height: 1}}, material: rock}
interfaces:
  - {between: [roof, slab], contact: {friction: 0.5, cohesion: 0.1, tension: 0.1}}
supports: [{on: {body: roof, edge: top}, displacement: {x: 0, y: 0}}]
loads: [{body: slab, gravity: [0, "-9.81 m/s^2"]}]
loading: strength_reduction
numerics: {spacing: 0.5}
output: {frames: none, figures: false}
"""

SHEARED = """
title: a flat, stiff block, sheared and pulled
plane: stress
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e14, poisson: 0}}
supports:
  - on: {body: top, edge: bottom}
    contact: {friction: 0.8, cohesion: 5e6, tension: 2e6, weakening_length: 0.002,
              stiffness: {normal: 1e12, shear: 1e10}}
  - {on: {body: top, edge: top}, displacement: {x: 0.003, y: 1e-6}}
numerics: {spacing: 0.001, contact: {spacing: 4}}
output: {frames: none, figures: false, points: {middle: {at: [0, 0.002]}}}
"""


def test_a_vein_opens_at_its_tensile_strength_and_then_has_none() -> None:
    before, broken, pressed = whole_run(shipped_case(VEIN))[0]
    assert seen([before], "supports.1.force_y")[-1] == pytest.approx(0.5 * 4e-5 / LENGTH * YOUNG * AREA, rel=1e-9)
    force = seen([broken], "supports.1.force_y")
    assert force.max() == pytest.approx(PEAK * AREA, rel=1e-3)
    assert abs(force[-1]) < 1e-9 * PEAK * AREA
    released = 0.5 * PEAK**2 / YOUNG * AREA * LENGTH
    assert broken.energy.released == pytest.approx(released, rel=1e-3)
    assert max(result.energy.error for result in (before, broken, pressed)) < 1e-8
    assert seen([pressed], "supports.1.force_y")[-1] == pytest.approx(-0.5 * 4e-5 / LENGTH * YOUNG * AREA, rel=1e-9)


def test_a_vein_that_has_opened_bears_no_tension_again() -> None:
    again = whole_run(shipped_case(VEIN, ["loading.history=[1, -0.5, 0.4]"]))[0][-1]
    assert np.abs(seen([again], "supports.1.force_y")[-1]) < 1e-9 * PEAK * AREA


def test_a_slab_hangs_as_long_as_its_bond_bears_its_weight(tmp_path: Path) -> None:
    path = tmp_path / "slab.yaml"
    path.write_text(SLAB, encoding="utf-8")
    safety = whole_run(load_case(path))[1].safety
    assert safety is not None
    assert safety.factor == pytest.approx(0.1e6 / (2600 * 9.81 * 1.0), rel=1e-3)
    assert "slab" in safety.mechanism


def test_slip_takes_tensile_strength_as_it_takes_cohesion() -> None:
    """Under displacements d and g of a stiff block slip s takes s / D of c and T; it opens where k_n g is what is left.

    With k the shear stiffness k (d - s) = c (1 - s / D) - mu k_n g where it slips.
    """
    (result,) = steps_of(SHEARED)
    assert result.history is not None
    factor, shear = result.history.load_factor, seen([result], "supports.1.force_x") / 0.1
    slip = (1e10 * 0.003 * factor - 5e6 + 0.8 * 1e6 * factor) / (1e10 - 5e6 / 0.002)
    expected = np.where(slip < 0.0, 1e10 * 0.003 * factor, 1e10 * (0.003 * factor - slip))
    opens = factor[np.argmax(2e6 * (1.0 - slip / 0.002) < 1e6 * factor)]
    before = factor < 0.999 * opens
    assert np.sum(before) > 20
    np.testing.assert_allclose(shear[before], expected[before], rtol=1e-3)
    assert np.abs(shear[factor > 1.001 * opens]).max() < 1e-6 * shear.max()
    assert 0.5 < opens < 0.55


def test_points_open_one_after_the_other() -> None:
    """A block that is lifted at one edge opens its joint to where p = k g is the strength; the rest holds as before."""
    text = SHEARED.replace("tension: 2e6, weakening_length: 0.002", "tension: 1e6").replace("1e10}", "1e12}")
    text = text.replace("{x: 0.003, y: 1e-6}", '{y: "2e-6*(0.5+x/0.1)"}').replace(
        "contact: {spacing: 4}", "contact: {}"
    )
    (result,) = steps_of(text, "loading={history: [1]}")
    released = 0.5 * 1e6**2 / 1e12 * 0.1 * 0.5
    assert result.energy.released == pytest.approx(released, rel=0.03)
    assert seen([result], "supports.1.force_y")[-1] == pytest.approx(0.5 * 1e6 * 0.05, rel=0.06)
    assert result.energy.error < 1e-8
