"""Presets where cells are halved by themselves: K after growth, of small cracks in large plates, and paths.

A lattice of one size, 1.5 mm, is 2.8 % off on the grown wings. Exact values are those of an infinite plate; the plates
here are a hundred flaws wide.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.arrays import Floats
from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.scenes import MPA, plate, winged
from tests.verification.solutions import rows

QUIET = ["output.frames=none", "output.figures=false", "output.report=false"]
WIDE = 200.0
WITHIN = {"draft": 0.01, "standard": 0.004, "fine": 0.002}
"""Of the larger component of K: what each name misses at most on these scenes."""


def steps(folder: Path, scene: dict[str, Any], accuracy: str) -> list[StepResult]:
    scene["numerics"] = {"accuracy": accuracy}
    file = folder / "scene.yaml"
    file.write_text(yaml.safe_dump(scene))
    return list(grow(load_case(file, QUIET)))


def off(step: StepResult, K_I: float, K_II: float) -> float:
    """The largest error at both tips of a scene with point symmetry, over the larger component."""
    errors = [(abs(tip.K_I - K_I), abs(abs(tip.K_II) - abs(K_II))) for tip in step.tips]
    return float(np.max(errors)) / max(abs(K_I), abs(K_II))


@pytest.mark.parametrize("accuracy", ["standard", "fine"])
@pytest.mark.parametrize("row", rows("wing_K_contact.csv")[1::8], ids=lambda row: "-".join(list(row.values())[:4]))
def test_K_of_wings_in_a_wide_plate(tmp_path: Path, row: dict[str, str], accuracy: str) -> None:
    angle, wing = float(row["flaw_angle_from_x_deg"]), float(row["l_over_a"])
    turn = 70.5288 if row["wing"] == "hoop" else 90.0 - angle
    scene = plate(winged(1.0, angle, wing, turn), WIDE, 1.0, float(row["lateral_over_axial"]), float(row["mu"]))
    (step,) = steps(tmp_path, scene, accuracy)
    assert off(step, *(MPA * np.sqrt(np.pi * 1e-3) * float(row[K]) for K in ("K_I", "K_II"))) < WITHIN[accuracy]


def growing(scene: dict[str, Any], n: int) -> dict[str, Any]:
    """The scene with tips that grow by a fifth of a millimetre where K_II is zero, all of them in each step."""
    scene["bodies"]["rock"]["strength"] = {"tension": 1e-4, "cohesion": 1, "friction_angle": 30}
    scene["loading"] = "critical"
    scene["growth"] = {
        "steps": n,
        "increment": 0.2,
        "advance": "all",
        "criterion": "max_hoop_stress",
        "direction": "implicit",
        "tip_stress": {"radius": 0.05},
    }
    return scene


def vertices(name: str, n: int) -> Floats:
    """The first vertices (n, 2) mm that a tip makes; the flaw's half length is 1 mm."""
    return np.array([(float(row["x"]), float(row["y"])) for row in rows(name)])[:n]


def test_path_of_a_wing(tmp_path: Path) -> None:
    """Step by step within a hundredth of the flaw's half length of the path with K_II = 0."""
    wanted = vertices("wing_paths_infinite_plate.csv", 3)
    scene = growing(plate(winged(1.0, 30.0, 1.0, 0.0)[1:3], WIDE, 1.0, 0.0, 0.0), len(wanted))
    path = 1e3 * steps(tmp_path, scene, "standard")[-1].cracks[0].points
    assert np.hypot(*(path[-len(wanted) :] - wanted).T).max() < 0.01


def test_paths_of_cracks_that_pass_each_other(tmp_path: Path) -> None:
    """They turn away from each other, then towards each other."""
    wanted = vertices("passing_cracks_paths.csv", 4)
    scene = plate([[-4.5, -0.25], [-0.5, -0.25]], WIDE, 0.0, 0.0, 0.0)
    free = {"friction": 0, "cohesion": 0}
    scene["cracks"] = {
        "lower": {"path": {"points": [[-4.5, -0.25], [-0.5, -0.25]]}, "tips": "end", "contact": dict(free)},
        "upper": {"path": {"points": [[0.5, 0.25], [4.5, 0.25]]}, "tips": "start", "contact": dict(free)},
    }
    scene["loads"] = [
        {"on": {"body": "rock", "edge": edge}, "traction": [0, pull]} for edge, pull in (("top", 1), ("bottom", -1))
    ]
    last = steps(tmp_path, growing(scene, len(wanted)), "standard")[-1]
    lower, upper = (1e3 * crack.points for crack in last.cracks)
    assert np.hypot(*(lower[-len(wanted) :] - wanted).T).max() < 0.001
    np.testing.assert_allclose(upper[: len(wanted)][::-1], -lower[-len(wanted) :], atol=1e-4)


def test_a_crack_given_in_two_pieces_has_the_K_of_one(tmp_path: Path) -> None:
    found = []
    for parts in ([(-6.0, 6.0)], [(-6.0, 1.3), (1.3, 6.0)]):
        scene = plate([[0.0, 0.0], [1.0, 0.0]], 100.0, -10.0, 0.0, 0.0)
        scene["cracks"] = {
            f"part{number}": {
                "path": {"points": [[start, 0.0], [end, 0.0]]},
                "tips": {(-6.0, 6.0): "both", (-6.0, 1.3): "start", (1.3, 6.0): "end"}[start, end],
                "contact": {"friction": 0, "cohesion": 0},
            }
            for number, (start, end) in enumerate(parts)
        }
        found.append([tip.K_I for tip in steps(tmp_path, scene, "standard")[0].tips])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-3)
