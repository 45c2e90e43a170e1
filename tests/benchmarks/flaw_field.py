"""A plate with many random flaws: the scene of cases/random_flaws.yaml in a specimen that grows with their number."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml

from crackgrow.case import load_case
from crackgrow.case.model import Case

SIDE_OF_FIFTY = 150.0  # mm
APART = 4.0  # mm, between flaws
FROM_SIDES = 8.0  # mm
SEED = 2017


def field_side(n: int) -> float:
    """Side (mm) of the plate that holds n flaws as densely as fifty lie in the case's, a whole number."""
    return float(round(SIDE_OF_FIFTY * np.sqrt(n / 50.0)))


def field_flaws(n: int) -> list[dict[str, Any]]:
    """Paths of n flaws of 10 to 16 mm, by the recipe of cases/random_flaws.yaml."""
    rng, half_side = np.random.default_rng(SEED), field_side(n) / 2.0
    paths: list[dict[str, Any]] = []
    lines: list[shapely.LineString] = []
    while len(paths) < n:
        middle = rng.uniform(-half_side, half_side, 2).round(1)
        length, angle = round(rng.uniform(10.0, 16.0), 1), float(round(rng.uniform(0.0, 180.0)))
        half = 0.5 * length * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
        line = shapely.LineString([middle - half, middle + half])
        inside = np.abs(shapely.get_coordinates(line)).max() <= half_side - FROM_SIDES
        if inside and all(line.distance(other) >= APART for other in lines):
            lines.append(line)
            paths.append({"center": middle.tolist(), "length": length, "angle": angle})
    return paths


def field_case(n: int, steps: int, **numerics: Any) -> Case:
    """A plate with n flaws that grow, the most critical tip first, at the loads at which they just do."""
    side = field_side(n)
    half = side / 2.0
    document = {
        "title": f"{n} random flaws under uniaxial compression",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": side, "height": side}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 2, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": {
            f"f{k + 1:03d}": {"path": path, "contact": {"friction": 0.3, "cohesion": 0}}
            for k, path in enumerate(field_flaws(n))
        },
        "supports": [
            {"at": [-half, -half], "displacement": {"y": 0}},
            {"at": [half, -half], "displacement": {"y": 0}},
            {"at": [0, -half], "displacement": {"x": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0, -10]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, 10]},
        ],
        "loading": "critical",
        "growth": {
            "steps": steps,
            "increment": 4,
            "advance": "most_critical",
            "criterion": "directional_strength",
            "tip_stress": {"radius": 2},
        },
        "numerics": numerics or {"accuracy": "draft"},
        "output": {"frames": "none", "figures": False},
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "field.yaml"
        file.write_text(yaml.safe_dump(document))
        return load_case(file)
