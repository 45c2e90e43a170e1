"""A crack from an edge is the same from each of the four sides, wherever the lattice lies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.run import grow

HALF, DEPTH = 15, 6  # mm
LEFT_RIGHT_BOTTOM_TOP = {"left": (-1, 0), "right": (1, 0), "bottom": (0, -1), "top": (0, 1)}


def edge_crack(side: str, spacing: float) -> dict[str, Any]:
    """A square plate, pulled across a crack from the middle of one side."""
    x, y = LEFT_RIGHT_BOTTOM_TOP[side]
    pulled = {"bottom": [0, -1], "top": [0, 1]} if x else {"left": [-1, 0], "right": [1, 0]}
    corners = [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF)]
    return {
        "title": "edge crack",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": 2 * HALF, "height": 2 * HALF}},
                "material": {"young": 10000, "poisson": 0.25},
            }
        },
        "cracks": {
            "notch": {
                "path": {"points": [[HALF * x, HALF * y], [(HALF - DEPTH) * x, (HALF - DEPTH) * y]]},
                "tips": "end",
                "contact": "none",
            }
        },
        "supports": [
            {"at": list(corner), "displacement": {axis: 0}}
            for corner, axis in zip(corners, ("y", "y", "x"), strict=True)
        ],
        "loads": [{"on": {"body": "rock", "edge": edge}, "traction": pull} for edge, pull in pulled.items()],
        "numerics": {"spacing": spacing, "quadrature": 8},  # polygons fall into other triangles on other sides
        "output": {"frames": "none", "figures": False},
    }


@pytest.mark.parametrize("spacing", [1.2, 1.3, 1.35, 1.4, 1.5])
def test_an_edge_crack_is_the_same_from_all_four_sides(tmp_path: Path, spacing: float) -> None:
    """At 1.35 and 1.4 mm the lattice ends where the jump of the tip functions leads on beyond the edge."""
    K = []
    for side in LEFT_RIGHT_BOTTOM_TOP:
        file = tmp_path / f"{side}.yaml"
        file.write_text(yaml.safe_dump(edge_crack(side, spacing)))
        (tip,) = next(grow(load_case(file))).tips
        K.append((tip.K_I, tip.K_II))
    K_I, K_II = np.array(K).T
    np.testing.assert_allclose(K_I, K_I[0], rtol=1e-6)
    np.testing.assert_allclose(K_II, 0.0, atol=1e-6 * K_I[0])
