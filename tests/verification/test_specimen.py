"""The whole specimen: its mean stress is that of its edges, its energy that of the rock; platens press on it."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.run.result import SLIP, STICK, StepResult
from crackgrow.run.scene import make_scene
from crackgrow.run.state_values import specimen_means
from tests.solving import whole_run
from tests.verification.solutions import case_of, solved

PULLED = "loads=[{far_field: [0.5, 1, 0.25]}]"


@pytest.mark.parametrize(
    ("scene", "settings", "stress"),
    [
        ("tension0", ("growth.steps=0",), (0.0, 1.0, 0.0)),
        ("compression30", ("growth.steps=0", "cracks.flaw.contact.friction=0.3"), (0.0, -100.0, 0.0)),
        ("junction_static", (PULLED,), (0.5, 1.0, 0.25)),
        ("flaw_and_hole", ("growth.steps=0", PULLED, "loading={history: [1]}"), (0.5, 1.0, 0.25)),
    ],
)
def test_under_uniform_tractions_the_stress_is_theirs_and_the_work_is_that_of_the_means(
    scene: str, settings: tuple[str, ...], stress: tuple[float, float, float]
) -> None:
    """Hill (1963): half of A times stress times strain, with open or slipping cracks and holes."""
    state = solved(scene, *settings).solution.state
    found, strain = map(np.array, specimen_means(state))
    np.testing.assert_allclose(found, 1e6 * np.array(stress), atol=1e-9 * 1e6 * np.abs(stress).max())
    shape = state.scene.case.bodies[0].outline
    area = np.prod(np.ptp(shape, axis=0))
    assert 0.5 * area * (found * [1.0, 1.0, 2.0]) @ strain == pytest.approx(state.energy.work, rel=1e-9)


def test_without_cracks_strains_are_those_of_Hooke_with_in_situ_stress_as_well() -> None:
    """A stress that is there before anything displaces strains nothing; what is added to it does."""
    loads = (
        "loads=[{body: rock, stress: [-3, -2, 0.5], held: true}, {far_field: [-3, -2, 0.5]}, {far_field: [0, 1, 0]}]"
    )
    state = solved("tension0", "growth.steps=0", "cracks={}", loads).solution.state
    stress, strain = specimen_means(state)
    (material,) = make_scene(state.scene.case).materials
    np.testing.assert_allclose(stress, [-3e6, -1e6, 0.5e6], rtol=1e-9)
    xx, yy, twice_xy = np.linalg.solve(material.matrix, [0.0, 1e6, 0.0])
    np.testing.assert_allclose(strain, [xx, yy, 0.5 * twice_xy], atol=1e-12 * abs(yy))


BLOCK = """
title: a block of 40 x 80 mm between platens
plane: stress
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 0.04, height: 0.08}}, material: {young: 10 GPa, poisson: 0.25}}
supports:
  - {on: {edge: bottom}, contact: {LAW}, moves: [0, BELOW]}
  - {on: {edge: top}, contact: {LAW}, moves: [0, ABOVE]}
