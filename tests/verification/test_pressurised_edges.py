"""Pressure on edges: a thick ring (Lame), and water against a block on a floor with friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import crackgrow
from tests.whole_run import whole_run

RING = """
title: A thick ring with pressure inside and outside
source: "Lame 1852; Timoshenko, Goodier 1970, Theory of Elasticity, section 28"
units: {length: mm, stress: MPa}
plane: strain
bodies:
  rock:
    shape: {disk: {center: [0, 0], radius: 30}, holes: [{disk: {center: [0, 0], radius: 10}}]}
    material: {young: 10000, poisson: 0.25}
supports: minimal
loads:
  - {on: {edge: hole0}, pressure: INSIDE}
  - {on: {edge: arc}, pressure: OUTSIDE}
numerics: {spacing: auto}
output: {figures: false, frames: none}
"""


def solved(text: str, folder: Path) -> crackgrow.Solution:
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return crackgrow.solve(crackgrow.load_case(path))


@pytest.mark.parametrize(("inside", "outside"), [(10.0, 0.0), (0.0, 5.0), (7.0, 7.0)])
def test_stress_in_a_thick_ring(tmp_path: Path, inside: float, outside: float) -> None:
    """sigma_r, sigma_theta = A -+ B / r^2; measured: within 0.5 % of the pressure at walls, where cells are small."""
    solution = solved(RING.replace("INSIDE", str(inside)).replace("OUTSIDE", str(outside)), tmp_path)
    a, b = 0.01, 0.03
    A = 1e6 * (inside * a**2 - outside * b**2) / (b**2 - a**2)
    B = 1e6 * (inside - outside) * (a * b) ** 2 / (b**2 - a**2)
    for angle in np.linspace(0.1, 2.0 * np.pi, 12):
        c, s = np.cos(angle), np.sin(angle)
        for r in (1.002 * a, 0.015, 0.998 * b):
            xx, yy, xy = solution.stress_at([[r * c, r * s]])[0]
            radial = c * c * xx + s * s * yy + 2.0 * c * s * xy
            assert abs(radial - (A - B / r**2)) < 1e4 * max(inside, outside)
            assert abs(xx + yy - 2.0 * A) < 1e4 * max(inside, outside)


TANK = """
title: A block on a frictional floor below water
units: {length: m, stress: MPa}
plane: strain
bodies:
  rock:
    shape: {rectangle: {center: [0, 1], width: 2, height: 2}}
    material: {young: 1000, poisson: 0.25, density: 2000 kg/m^3}
supports:
  - {on: {edge: bottom}, contact: {friction: 0.5, cohesion: 0}}
loads:
  - {gravity: [0, -10 m/s^2]}
  - {on: {edge: left}, pressure: "0.01*(WATER - y)", name: water}
loading: strength_reduction
numerics: {spacing: 0.25}
output: {figures: false, frames: none}
"""


@pytest.mark.parametrize("water", [2.0, 2.5])
def test_water_against_a_block_pushes_it_by_its_resultant(tmp_path: Path, water: float) -> None:
    """Factor of safety: mu W / P, with W = 80 kN/m and P = gamma (2 water - 2), gamma = 10 kN/m^3."""
    path = tmp_path / "tank.yaml"
    path.write_text(TANK.replace("WATER", str(water)), encoding="utf-8")
    _, end = whole_run(crackgrow.load_case(path))
    assert end.safety is not None
    assert end.safety.factor == pytest.approx(0.5 * 80.0 / (10.0 * (2.0 * water - 2.0)), rel=1e-3)
    assert "slides" in end.safety.mechanism
