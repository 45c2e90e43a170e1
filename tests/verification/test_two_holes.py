"""Plate with two holes and two edge cracks (Bouchard, Bay, Chastel 2003) against a published extended FE program.

Path and K at each step of danassutula/XFEM_Fracture2D (MIT), K_II = 0 at the end of each increment of 0.7174 mm. The
scene is point symmetric; the stored K of its two cracks differ by 0.4 %, their paths by 0.02 mm: so good they are.
"""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.verification.solutions import table

UNIT = 1e6 / 1e3**0.5  # N/mm^1.5
PLATE = """
title: Plate with two holes and two edge cracks
source: "Bouchard, Bay, Chastel 2003, Computer Methods in Applied Mechanics and Engineering 192, 3887-3908"
units: {length: mm, stress: MPa}
plane: strain
bodies:
  plate:
    shape:
      rectangle: {center: [0, 0], width: 20, height: 10}
      holes:
        - disk: {center: [-7, 2], radius: 2}
        - disk: {center: [7, -2], radius: 2}
    material: {young: 98000, poisson: 0.3}
    strength: {tension: 1, cohesion: 100, friction_angle: 30, toughness: 1 MPa sqrt(m)}
cracks:
  left: {path: {points: [[-10, -2.15], [-9, -2.15]]}, contact: none, tips: end}
  right: {path: {points: [[10, 2.15], [9, 2.15]]}, contact: none, tips: end}
supports:
  - {on: {body: plate, edge: top}, displacement: {x: 0, y: 0.1}}
  - {on: {body: plate, edge: bottom}, displacement: {x: 0, y: -0.1}}
growth:
  steps: 3
  increment: 0.7174
  advance: all
  criterion: max_hoop_stress
numerics: {spacing: auto}
output: {figures: false, frames: none}
"""


@pytest.fixture(scope="module")
def steps(tmp_path_factory: pytest.TempPathFactory) -> list[StepResult]:
    path = tmp_path_factory.mktemp("two_holes") / "two_holes.yaml"
    path.write_text(PLATE, encoding="utf-8")
    return list(grow(load_case(path)))


@pytest.mark.parametrize("crack", [0, 1])
def test_the_path_round_the_hole(steps: list[StepResult], crack: int) -> None:
    """Measured over all 20 steps: 0.041 mm from the right path; from the left 0.034, at its end in the hole 0.063."""
    path = table("two_holes_path.csv")
    mine = path[path["crack"] == crack]
    line, found = shapely.LineString(np.column_stack([mine["x"], mine["y"]])), 1e3 * steps[-1].cracks[crack].points
    assert len(found) == 5
    assert shapely.distance(line, shapely.points(found)).max() < 0.05


@pytest.mark.parametrize("step", [0, 1, 2])
def test_K_of_the_first_steps(steps: list[StepResult], step: int) -> None:
    """Of both stored cracks the mean. The next two steps, beside the hole, are 1.5 and 1.9 % off."""
    K = table("two_holes_K.csv")
    published = [K[name][K["step"] == step].mean() for name in ("K_I", "K_II")]
    for tip in steps[step].tips:
        assert abs(tip.K_I / UNIT - published[0]) < 1e-2 * published[0]
        assert abs(tip.K_II / UNIT - published[1]) < 1e-2 * published[0]


def test_the_two_cracks_are_alike(steps: list[StepResult]) -> None:
    left, right = (crack.points for crack in steps[-1].cracks)
    np.testing.assert_allclose(left, -right, atol=1e-7)
