"""K where cells are halved round tips and kinks: after growth, on closed kinks, of small cracks in large plates.

On a uniform lattice of 1.5 mm K of the grown and young wings is 2.8 and 1.0 % off, that of closed kinks of two cells
90 kPa sqrt(m).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import MPA, plate, shipped, winged
from tests.verification.solutions import rows


def solved(folder: Path, scene: dict[str, Any], spacing: float, **refine: int) -> StepResult:
    scene["numerics"] = {**scene["numerics"], "spacing": spacing, "refine": refine}
    file = folder / "scene.yaml"
    file.write_text(yaml.safe_dump(scene))
    return next(grow(load_case(file, ["output.frames=none", "output.figures=false", "output.report=false"])))


@pytest.mark.parametrize("functions", ["patch", "gathered"])
@pytest.mark.parametrize(("name", "wanted"), [("grown30", 0.002), ("young30", 0.002)])
def test_K_of_wings(tmp_path: Path, name: str, wanted: float, functions: str) -> None:
    """By finite elements, good to 0.05 % of K_I; with at most 6,000 unknowns."""
    scene = shipped("compression30")
    scene["numerics"]["tip_functions"] = functions
    scene["cracks"]["flaw"]["path"] = {
        "points": [[float(row["x_mm"]), float(row["y_mm"])] for row in rows(f"{name}_path.csv")]
    }
    truth = {row["tip"]: row for row in rows("grown_K.csv") if row["scene"] == name}
    step = solved(tmp_path, scene, 3.0, tips=3, kinks=5)
    assert step.n_dofs < 6000
    for tip in step.tips:
        K_I, K_II = (MPA * float(truth[tip.tip][f"{K}_MPa_sqrtm"]) for K in ("K_I", "K_II"))
        assert abs(tip.K_I - K_I) < wanted * K_I
        assert abs(tip.K_II - K_II) < wanted * K_I


@pytest.mark.parametrize(("angle", "axial", "lateral", "friction"), [(0.0, -10.0, 0.0, 0.0), (45.0, 10.0, 2.0, 0.3)])
@pytest.mark.parametrize("spacing", [200.0, 110.0])
def test_K_of_a_crack_of_2_mm_in_a_plate_of_1_m(
    tmp_path: Path, angle: float, axial: float, lateral: float, friction: float, spacing: float
) -> None:
    """In an infinite plate; open under tension, closed under compression (MPa)."""
    a = np.deg2rad(angle)
    normal = -(axial * np.cos(a) ** 2 + lateral * np.sin(a) ** 2)
    shear = (axial - lateral) * np.sin(a) * np.cos(a)
    root = MPA * np.sqrt(np.pi * 1e-3)
    K_I, K_II = (root * normal, 0.0) if normal > 0.0 else (0.0, root * (shear + friction * normal))
    scene = plate(winged(1.0, angle, 1.0, 0.0)[1:3], 1000.0, axial, lateral, friction)
    step = solved(tmp_path, scene, spacing, tips=9 if spacing > 150.0 else 8)
    assert step.n_dofs < 8000
    for tip in step.tips:
        assert abs(tip.K_I - K_I) < 1e-3 * max(K_I, K_II)
        assert abs(abs(tip.K_II) - K_II) < 1e-3 * max(K_I, K_II)


def test_K_of_a_crack_of_1_um_beside_one_of_2_mm_in_a_plate_of_100_mm(tmp_path: Path) -> None:
    """In an infinite plate by Gauss-Chebyshev quadrature of the singular integral equations, with 400 nodes a crack.

    Cells were halved nine times at most, and all those of the plate had to be small: 1.4 million. Half a per cent of
    the tip's K leaves room for the edges of the plate, 0.07 %.
    """
    cracks = {"large": [[-1.0, 0.0], [1.0, 0.0]], "small": [[1.0025669873, 0.00075], [1.0034330127, 0.00125]]}
    scene = plate(cracks["large"], 100.0, -1.0, 0.0, 0.0)
    scene["cracks"] = {name: {"path": {"points": path}, "contact": "none"} for name, path in cracks.items()}
    scene["numerics"] = {"accuracy": "standard"}
    file = tmp_path / "scene.yaml"
    file.write_text(yaml.safe_dump(scene))
    step = next(grow(load_case(file, ["output.frames=none", "output.figures=false", "output.report=false"])))
    assert step.n_dofs < 60_000
    exact = [(56050.4, -0.3), (56320.4, -115.2), (14644.3, 2565.0), (13458.6, 2672.2)]
    for tip, (K_I, K_II) in zip(step.tips, exact, strict=True):
        assert np.hypot(tip.K_I - K_I, tip.K_II - K_II) < 5e-3 * np.hypot(K_I, K_II)
