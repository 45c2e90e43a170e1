"""Scenes of several bodies, foundations and body loads whose answer is known in closed form or by superposition."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.case.load import read_case
from crackgrow.contact.coulomb import SLIP, STICK
from crackgrow.errors import SolveError
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.state_values import reactions
from tests.solving import displacement_in, solve_case

PATCH_TEST = {1.5: 1e-7, 2.0: 1e-9}
"""Relative displacement error under uniform stress, by support: vertices are rounded to 1e-9 spacings, and contact acts
at other points than the divergence theorem holds at, which rougher functions see."""

STACK = """
title: Two blocks on each other
plane: strain
bodies:
  upper: {shape: {rectangle: {center: [0.5, 0.8], width: 1, height: 0.6}}, material: {young: 1e10, poisson: 0.3}}
  lower: {shape: {rectangle: {center: [0.5, 0.25], width: 1, height: 0.5}}, material: {young: 1e10, poisson: 0.3}}
interfaces: [{between: [upper, lower], contact: {friction: 0.5, cohesion: 0}}]
supports:
  - {on: {body: lower, edge: bottom}, displacement: {y: 0}}
  - {at: [0, 0], displacement: {x: 0}}
loads:
  - {on: {body: upper, edge: top}, traction: [0, -1e6]}
numerics: {spacing: 0.13}
"""

BLOCK = """
title: A block on a rigid foundation
plane: strain
bodies:
  block: {shape: {rectangle: {center: [0, 1], width: 4, height: 2}}, material: {young: 1000, poisson: 0.25}}
supports:
  - {on: {body: block, edge: bottom}, contact: {friction: 0.5, cohesion: 0}}
loads:
  - {on: {body: block, edge: top}, traction: [0, -100]}
numerics: {spacing: 0.3}
"""


def solve(text: str, *settings: str) -> StepSolution:
    return solve_case(read_case(text, "scene", "scene", settings))


def places(low: tuple[float, float], high: tuple[float, float], n: int = 300) -> np.ndarray:
    return np.random.default_rng(70).uniform(low, high, (n, 2))


def test_a_bond_carries_tension_where_contact_lets_go() -> None:
    pull = "loads.0.traction=[0, 1e6]"
    solution = solve(STACK, "interfaces.0.contact=bonded", pull)
    e_yy, e_xx = 1e6 * (1 - 0.3**2) / 1e10, -1e6 * 0.3 * 1.3 / 1e10
    metres = places((0, 0.5), (1, 1.1))
    error = np.abs(displacement_in(solution, metres) - metres * (e_xx, e_yy)).max()
    assert error < PATCH_TEST[2.0] * 1.1 * e_yy
    assert solution.outcome.points.n_unknowns == 0  # a bond is no contact
    with pytest.raises(
        SolveError, match=r"body '\w+' is free to move: contact does not hold it, it moves off '\w+/\w+'"
    ):
        solve(STACK, pull)


def test_a_frictionless_block_slides_at_any_push_and_without_one_its_place_is_arbitrary() -> None:
    smooth = "supports.0.contact={friction: 0, cohesion: 0}"
    solution = solve(BLOCK, smooth)
    assert set(solution.outcome.points.state.tolist()) == {SLIP}
    assert solution.outcome.points.n_unknowns == solution.configuration.faces.n  # normal only
    (note,) = solution.outcome.notes
    assert "(translation in x)" in note
    assert "arbitrary" in note
    assert solve(BLOCK).outcome.notes == ()
    with pytest.raises(SolveError, match="contact does not hold it"):
        solve(BLOCK, smooth, "loads.0.traction=[1, -100]")


SLANTED = """
title: Two blocks with a slanted joint
plane: strain
bodies:
  up: {{shape: {{polygon: [[0, {left}], [1, {right}], [1, 2], [0, 2]]}}, material: {{young: 1e10, poisson: 0.3}}}}
  lo: {{shape: {{polygon: [[0, 0], [1, 0], [1, {right}], [0, {left}]]}}, material: {{young: 1e10, poisson: 0.3}}}}
interfaces: [{{between: [up, lo], contact: {contact}}}]
supports:
  - {{on: {{body: lo, edge: "0"}}, displacement: {{y: 0}}}}
  - {{at: [0, 0], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: up, edge: "2"}}, traction: [0, -1e6]}}
numerics: {{spacing: 0.17, support: {support}}}
"""

INCLUSION = """
title: A plate with a core of the same rock
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 4, height: 4}}, holes: [{shape}]}}
    material: {{young: 1e10, poisson: 0.3}}
  core: {{shape: {shape}, material: {{young: 1e10, poisson: 0.3}}}}
interfaces: [{{between: [rock, core], contact: {contact}}}]
supports:
  - {{on: {{body: rock, edge: bottom}}, displacement: {{y: 0}}}}
  - {{at: [-2, -2], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [0, -1e6]}}
  - {{on: {{body: rock, edge: left}}, traction: [1e6, 0]}}
  - {{on: {{body: rock, edge: right}}, traction: [-1e6, 0]}}
