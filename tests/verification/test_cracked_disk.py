"""Cracked Brazilian disk: K_I and K_II against the series, at automatic cells and where an accuracy is asked for.

Point forces P at both ends of a diameter, a central open crack of half length a at an angle to it:
K = N P / (pi R) sqrt(pi a). N is of the series of Atkinson, Smelser, Sanchez (1982), solved by a method of its own to
1e-10 (references/brazilian_disk_N.csv).
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import crackgrow

REFERENCE = Path(__file__).parent / "references" / "brazilian_disk_N.csv"
RADIUS, FORCE = 0.05, 1000.0
DISK = """
title: Brazilian disk with a crack through its centre
source: "Atkinson, Smelser, Sanchez 1982, International Journal of Fracture 18, 279-291"
units: {length: mm, stress: MPa}
plane: strain
bodies: {rock: {shape: {disk: {center: [0, 0], radius: 50}}, material: {young: 10000, poisson: 0.25}}}
cracks: {flaw: {path: {center: [0, 0], length: LENGTH, angle: ANGLE}, contact: none}}
supports: minimal
loads:
  - {at: [0, 50], force: [0 N/m, -1000 N/m]}
  - {at: [0, -50], force: [0 N/m, 1000 N/m]}
numerics: NUMERICS
output: {figures: false, frames: none}
"""


def factors(share: float, angle: int) -> np.ndarray:
    """N_I and N_II of a crack of half length `share` times R."""
    with REFERENCE.open() as file:
        for row in csv.DictReader(file):
            if (float(row["a_over_R"]), row["angle_from_load_deg"]) == (share, str(angle)):
                return np.array([float(row["N_I"]), float(row["N_II"])])
    raise KeyError((share, angle))


def computed(share: float, angle: int, folder: Path, numerics: str = "{spacing: auto}") -> np.ndarray:
    """N_I and abs(N_II) (2, 2) of both tips."""
    text = DISK.replace("LENGTH", str(100.0 * share)).replace("ANGLE", str(90 - angle)).replace("NUMERICS", numerics)
    path = folder / "disk.yaml"
    path.write_text(text, encoding="utf-8")
    tips = crackgrow.solve(crackgrow.load_case(path)).tips[["K_I", "K_II"]].to_numpy()
    unit = FORCE / (np.pi * RADIUS) * np.sqrt(np.pi * share * RADIUS)
    return np.asarray(tips / unit * [1.0, -1.0] if angle else tips / unit)


@pytest.mark.parametrize("angle", [0, 5, 10, 15, 20, 25])
def test_K_of_a_crack_at_an_angle_to_the_load(angle: int, tmp_path: Path) -> None:
    """Measured: 0.17 % of K at worst."""
    exact = factors(0.3, angle)
    found = computed(0.3, angle, tmp_path)
    assert np.abs(found - exact).max() < 3e-3 * np.hypot(*exact)


@pytest.mark.parametrize("angle", [0, 5, 10, 15, 20, 25])
def test_K_of_a_crack_over_half_of_the_disk(angle: int, tmp_path: Path) -> None:
    """Automatic cells alone are off by 0.34 % at worst (5 degrees); what is asked for is got (measured: 0.07 %)."""
    exact = factors(0.5, angle)
    found = computed(0.5, angle, tmp_path, "{accuracy: 0.3 %}")
    assert np.abs(found - exact).max() < 3e-3 * np.hypot(*exact)
