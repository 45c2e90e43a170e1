"""What contact holds: pieces of rock by friction alone, faces that cohere or stick, as if they were not there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import OPEN, STICK
from crackgrow.errors import FreePieceError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.results.log import told_line
from crackgrow.results.summary import K_error
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.evaluation import evaluated
from crackgrow.run.increments import increment, unloaded
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case, specimen

HELD_BY_FRICTION = [
    [(-2.47, 6.123), (-2.616, 9.325), (-2.863, 14.319), (-14.167, 23.901), (-14.378, 28.896), (-13.608, 30.0)],
    [(3.057, 5.426), (7.708, 7.262), (9.85, 11.78), (9.446, 16.763), (-0.943, 24.96), (-1.141, 30.0)],
    [
        (-11.323, -15.005), (-6.689, -12.67), (-7.447, -7.728), (-8.177, -2.782), (-6.742, -0.542), (-2.47, 6.123),
        (-0.034, 9.925), (-0.415, 14.91), (-3.455, 18.88), (-7.842, 21.279),
    ],
    [(-3.539, -30.0), (-2.954, -28.649), (-3.425, -23.671), (-12.66, -19.495), (-13.114, -17.332)],
    [
        (-16.934, -30.0), (-17.593, -28.181), (-17.615, -23.181), (-13.114, -17.332), (-11.323, -15.005),
        (-8.455, -11.278), (-9.14, -6.326), (-10.307, -1.464), (-6.742, -0.542),
    ],
]  # fmt: skip


"""mm: cracks that cut three pieces out of a plate; the lowest would slide down and out."""


TIPS = ["none", "start", "end", "none", "none"]


"""Of these."""


def pressed(cracks: list[Any], tips: list[str], friction: list[float], **more: Any) -> Case:
    """A plate of 40 x 60 mm with cracks (mm), pressed along y."""
    given = {
        f"c{k}": {"path": {"points": [list(p) for p in path]}, "tips": end, "contact": {"friction": mu, "cohesion": 0}}
        for k, (path, end, mu) in enumerate(zip(cracks, tips, friction, strict=True), 1)
    }
    scene = specimen(given, (40.0, 60.0), -4.0, numerics={"spacing": 3}, **more)
    scene["bodies"]["rock"]["strength"]["tension"] = 0.05
    return read_case(yaml.safe_dump(scene), "pieces", "pieces")


@pytest.mark.parametrize("friction", [0.2, 0.35, 0.5, 0.6, 1.0, 1.5])
def test_a_piece_slides_out_where_friction_does_not_hold_it(friction: float) -> None:
    case = pressed(HELD_BY_FRICTION, TIPS, [friction] * 5)
    if friction < 1.0:
        with pytest.raises(FreePieceError, match="is free to move: contact does not hold it"):
            next(grow(case))
    else:
        assert next(grow(case)).residual < 1e-10


CAPPED = """
title: A cap on a block that rests on a base
units: {length: mm, stress: MPa}
plane: strain
bodies:
  base: {shape: {rectangle: {center: [0, -10], width: 60, height: 20}}, material: {young: 10000, poisson: 0.2}}
  block: {shape: {rectangle: {center: [0, 10], width: 40, height: 20}}, material: {young: 10000, poisson: 0.2}}
  cap: {shape: {rectangle: {center: [0, 25], width: 40, height: 10}}, material: {young: 10000, poisson: 0.2}}
interfaces:
  - {between: [base, block], contact: {friction: 0.5, cohesion: 0}}
  - {between: [block, cap], contact: bonded}
supports:
  - {on: {body: base, edge: bottom}, displacement: {x: 0, y: 0}}
loads:
  - {on: {body: cap, edge: top}, traction: [SHEAR, -3]}
numerics: {spacing: 5}
output: {figures: false, frames: none}
"""


def test_a_body_bonded_to_one_that_contact_holds_is_held_as_long_as_friction_holds_that() -> None:
    """The joint carries the load on the cap, and all of it stays where it is."""
    held, sliding = (read_case(CAPPED.replace("SHEAR", shear), "capped", "capped") for shear in ("0.5", "2"))
    result = next(grow(held))
    joint = next(face for face in result.faces if face.crack == "base/block")
    normal, shear = (np.trapezoid(p, joint.s) for p in (joint.normal_traction, joint.tangential_traction))
    assert result.residual < 1e-10
    assert normal == pytest.approx(-3e6 * 0.04, rel=1e-9)
    assert abs(shear) == pytest.approx(0.5e6 * 0.04, rel=1e-9)
    with pytest.raises(FreePieceError, match="free to move: contact does not hold it, it slides along"):
        next(grow(sliding))


CASE = "compression30"


LENGTH = 10.0  # mm


def plate(path: str, stress: np.ndarray, *settings: str, tips: str = "both", **law: object) -> Configuration:
    """The scene's plate with one crack under a uniform stress (2, 2) MPa on all sides."""
    xx, xy, yy = float(stress[0, 0]), float(stress[0, 1]), float(stress[1, 1])
    sides = {"right": (xx, xy), "left": (-xx, -xy), "top": (xy, yy), "bottom": (-xy, -yy)}
    loads = [f"{{on: {{body: rock, edge: {edge}}}, traction: [{x!r}, {y!r}]}}" for edge, (x, y) in sides.items()]
    faces = ", ".join(f"{key}: {value}" for key, value in {"friction": 0.3, "cohesion": 20, **law}.items())
    changes = (f"cracks.flaw.path={path}", f"cracks.flaw.tips={tips}", f"cracks.flaw.contact={{{faces}}}")
    case = shipped_case(CASE, [*changes, f"loads=[{', '.join(loads)}]", "numerics.spacing=1.5", *settings])
    growing = tuple(map(GrowingCrack.given, case.cracks))
    return assemble(make_scene(case), growing)