numerics: {{spacing: 0.2, support: {support}}}
"""

CONTACTS = ("bonded", "{friction: 2, cohesion: 0}")


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize("seed", range(2))
def test_patch_test_through_slanted_joints(seed: int, contact: str, support: float) -> None:
    left, right = np.random.default_rng(seed).uniform(0.6, 1.4, 2).tolist()
    solution = solve(SLANTED.format(left=left, right=right, contact=contact, support=support))
    e_yy, e_xx = -1e6 * (1 - 0.3**2) / 1e10, 1e6 * 0.3 * 1.3 / 1e10
    metres = places((0, 0), (1, 2))
    above = metres[:, 1] > left + (right - left) * metres[:, 0]
    for body, mine in enumerate((metres[above], metres[~above])):
        error = np.abs(displacement_in(solution, mine, body) - mine * (e_xx, e_yy)).max()
        assert error < PATCH_TEST[support] * 2.0 * abs(e_yy)


@pytest.mark.parametrize("support", [1.5, 2.0])
@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize(
    "shape",
    [
        "{disk: {center: [0.25, -0.53], radius: 0.83}}",
        "{polygon: [[-0.9, -0.4], [0.3, -0.6], [1.1, 0.2], [0, 0.7]]}",
        "{rectangle: {center: [0.1, 0.2], width: 1.1, height: 0.8}}",
    ],
    ids=["disk", "polygon", "rectangle"],
)
def test_patch_test_through_inclusions(shape: str, contact: str, support: float) -> None:
    """The core is held by the rock round it alone, on an interface that closes on itself."""
    solution = solve(INCLUSION.format(shape=shape, contact=contact, support=support))
    strain = -1e6 * (1 - 0.3**2 - 0.3 * 1.3) / 1e10
    metres = places((-1.9, -1.9), (1.9, 1.9))
    found = displacement_in(solution, metres, None)
    assert np.abs(found - (metres + 2.0) * strain).max() < PATCH_TEST[support] * 4.0 * abs(strain)
    assert (solution.outcome.points.state == STICK).all()


HOLED = """
title: A plate with a hole
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 4, height: 4}, holes: [{disk: {center: [0, 0], radius: 0.5}}]}
    material: {young: 1e10, poisson: 0.25, density: 2500}
supports:
  - {on: {body: rock, edge: hole0}, contact: {friction: 0.3, cohesion: 0}}
loads: [{body: rock, gravity: [0, -10]}]
numerics: {spacing: 0.2}
"""


def test_a_plate_hangs_on_a_pin() -> None:
    """Tractions on an arc act along many normals; their resultant is the weight all the same."""
    solution = solve(HOLED)
    sides = 180.0 * 0.5**2 * np.sin(np.deg2rad(1.0))  # area of the hole, a polygon of 360 sides
    (pin,) = reactions(solution)
    np.testing.assert_allclose(pin.force, [0.0, 25000.0 * (16.0 - sides)], rtol=1e-8, atol=1e-3)


def test_a_crack_that_starts_on_a_hole() -> None:
    """Also on the corner at which the hole's ring begins the crack stays where it is: its mirror image is equal."""
    found = []
    for x in (0.5, -0.5):
        solution = solve(
            HOLED,
            f"cracks.c={{path: {{points: [[{x}, 0], [{1.8 * x}, 0]]}}, tips: end, contact: none}}",
            "numerics.spacing=0.1",
            "supports=[{at: [-2, -2], displacement: {x: 0, y: 0}}, {at: [2, -2], displacement: {y: 0}}]",
            "loads=[{on: {body: rock, edge: top}, traction: [0, 1e6]},"
            " {on: {body: rock, edge: bottom}, traction: [0, -1e6]}]",
        )
        path = solution.cover.lattice.to_metres(solution.cover.cracks[0].points)
        np.testing.assert_allclose(path, [[x, 0.0], [1.8 * x, 0.0]], atol=1e-9)
        (tip,) = solution.tips
        found.append(tip.K[0])
        assert abs(tip.K[1]) < 1e-4 * tip.K[0]
    assert found[0] == pytest.approx(found[1], rel=1e-4)
    assert found[0] > 1.47e6 * np.sqrt(np.pi * 0.4)  # Bowie 1956, infinite plate; the finite one is higher


def test_two_foundations_on_one_edge_have_their_own_names() -> None:
    posts = (
        "supports=[{on: {body: block, edge: bottom, from: -2, to: -1}, contact: {friction: 0.5, cohesion: 0}},"
        " {on: {body: block, edge: bottom, from: 1, to: 2}, contact: {friction: 0.5, cohesion: 0}}]"
    )
    solution = solve(BLOCK, posts)
    forces = {item.where: item.force for item in reactions(solution)}
    assert list(forces) == ["block.bottom.0", "block.bottom.1"]
    np.testing.assert_allclose([force[1] for force in forces.values()], 200.0, rtol=1e-6)
