"""Several bodies: shared boundaries and interfaces, and what holds and loads them, in long forms and short ones."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow import solve
from crackgrow.case import dump_case
from crackgrow.case.load import read_case
from tests.unit.case.scenes import (
    EVERYTHING,
    LAW,
    MATERIAL,
    blocks,
    changed,
    fault,
    held,
    joint,
    load,
    plate,
    rectangle,
    reread,
    same,
    two_blocks,
)

# --- shared boundaries -----------------------------------------------------------------------------------------------

STEP = {"polygon": [[0, 0], [6, 0], [6, 1], [4, 1], [4, 2], [2, 2], [2, 1], [0, 1]]}
CAP = {"polygon": [[1, 1], [2, 1], [2, 2], [3, 2], [4, 2], [4, 1], [7, 1], [7, 4], [1, 4]]}
BRIDGE = {"polygon": [[0, 1], [1, 1], [1, 2], [3, 2], [3, 1], [4, 1], [4, 3], [0, 3]]}
NOTCH = {"polygon": [[1, 1], [1, 0], [2, 0], [2, 2], [0, 2], [0, 1]]}  # holds the block's corner (1, 1)
BLOCK = {"polygon": [[1, 1], [0, 1], [0, 0], [1, 0]]}
AROUND = {**rectangle(0, 0, 4, 4), "holes": [rectangle(1, 1, 2, 1)]}


@pytest.mark.parametrize(("first", "second", "lines"), [
    (rectangle(0, 0, 6, 1), rectangle(1, 1, 2, 2), [[[3, 1], [1, 1]]]),  # the first one is on the left
    (rectangle(1, 1, 2, 2), rectangle(0, 0, 6, 1), [[[1, 1], [3, 1]]]),
    # with the corners of both
    (STEP, CAP, [[[6, 1], [4, 1], [4, 2], [3, 2], [2, 2], [2, 1], [1, 1]]]),
    (CAP, STEP, [[[1, 1], [2, 1], [2, 2], [3, 2], [4, 2], [4, 1], [6, 1]]]),
    (rectangle(0, 0, 4, 1), BRIDGE, [[[4, 1], [3, 1]], [[1, 1], [0, 1]]]),  # in two pieces
    (NOTCH, BLOCK, [[[0, 1], [1, 1], [1, 0]]]),  # over the first corner of a ring
    (rectangle(1, 1, 2, 1), AROUND, [[[1, 1], [3, 1], [3, 2]], [[3, 2], [1, 2], [1, 1]]]),  # all round
    (AROUND, rectangle(1, 1, 2, 1), [[[1, 1], [1, 2], [3, 2]], [[3, 2], [3, 1], [1, 1]]]),
])  # fmt: skip
def test_lines_of_an_interface(
    first: dict[str, Any], second: dict[str, Any], lines: list[list[list[float]]], tmp_path: Path
):
    scene = changed(blocks(a=first, b=second), interfaces=joint("a b"))
    (interface,) = load(tmp_path, scene).interfaces
    assert interface.bodies == ("a", "b")
    assert (interface.contact.friction, interface.contact.cohesion) == (0.5, 0.0)
    assert [line.tolist() for line in interface.lines] == lines


def test_nearly_common_corners_become_common(tmp_path: Path):
    gap = 4e-10 * np.hypot(2, 2)
    near = {"polygon": [[1 + gap, -gap], [2, 0], [2, 2], [1 - gap, 2 + gap]]}
    scene = changed(blocks(left=rectangle(0, 0, 1, 2), right=near), interfaces=joint("right left"))
    case = load(tmp_path, scene)
    assert case.bodies[1].outline.tolist() == [[1, 0], [2, 0], [2, 2], [1, 2]]
    assert [line.tolist() for line in case.interfaces[0].lines] == [[[1, 2], [1, 0]]]
    assert same(case, reread(case, tmp_path))


def test_bodies_that_meet_at_a_point(tmp_path: Path):
    """Three of them have three interfaces; two that share a corner need none."""
    scene = blocks(low=rectangle(0, 0, 2, 1), left=rectangle(0, 1, 1, 1), right=rectangle(1, 1, 1, 1))
    scene["interfaces"] = joint("low left", "low right", "left right")
    found = [interface.lines[0].tolist() for interface in load(tmp_path, scene).interfaces]
    assert found == [[[1, 1], [0, 1]], [[2, 1], [1, 1]], [[1, 1], [1, 2]]]
    apart = changed(blocks(a=rectangle(0, 0, 1, 1), b=rectangle(1, 1, 1, 1)), supports=held("a", "b"))
    assert load(tmp_path, apart).interfaces == ()
    key, message = fault(tmp_path, changed(apart, interfaces=joint("a b")))
    assert (key, message) == ("interfaces.0.between", "'a' and 'b' share no boundary: they touch at points only")


# --- supports --------------------------------------------------------------------------------------------------------


def test_support_at_a_point_knows_its_body(tmp_path: Path):
    scene = two_blocks()
    given = [{"at": [1, 1]}, {"at": [1, 3]}, {"at": [1, 2], "body": "low"}, {"at": [1, 2], "body": "top"}]
    scene["supports"] = [{**support, "displacement": {"x": 0, "y": 0}} for support in given]
    case = load(tmp_path, scene)
    assert [support.body for support in case.supports] == ["low", "top", "low", "top"]
    assert same(case, reread(case, tmp_path))


def test_bodies_in_contact_need_no_supports_but_others_do(tmp_path: Path):
    scene = changed(two_blocks(), supports=[])
    load(tmp_path, scene)
    scene["bodies"]["loose"] = {"shape": rectangle(9, 9, 1, 1), "material": {"young": 1, "poisson": 0}}
    assert fault(tmp_path, scene)[1].startswith("body 'loose' is free to move")
    load(tmp_path, changed(scene, supports=[{"on": {"body": "loose", "edge": "bottom"}, "contact": LAW}]))
    load(tmp_path, changed(scene, supports=held("loose")))


def test_minimal_supports_are_three_constraints_off_the_loads_and_cracks(tmp_path: Path):
    crack = {"path": {"points": [[-2, 0], [-1, 0]]}, "contact": "none", "tips": "end"}
    case = load(tmp_path, plate(*PULL, cracks={"flaw": crack}))
    components = [part for support in case.supports for part in support.displacement if part is not None]
    assert components == [0.0, 0.0, 0.0]
    for support in case.supports:
        assert abs(support.point[0]) == 2 or abs(support.point[1]) == 3
        assert np.hypot(*(support.point - (-2, 0))) > case.numerics.spacing
    assert dump_case(read_case(dump_case(case), "again", case.name)) == dump_case(case)


def test_minimal_supports_hold_bonded_bodies_and_no_loose_ones(tmp_path: Path):
    scene = plate()
    scene["bodies"]["cap"] = {"shape": rectangle(-2, 3, 4, 2), "material": MATERIAL}
    bonded = joint("rock cap", contact="bonded")
    assert len(load(tmp_path, {**scene, "interfaces": bonded}).supports) == 2
    assert "rock and cap" in fault(tmp_path, {**scene, "interfaces": joint("rock cap")})[1]


# --- loads -----------------------------------------------------------------------------------------------------------

PULL = [{"on": {"edge": "top"}, "traction": [0, 3]}, {"on": {"edge": "bottom"}, "traction": [0, -3]}]
TURN = {"top": [1, 0], "bottom": [-1, 0], "right": [0, 1], "left": [0, -1]}
SHEAR = [{"on": {"edge": edge}, "traction": traction} for edge, traction in TURN.items()]
PRESSURE = [
    *({"on": {"edge": edge}, "pressure": "2 + x**2"} for edge in ("top", "bottom")),
    *({"on": {"edge": edge}, "pressure": 3} for edge in ("left", "right")),
]


@pytest.mark.parametrize(
    ("loads", "stress"), [(PULL, [0, 3, 0]), (SHEAR, [0, 0, 1]), (PRESSURE, None)], ids=["pull", "shear", "pressure"]
)
def test_minimal_supports_take_no_force_of_loads_that_balance(
    loads: list[dict[str, Any]], stress: list[float] | None, tmp_path: Path
):
    solution = solve(load(tmp_path, plate(*loads, numerics={"spacing": 1})))
    assert np.abs(solution.reactions[["force_x", "force_y"]]).to_numpy().max() < 1e-9
    if stress is not None:
        found = solution.stress_at(np.array([[0.3, 0.2], [-1.4, 2.1], [0.5, 0.7]]))
        np.testing.assert_allclose(found, [stress] * 3, atol=1e-9)


# --- short forms and names -------------------------------------------------------------------------------------------


ROUGH = {"friction": 0.5, "cohesion": 1, "residual_friction": 0.4}


def named() -> dict[str, Any]:
    """The scene with every form, its materials and laws under names."""
    scene = copy.deepcopy(EVERYTHING)
    scene["materials"] = {"rock": MATERIAL, "heavy": {**MATERIAL, "density": "2500 kg/m^3"}}
    scene["laws"] = {"rough": ROUGH}
    for name, body in scene["bodies"].items():
        body["material"] = "heavy" if name == "block" else "rock"
    for part in (scene["cracks"]["flaw"], scene["interfaces"][0], scene["supports"][0]):
        part["contact"] = "rough"
    return scene


def test_names_of_materials_and_laws_mean_what_they_name(tmp_path: Path):
    written = copy.deepcopy(EVERYTHING)
    for part in (written["cracks"]["flaw"], written["interfaces"][0], written["supports"][0]):
        part["contact"] = ROUGH
    assert dump_case(load(tmp_path, named())) == dump_case(load(tmp_path, written))
    case = load(tmp_path, named(), "materials.rock.poisson=0.1", "laws.rough.cohesion=2")
    assert [body.material.poisson for body in case.bodies] == [0.1, 0.25, 0.1]
    assert case.cracks[0].contact.cohesion == case.supports[0].contact.cohesion == 2e6
