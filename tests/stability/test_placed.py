"""What must not change where a case is placed otherwise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from crackgrow.case import load_case
from crackgrow.case.model import Case, EdgeTraction
from tests.stability.placed import mirrored, moved, placed, scaled, turned
from tests.stability.solved import Solved, everything, overall, solved

ROOT = Path(__file__).parents[2]
CASES = ROOT / "cases"


@pytest.fixture(scope="module")
def flaw() -> Solved:
    return solved(coarse())


def coarse() -> Case:
    return load_case(CASES / "compression30.yaml", ["numerics.spacing=3", "growth.tip_stress.radius=2"])


@pytest.mark.parametrize("name", ["compression30", "block_rigid", "interface_friction01", "junction_static"])
@pytest.mark.parametrize(
    "placement", [turned(90.0), turned(180.0), mirrored(), moved(3.0, -2.0)], ids=["90", "180", "mirror", "moved"]
)
def test_placed_scene_is_the_same_scene(name: str, placement: object, flaw: Solved) -> None:
    case = coarse() if name == "compression30" else load_case(CASES / f"{name}.yaml")
    plain = flaw if name == "compression30" else solved(case)
    assert overall(solved(placed(case, placement), placement), plain) < 1e-3  # type: ignore[arg-type]


def test_other_units_are_the_same_to_round_off_and_other_loads_are_not(flaw: Solved) -> None:
    placement = scaled(1e-3, 1e6, 1e-4)
    case = placed(coarse(), placement)
    assert everything(solved(case, placement), flaw) < 1e-9
    more = replace(case, loads=tuple(_doubled(load) for load in case.loads))
    assert overall(solved(more, placement), flaw) > 0.5


def _doubled(load: object) -> EdgeTraction:
    assert isinstance(load, EdgeTraction)
    return replace(load, traction=(2.0 * load.traction[0], 2.0 * load.traction[1]))


def test_single_components_cannot_be_turned_askew() -> None:
    with pytest.raises(ValueError, match="right angles"):
        placed(coarse(), turned(30.0))
