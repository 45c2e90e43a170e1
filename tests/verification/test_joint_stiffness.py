"""Joints with a stiffness of their own, across and along (Goodman, Taylor, Brekke 1968): uniform stress, closed form.

A block of height H under pressure p and shear q on an elastic joint: the joint closes by p / k_n and slips by q / k_s,
the block deforms as without it. Nothing depends on the lattice.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.run.result import StepResult
from tests.whole_run import whole_run

YOUNG = 1e10  # Pa; Poisson's ratio is zero: shear modulus E/2
NORMAL, SHEAR = 2e10, 5e9  # Pa/m
PRESSURE, STRESS = 3e6, 1e6  # Pa

TWO_BLOCKS = """
title: two blocks and a joint
plane: stress
bodies:
  low: {{shape: {{rectangle: {{center: [0, -0.05], width: 0.1, height: 0.1}}}}, material: {{young: 1e4, poisson: 0}}}}
  top: {{shape: {{rectangle: {{center: [0, 0.05], width: 0.1, height: 0.1}}}}, material: {{young: 1e4, poisson: 0}}}}
interfaces:
  - {{between: [top, low], contact: {{friction: 0.6, cohesion: 0, stiffness: {{normal: 20 GPa/m, shear: 5000}}}}}}
units: {{stress: MPa}}
supports:
  - {{on: {{body: low, edge: bottom}}, displacement: {{x: 0, y: 0}}}}
loads:
  - {{on: {{body: top, edge: top}}, traction: [1, -3]}}
  - {{on: {{body: top, edge: left}}, traction: [0, -1]}}
  - {{on: {{body: top, edge: right}}, traction: [0, 1]}}
  - {{on: {{body: low, edge: left}}, traction: [0, -1]}}
  - {{on: {{body: low, edge: right}}, traction: [0, 1]}}
numerics: {{spacing: {spacing}}}
output: {{frames: none, figures: false, points: {{joint: {{interface: [top, low], at: [0.02, 0]}}}}}}
"""

ON_FOUNDATION = """
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
output: {frames: none, figures: false, points: {top: {at: [0.03, 0.1]}}}
"""


def solved(folder: Path, text: str, *overrides: str) -> StepResult:
    path = folder / "joint.yaml"
    path.write_text(text, encoding="utf-8")
    (result, *_), _ = whole_run(load_case(path, overrides))
    return result


def seen(result: StepResult, name: str) -> float:
    assert result.history is not None
    return float(result.history.values[-1, result.history.columns.index(name)])


@pytest.mark.parametrize("spacing", [0.05, 0.02, 0.013])
def test_joint_between_blocks_closes_and_slips_by_its_stiffness(spacing: float, tmp_path: Path) -> None:
    result = solved(tmp_path, TWO_BLOCKS.format(spacing=spacing))
    assert seen(result, "joint.opening") == pytest.approx(-PRESSURE / NORMAL, rel=1e-8)
    assert abs(seen(result, "joint.slip")) == pytest.approx(STRESS / SHEAR, rel=1e-8)
    np.testing.assert_allclose(result.contact.normal_traction, -PRESSURE, rtol=1e-7)
    np.testing.assert_allclose(np.abs(result.contact.tangential_traction), STRESS, rtol=1e-7)
    strain_energy = 0.1 * (PRESSURE**2 / NORMAL + STRESS**2 / SHEAR) / 2.0
    strain_energy += 0.02 * (PRESSURE**2 + 2.0 * STRESS**2) / (2.0 * YOUNG)
    assert result.energy.strain == pytest.approx(strain_energy, rel=1e-8)
    assert result.energy.error < 1e-9


def test_block_on_a_foundation_with_a_stiffness(tmp_path: Path) -> None:
    result = solved(tmp_path, ON_FOUNDATION)
    assert seen(result, "top.u_y") == pytest.approx(-PRESSURE / NORMAL - 0.1 * PRESSURE / YOUNG, rel=1e-8)
    assert seen(result, "top.u_x") == pytest.approx(STRESS / SHEAR + 0.1 * STRESS / (0.5 * YOUNG), rel=1e-8)


SHEARED = """
title: a flat, stiff block, sheared on an elastic foundation and back
plane: stress
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e15, poisson: 0}}
supports:
  - {on: {body: top, edge: bottom}, contact: {friction: 0.6, cohesion: 0, stiffness: {normal: 2e10, shear: 5e9}}}
  - {on: {body: top, edge: top}, displacement: {x: 0.0006}}
