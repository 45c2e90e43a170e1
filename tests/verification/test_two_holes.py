"""Plate with two holes and two edge cracks (Bouchard, Bay, Chastel 2003) against a published extended FE program.

Path and K at each step of danassutula/XFEM_Fracture2D (MIT), K_II = 0 at the end of each increment of 0.7174 mm. The
scene is point symmetric; the stored K of its two cracks differ by 0.4 %, their paths by 0.02 mm: so good they are.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from crackgrow.arrays import Floats
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


def from_stored_path(step: StepResult, crack: int) -> Floats:
    """Distances (n,) mm of a crack's vertices from the stored path, from its mouth on."""
    path = table("two_holes_path.csv")
    mine = path[path["crack"] == crack]
    line, found = shapely.LineString(np.column_stack([mine["x"], mine["y"]])), 1e3 * step.cracks[crack].points
    return np.asarray(shapely.distance(line, shapely.points(found[:: 1 if crack == 0 else -1])))


@pytest.mark.parametrize("crack", [0, 1])
def test_the_path_round_the_hole(steps: list[StepResult], crack: int) -> None:
    found = from_stored_path(steps[-1], crack)
    assert len(found) == 5
    assert found.max() < 0.05


@pytest.mark.slow
def test_the_path_up_to_the_other_hole(tmp_path: Path) -> None:
    """Within 0.05 mm, and at the last step whose K is stored within 0.07 mm: 1 mm from the hole, where K falls fast.

    There the stored cracks are 0.02 mm apart, and have K_II / K_I of 0.005 and 0.011 left at the ends of the last two
    steps, by which directions are off by 0.6 and 1.3 degrees. Here it is below 1e-3, and `fine` moves the last vertex
    by 0.003 mm.
    """
    file = tmp_path / "two_holes.yaml"
    file.write_text(PLATE.replace("steps: 3", "steps: 20"), encoding="utf-8")
    *_, last = grow(load_case(file))
    for crack in (0, 1):
        found = from_stored_path(last, crack)
        assert len(found) == 22
        assert found[:-1].max() < 0.05
        assert found[-1] < 0.07
    assert all(abs(tip.K_II) < 1e-3 * tip.K_I for tip in last.tips)


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
