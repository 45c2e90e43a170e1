"""Cracks whose faces cohere: under uniform stress, what holds is the exact solution, with the displacement linear."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.contact.coulomb import OPEN, STICK
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.increments import increment, unloaded
from crackgrow.run.judging import judged
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case
from tests.solving import at_once

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


@pytest.mark.parametrize("spacing", [1.5, 1.0])
@pytest.mark.parametrize("end", ["start", "end"])
@pytest.mark.parametrize("angle", [20.0, 45.0, 75.0])
def test_the_mouth_of_an_edge_crack_sticks_as_the_rest_does(angle: float, end: str, spacing: float) -> None:
    """Sheared beyond friction, pressed hard enough to be closed: cohesion and peak friction hold it everywhere."""
    stress = on_plane(angle, pressure=30.0, shear=25.0)
    settings = (f"numerics.spacing={spacing}",)
    scene = plate(edge_crack(angle, end), stress, *settings, tips=end, friction=0.6, residual_friction=0.2)
    outcome = at_once(scene, 1.0)
    assert set(outcome.points.state.tolist()) == {STICK}
    assert not outcome.memory.broken.any()
    np.testing.assert_allclose(np.abs(outcome.points.tangential), 25e6, rtol=1e-3)


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
    solved = judged(increment(scene, unloaded(scene), 1.0))
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
    solved = judged(increment(scene, unloaded(scene), 1.0))
    assert set(solved.outcome.points.state.tolist()) == {OPEN}
    assert solved.outcome.memory.broken.all()
    assert abs(solved.tips[1].K[1]) == pytest.approx(OPENING, rel=0.1)  # a plate of three crack lengths


@pytest.mark.parametrize(("angle", "dilation"), [(35.0, 25.0), (55.0, 15.0)])
def test_faces_that_merely_stick_do_not_dilate(angle: float, dilation: float) -> None:
    """Friction alone holds them, at every load: their slip is round-off, and so is the opening that it asks for."""
    law = {"friction": 0.6, "cohesion": 0, "dilation_angle": dilation}
    scene = plate(inside(angle), on_plane(angle, pressure=20.0, shear=10.0), "numerics.spacing=2", **law)
    for factor in np.linspace(0.1, 3.0, 60).tolist():
        outcome = at_once(scene, factor)
        assert set(outcome.points.state.tolist()) == {STICK}
        assert np.abs(outcome.points.dilation).max() < 1e-12 * np.abs(outcome.u).max()
        np.testing.assert_allclose(np.abs(outcome.points.tangential), factor * 10e6, rtol=1e-3)