"""
AREA, HEIGHT, YOUNG, CLOSES = 0.04, 0.08, 1e10, 8e-5  # m, m, Pa, m


def pressed(law: str, above: float = -CLOSES, below: float = 0.0, *settings: str) -> StepResult:
    """The block after its platens have moved."""
    return whole_run(case_of(BLOCK, *settings, LAW=law, ABOVE=above, BELOW=below))[0][-1]


def force(step: StepResult, axis: int = 1) -> float:
    """By which the upper platen presses on the block, N/m."""
    (reaction,) = (one for one in step.reactions if one.where == "rock.top")
    return reaction.force[axis]


def test_between_platens_without_friction_the_stress_is_youngs_modulus_times_the_strain() -> None:
    step = pressed("friction: 0, cohesion: 0")
    assert force(step) == pytest.approx(-YOUNG * CLOSES / HEIGHT * AREA, rel=1e-9)
    np.testing.assert_allclose(step.mean_strain, [0.25 * CLOSES / HEIGHT, -CLOSES / HEIGHT, 0.0], atol=1e-12)
    assert step.energy.work == pytest.approx(0.5 * YOUNG * (CLOSES / HEIGHT) ** 2 * AREA * HEIGHT, rel=1e-9)


def test_only_how_far_platens_come_closer_matters() -> None:
    """One moves, or both, or both the same way besides, or apart: then nothing presses."""
    rough = "friction: 0.1, cohesion: 0"
    one, other = pressed(rough), pressed(rough, -1.5 * CLOSES, -0.5 * CLOSES)
    assert force(other) == pytest.approx(force(one), rel=1e-9)
    assert other.energy.dissipated == pytest.approx(one.energy.dissipated, rel=1e-9)
    np.testing.assert_allclose(other.contact.mean_slip, one.contact.mean_slip, rtol=0, atol=1e-9 * CLOSES)
    assert force(pressed(rough, CLOSES)) == 0.0


def test_joints_below_platens_are_springs_in_a_row() -> None:
    k = 1e12
    step = pressed(f"friction: 0, cohesion: 0, stiffness: {{normal: {k}, shear: {k}}}")
    assert force(step) == pytest.approx(-CLOSES / (HEIGHT / YOUNG + 2.0 / k) * AREA, rel=1e-9)
    assert step.energy.error < 1e-9


def test_a_platen_that_rubs_along_pulls_by_friction_times_its_force() -> None:
    """The block is held below, and bends: a corner parts from the platen, and all the rest slides."""
    moves = "supports.1.moves=[4e-4, -8e-5]"
    held = "supports.0={on: {edge: bottom}, displacement: [0, 0]}"
    step = pressed("friction: 0.2, cohesion: 0", -CLOSES, 0.0, moves, held)
    assert STICK not in step.contact.state
    assert SLIP in step.contact.state
    assert force(step, 0) == pytest.approx(-0.2 * force(step), rel=1e-9)
    assert step.energy.error < 1e-9


@pytest.mark.parametrize("sideways", [0.0, 4e-5])
def test_platens_that_part_and_press_again_do_the_same_work_once_more(sideways: float) -> None:
    """In between the block lies anywhere, and carries nothing."""
    settings = ("loading={history: [1, -1, 1]}", f"supports.1.moves=[{sideways}, {-CLOSES}]")
    steps, _ = whole_run(case_of(BLOCK, *settings, LAW="friction: 0.1, cohesion: 0", ABOVE=-CLOSES, BELOW=0))
    first, parted, again = (step.energy for step in steps)
    assert first.dissipated > 0.0
    assert (parted.strain, parted.work) == pytest.approx((0.0, parted.dissipated), abs=1e-9 * first.work)
    assert again.strain == pytest.approx(first.strain, rel=1e-9)
    assert again.work == pytest.approx(first.work + parted.work, rel=1e-8)
    assert abs(again.released) < 1e-9 * first.work


def test_growth_between_platens_goes_on_from_the_state_before() -> None:
    """A flaw grows under load: what is released is the work of none, for the platens stand still meanwhile."""
    flaw = "cracks={flaw: {path: {center: [0, 0], length: 0.012, angle: 45}, contact: {friction: 0.2, cohesion: 0}}}"
    strength = "bodies.rock.strength={tension: 1 MPa, cohesion: 20 MPa, friction_angle: 40}"
    grows = "growth={steps: 2, increment: 0.002, criterion: directional_strength, tip_stress: {radius: 0.001}}"
    settings = (flaw, strength, grows, "numerics={accuracy: draft}", "growth.unload_between_steps=false")
    steps, _ = whole_run(case_of(BLOCK, *settings, LAW="friction: 0.1, cohesion: 0", ABOVE=-CLOSES, BELOW=0))
    works = [step.energy.work for step in steps]
    assert works == pytest.approx([works[0]] * 3, rel=1e-9)
    assert steps[2].energy.released > steps[1].energy.released > 0.0
    assert abs(force(steps[2])) < abs(force(steps[0]))