loads: [{on: {body: top, edge: top}, traction: [0, -3e6], held: true}]
loading: {history: [1, 0]}
numerics: {spacing: 0.001}
output: {frames: none, figures: false}
"""


def test_slip_beyond_friction_is_not_elastic(tmp_path: Path) -> None:
    """Sheared by d and back to none, a joint that has slipped by s = d - mu p / k_s is sheared by k_s s the other way.

    The block turns a little, by its height times which its base slips less than its top: 0.2 % of the slip, each way.
    """
    path = tmp_path / "sheared.yaml"
    path.write_text(SHEARED, encoding="utf-8")
    results, _ = whole_run(load_case(path))
    (there, back) = ({r.where: r.force[0] for r in result.reactions}["supports.1"] / 0.1 for result in results)
    assert there == pytest.approx(0.6 * PRESSURE, rel=1e-4)
    assert back == pytest.approx(-(SHEAR * 0.0006 - 0.6 * PRESSURE), rel=5e-3)


def test_stiffness_of_a_crack_is_that_of_the_numerics_where_it_is_the_same() -> None:
    """kappa E / h, given in one way or the other."""
    cases = Path(__file__).parents[2] / "cases"
    settings = ["growth.steps=0", "numerics.spacing=1", "output.frames=none", "output.figures=false"]
    k = 100.0 * 10000.0 / 1.0  # MPa/mm
    found = [
        whole_run(load_case(cases / "compression30.yaml", [*settings, *more]))[0][0]
        for more in (
            ["numerics.contact.stiffness=100"],
            [f"cracks.flaw.contact.stiffness.normal={k}", f"cracks.flaw.contact.stiffness.shear={k}"],
        )
    ]
    for one, other in zip(*(result.tips for result in found), strict=True):
        assert pytest.approx((other.K_I, other.K_II), rel=1e-9) == (one.K_I, one.K_II)
    np.testing.assert_allclose(found[0].contact.normal_traction, found[1].contact.normal_traction, rtol=1e-9)


DRIVEN = """
title: a joint that coheres and dilates is pressed and sheared by displacements
plane: strain
units: {length: mm, stress: MPa}
bodies:
  up: {shape: {rectangle: {center: [0, 25], width: 100, height: 50}}, material: {young: 10000, poisson: 0.2}}
  low: {shape: {rectangle: {center: [0, -25], width: 100, height: 50}}, material: {young: 10000, poisson: 0.2}}
interfaces:
  - between: [up, low]
    contact: {friction: 0.78, cohesion: 1.32, residual_friction: 0.51, dilation_angle: 10.3, stiffness: STIFFNESS}
supports:
  - {on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}
  - {on: {body: up, edge: top}, displacement: {x: 0.557, y: -0.3456}}
loading: {history: HISTORY}
numerics: {spacing: 20}
output: {frames: none, figures: false}
"""


def driven(folder: Path, history: str) -> list[StepResult]:
    text = DRIVEN.replace("STIFFNESS", "{normal: 14 MPa/mm, shear: 9.5 MPa/mm}").replace("HISTORY", history)
    path = folder / "driven.yaml"
    path.write_text(text, encoding="utf-8")
    results, _ = whole_run(load_case(path))
    return results


def test_bonds_that_have_not_slipped_hold_when_the_load_has_been_away(tmp_path: Path) -> None:
    """Without load all jumps are round-off: faces that dilate parted by it here and there, and cohered no more."""
    *_, away, back = driven(tmp_path, "[0.5, 0.8, 0, 1]")
    *_, straight = driven(tmp_path, "[0.5, 0.8, 1]")
    assert (back.contact.state == straight.contact.state).all()
    np.testing.assert_allclose(back.contact.tangential_traction, straight.contact.tangential_traction, rtol=1e-9)
    assert away.energy.error < 1e-9
    assert not away.warnings


def test_nothing_is_out_of_balance_where_faces_have_parted(tmp_path: Path) -> None:
    """No force is left but round-off, which is as large as itself."""
    _, apart = driven(tmp_path, "[0.5, -0.5]")
    assert apart.contact.opening.min() > 1e-4
    assert not apart.warnings