def on_plane(angle: float, pressure: float, shear: float) -> np.ndarray:
    """Stress (2, 2) of a pressure all round and of a pure shear along the plane at `angle` degrees."""
    a = np.deg2rad(angle)
    tangent, normal = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    return shear * (np.outer(normal, tangent) + np.outer(tangent, normal)) - pressure * np.eye(2)


def edge_crack(angle: float, end: str) -> str:
    """From the middle of the right side inwards; the tip is the crack's start or end."""
    a = np.deg2rad(angle)
    tip, mouth = [15.5 - LENGTH * np.cos(a), -LENGTH * np.sin(a)], [15.5, 0.0]
    points = [tip, mouth] if end == "start" else [mouth, tip]
    return f"{{points: {[[float(x) for x in point] for point in points]}}}"


def inside(angle: float) -> str:
    """In the middle of the plate."""
    return f"{{center: [0, 0], length: {LENGTH}, angle: {angle}}}"


SHEAR = 8.0  # MPa, less than the cohesion


OPENING = SHEAR * 1e6 * np.sqrt(np.pi * LENGTH / 2e3)  # K_II (Pa sqrt(m)) of a crack that carries no shear


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("pressure", [0.0, 0.05, 0.5, 2.0])
@pytest.mark.parametrize(("angle", "tips"), [(30.0, "start"), (60.0, "start"), (20.0, "both"), (45.0, "both")])
def test_a_bond_that_holds_leaves_the_uniform_stress(angle: float, tips: str, pressure: float, sense: float) -> None:
    """Edge cracks, which shear would open without the bond, and inner ones. They stay together at no pressure too."""
    path = inside(angle) if tips == "both" else edge_crack(angle, tips)
    scene = plate(path, on_plane(angle, pressure, sense * SHEAR), "numerics.spacing=2", tips=tips)
    solved = evaluated(increment(scene, unloaded(scene), 1.0))
    outcome = solved.outcome
    assert set(outcome.points.state.tolist()) == {STICK}
    assert not outcome.memory.broken.any()
    np.testing.assert_allclose(outcome.points.tangential, sense * SHEAR * 1e6, rtol=1e-3)  # patch test: 1e-4
    np.testing.assert_allclose(outcome.points.normal, -pressure * 1e6, atol=1e-3 * SHEAR * 1e6)
    size = np.abs(outcome.u).max()
    assert max(np.abs(outcome.points.slip).max(), np.abs(outcome.points.opening).max()) < 1e-6 * size
    assert max(np.abs(tip.K).max() for tip in solved.tips) < 1e-4 * OPENING


def test_a_bond_does_not_hold_faces_that_are_pulled_apart() -> None:
    """By a tension far below the shear: they open, and lose all of it."""
    scene = plate(inside(20.0), on_plane(20.0, -1.0, SHEAR), "numerics.spacing=2")
    solved = evaluated(increment(scene, unloaded(scene), 1.0))
    assert set(solved.outcome.points.state.tolist()) == {OPEN}
    assert solved.outcome.memory.broken.all()
    assert abs(solved.tips[1].K[1]) == pytest.approx(OPENING, rel=0.1)  # a plate of three crack lengths


NETWORK = """
title: zigzag joints that cross in pressed rock
units: {length: mm, stress: MPa}
plane: strain
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 100, height: 100}}, material: {young: 30 GPa, poisson: 0.25}}
cracks:
  a: {path: {points: [[-25, -5], [-18, 0], [-11, -5], [-4, 0], [3, -5], [10, 0], [17, -5], [24, 0]]}, contact: LAW}
  b: {path: {points: [[-22, 8], [-15, 3], [-8, 8], [-1, 3], [6, 8], [13, 3], [20, 8], [27, 3]]}, contact: LAW}
  c: {path: {points: [[0, -20], [3, 0.5], [-2, 25]]}, contact: LAW}
supports: minimal
loads:
  - {on: {edge: top}, traction: [0, -20]}
  - {on: {edge: bottom}, traction: [0, 20]}
  - {on: {edge: left}, traction: [5, 0]}
  - {on: {edge: right}, traction: [-5, 0]}
numerics: {accuracy: draft}
output: {frames: none, figures: false}
"""


@pytest.mark.parametrize(("friction", "sticks"), [(5.0, True), (0.2, False)])
def test_a_kinked_network_that_sticks_is_told_to(friction: float, sticks: bool) -> None:
    """Uniform stress goes through it; what cells leave is 31 kPa sqrt(m), and the bounds of that were 6300 % of it."""
    case = read_case(NETWORK.replace("LAW", f"{{friction: {friction}, cohesion: 0}}"), "network", "network")
    step = next(grow(case))
    assert [tip.sticks for tip in step.tips] == [sticks] * 6
    assert np.isnan(K_error(step)) == sticks
    assert (" sticks, cracks " in told_line(step, case, 0.0)) == sticks
    assert ("K_I" in told_line(step, case, 0.0)) != sticks


def test_a_crack_that_sticks_after_it_has_slipped_has_its_K() -> None:
    settings = ["loading={history: [1, 0.9]}", "output.frames=none", "output.figures=false"]
    slipped, back = grow(shipped_case("cyclic_friction", settings))
    assert (back.contact.state == STICK).all()
    assert not any(tip.sticks for tip in (*slipped.tips, *back.tips))
    assert np.isfinite(K_error(back))
