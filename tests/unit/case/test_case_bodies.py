"""Several bodies: shared boundaries and interfaces, and what holds and loads them, in long forms and short ones."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow import solve
from crackgrow.case import Case, dump_case
from crackgrow.case.dump import written
from crackgrow.case.load import read_case
from crackgrow.case.model import ContactSupport, EdgeTraction, FluidPressure, Gravity, InSituStress
from crackgrow.case.surface import crack_name
from tests.unit.case.scenes import (
    EVERYTHING,
    LAW,
    MATERIAL,
    blocks,
    changed,
    fault,
    faults_of,
    held,
    joint,
    load,
    plate,
    rectangle,
    reread,
    same,
    text_of,
    two_blocks,
    with_body,
)

# --- shared boundaries -----------------------------------------------------------------------------------------------

STEP = {"polygon": [[0, 0], [6, 0], [6, 1], [4, 1], [4, 2], [2, 2], [2, 1], [0, 1]]}
CAP = {"polygon": [[1, 1], [2, 1], [2, 2], [3, 2], [4, 2], [4, 1], [7, 1], [7, 4], [1, 4]]}
BRIDGE = {"polygon": [[0, 1], [1, 1], [1, 2], [3, 2], [3, 1], [4, 1], [4, 3], [0, 3]]}
NOTCH = {"polygon": [[1, 1], [1, 0], [2, 0], [2, 2], [0, 2], [0, 1]]}  # holds the block's corner (1, 1)
BLOCK = {"polygon": [[1, 1], [0, 1], [0, 0], [1, 0]]}
AROUND = {**rectangle(0, 0, 4, 4), "holes": [rectangle(1, 1, 2, 1)]}


@pytest.mark.parametrize(
    ("first", "second", "lines"),
    [
        (rectangle(0, 0, 6, 1), rectangle(1, 1, 2, 2), [[[3, 1], [1, 1]]]),  # the first one is on the left
        (rectangle(1, 1, 2, 2), rectangle(0, 0, 6, 1), [[[1, 1], [3, 1]]]),
        # with the corners of both
        (STEP, CAP, [[[6, 1], [4, 1], [4, 2], [3, 2], [2, 2], [2, 1], [1, 1]]]),
        (CAP, STEP, [[[1, 1], [2, 1], [2, 2], [3, 2], [4, 2], [4, 1], [6, 1]]]),
        (rectangle(0, 0, 4, 1), BRIDGE, [[[4, 1], [3, 1]], [[1, 1], [0, 1]]]),  # in two pieces
        (NOTCH, BLOCK, [[[0, 1], [1, 1], [1, 0]]]),  # over the first corner of a ring
        (rectangle(1, 1, 2, 1), AROUND, [[[1, 1], [3, 1], [3, 2]], [[3, 2], [1, 2], [1, 1]]]),  # all round
        (AROUND, rectangle(1, 1, 2, 1), [[[1, 1], [1, 2], [3, 2]], [[3, 2], [3, 1], [1, 1]]]),
    ],
)
def test_lines_of_an_interface(
    first: dict[str, Any], second: dict[str, Any], lines: list[list[list[float]]], tmp_path: Path
):
    scene = changed(blocks(a=first, b=second), interfaces=joint("a b"))
    (interface,) = load(tmp_path, scene).interfaces
    assert interface.bodies == ("a", "b")
    assert (interface.contact.friction, interface.contact.cohesion) == (0.5, 0.0)
    assert [line.tolist() for line in interface.lines] == lines


def test_round_inclusion_matches_side_by_side(tmp_path: Path):
    disk = {"disk": {"center": [0.3, 0.7], "radius": 1.1}}
    scene = blocks(plate={**rectangle(-2, -2, 5, 5), "holes": [disk]}, core=disk)
    case = load(tmp_path, changed(scene, interfaces=joint("core plate", contact="bonded")))
    (interface,) = case.interfaces
    assert interface.contact == "bonded"
    assert [line.shape for line in interface.lines] == [(181, 2), (181, 2)]
    joined = np.concatenate([interface.lines[0], interface.lines[1][1:-1]])
    np.testing.assert_array_equal(joined, case.bodies[1].outline)
    around = {tuple(point) for point in case.bodies[0].rings[1].points.tolist()}
    assert {tuple(point) for point in joined.tolist()} == around


def test_nearly_common_corners_become_common(tmp_path: Path):
    gap = 4e-10 * np.hypot(2, 2)
    near = {"polygon": [[1 + gap, -gap], [2, 0], [2, 2], [1 - gap, 2 + gap]]}
    scene = changed(blocks(left=rectangle(0, 0, 1, 2), right=near), interfaces=joint("right left"))
    case = load(tmp_path, scene)
    assert case.bodies[1].outline.tolist() == [[1, 0], [2, 0], [2, 2], [1, 2]]
    assert [line.tolist() for line in case.interfaces[0].lines] == [[[1, 2], [1, 0]]]
    assert same(case, reread(case, tmp_path))


def test_bodies_that_meet_at_a_point(tmp_path: Path):
    """Three of them have three interfaces, and all that are missing are told; two that share a corner need none."""
    scene = blocks(low=rectangle(0, 0, 2, 1), left=rectangle(0, 1, 1, 1), right=rectangle(1, 1, 1, 1))
    (tmp_path / "scene.yaml").write_text(text_of(scene), encoding="utf-8")
    pairs = [found.message.partition(" share")[0] for found in faults_of(tmp_path / "scene.yaml")]
    assert pairs == ["bodies 'low' and 'left'", "bodies 'low' and 'right'", "bodies 'left' and 'right'"]
    scene["interfaces"] = joint("low left", "low right", "left right")
    found = [interface.lines[0].tolist() for interface in load(tmp_path, scene).interfaces]
    assert found == [[[1, 1], [0, 1]], [[2, 1], [1, 1]], [[1, 1], [1, 2]]]
    apart = changed(blocks(a=rectangle(0, 0, 1, 1), b=rectangle(1, 1, 1, 1)), supports=held("a", "b"))
    assert load(tmp_path, apart).interfaces == ()
    key, message = fault(tmp_path, changed(apart, interfaces=joint("a b")))
    assert (key, message) == ("interfaces.0.between", "'a' and 'b' share no boundary: they touch at points only")


def test_a_fault_of_an_interface_is_not_told_again_at_a_point_on_it(tmp_path: Path):
    points = {"points": {"slip": {"interface": ["low", "top"], "at": [0, 0]}}}
    scene = changed(two_blocks(), interfaces=joint("low top", contact={"friction": -1}), output=points)
    assert fault(tmp_path, scene)[0] == "interfaces.0.contact.friction"


def test_one_body_or_the_whole_scene_says_what_is_too_coarse_too_fine_or_too_far(tmp_path: Path):
    scene = blocks(a=rectangle(0, 0, 1, 1), b=rectangle(9, 0, 0.1, 1))
    scene = changed(scene, supports=held("a", "b"), numerics={"spacing": 0.06})
    key, message = fault(tmp_path, scene)
    assert key == "numerics.spacing"
    assert "half the smaller side of body 'b', 0.05 m" in message
    scene["bodies"]["b"]["shape"] = rectangle(999, 999, 1, 1)
    scene["numerics"] = {"spacing": 0.4}
    assert "gives about 6.3e+06 lattice nodes" in fault(tmp_path, scene)[1]  # (1000 / 0.4 + 5)^2
    scene["bodies"]["a"]["shape"], scene["bodies"]["b"]["shape"] = rectangle(1e7, 0, 1, 1), rectangle(1e7 + 9, 0, 1, 1)
    key, message = fault(tmp_path, scene)
    assert key == "bodies.b.shape"
    assert "too far for a scene of size 10.0499 m" in message
    scene["bodies"]["b"]["shape"] = rectangle(1e7 - 999, 0, 1, 1)
    load(tmp_path, scene)
    thin = {"polygon": [[0, 0], [2, 0], [2, 1e-6], [2 - 1e-9, 2e-6], [0, 2e-6]]}
    scene = changed(blocks(thin=thin, far=rectangle(0, 1, 1e4, 1e4)), numerics={"spacing": 5e-7})
    (tmp_path / "scene.yaml").write_text(text_of(scene), encoding="utf-8")
    told = {found.key: found.message for found in faults_of(tmp_path / "scene.yaml")}
    assert "details below the smallest length of this scene, 1.41" in told["bodies.thin.shape"]


# --- supports --------------------------------------------------------------------------------------------------------


def test_supports_that_agree_or_share_a_corner_alone_are_taken(tmp_path: Path):
    scene = two_blocks()
    scene["supports"] = [
        {"on": {"body": "low", "edge": "bottom"}, "displacement": {"x": "0.3*x - 0.1*3*x + 0.1*(x - 0.7)", "y": 0}},
        {"at": [0.7, 0], "displacement": {"x": 0, "y": 0}},
        {"on": {"body": "low", "edge": "bottom", "to": 1}, "displacement": {"y": 0}},
        {"on": {"body": "low", "edge": "left"}, "displacement": {"x": 0.2}},
        {"at": [0, 2], "body": "low", "displacement": {"y": 0.3}},
    ]
    assert len(load(tmp_path, scene).supports) == 5


def test_support_at_a_point_knows_its_body(tmp_path: Path):
    scene = two_blocks()
    given = [{"at": [1, 1]}, {"at": [1, 3]}, {"at": [1, 2], "body": "low"}, {"at": [1, 2], "body": "top"}]
    scene["supports"] = [{**support, "displacement": {"x": 0, "y": 0}} for support in given]
    case = load(tmp_path, scene)
    assert [support.body for support in case.supports] == ["low", "top", "low", "top"]
    assert written(case)["supports"][0]["body"] == "low"
    assert same(case, reread(case, tmp_path))


@pytest.mark.parametrize(
    "supports",
    [
        "[{on: {body: rock, edge: bottom, from: -1, to: 1}, displacement: {x: 0, y: 0}}]",
        "[{at: [3, -9], displacement: {x: 0, y: 0}}, {at: [5, 9], displacement: {x: 0}}]",
        "[{on: {body: rock, edge: left}, displacement: {x: 0}}, {at: [15.5, -9], displacement: {y: 0}}]",
    ],
)
@pytest.mark.parametrize("unit", ["um", "mm", "km"])
def test_held_at_any_size(supports: str, unit: str, tmp_path: Path):
    scene = with_body(rectangle(-15.5, -27.5, 31, 55))
    case = load(tmp_path, scene, f"supports={supports}", f"units.length={unit}", "numerics.spacing=1.5")
    assert case.supports


def test_two_supports_in_y_anywhere_leave_x(tmp_path: Path):
    rng = np.random.default_rng(3)
    for _ in range(20):
        (a, b), (c, d) = rng.uniform(-10, 10, (2, 2)).round(3).tolist()
        supports = [{"at": [a, c], "displacement": {"y": 0}}, {"at": [b, d], "displacement": {"y": 0}}]
        scene = {**with_body(rectangle(-15, -15, 30, 30)), "supports": supports, "numerics": {"spacing": 1}}
        assert "translation in x;" in fault(tmp_path, scene)[1]


def test_a_small_body_far_out_keeps_its_supports(tmp_path: Path):
    """One kilometre off, corners are still recognised as lying on the outline."""
    scene = with_body({"rectangle": {"center": ["1 km", "1 km"], "width": 31, "height": 55}})
    scene["units"] = {"length": "mm"}
    scene["supports"] = [
        {"at": at, "displacement": {"x": 0, "y": 0}}
        for at in ([999984.5, 999972.5], [1000015.5, 999972.5], ["1000 m", 999972.5])
    ]
    assert len(load(tmp_path, scene, "numerics.spacing=1.5").supports) == 3


def test_bodies_in_contact_need_no_supports_but_others_do(tmp_path: Path):
    scene = changed(two_blocks(), supports=[])
    load(tmp_path, scene)
    scene["bodies"]["loose"] = {"shape": rectangle(9, 9, 1, 1), "material": {"young": 1, "poisson": 0}}
    for supports in ([], held("low")):
        key, message = fault(tmp_path, changed(scene, supports=supports))
        assert (key, message.partition(":")[0]) == ("supports", "body 'loose' is free to move")
    on = {"body": "loose", "edge": "bottom"}
    load(tmp_path, changed(scene, supports=[{"on": on, "contact": LAW}]))
    load(tmp_path, changed(scene, supports=held("loose")))


def test_a_short_part_of_an_arc_holds_like_its_sides(tmp_path: Path):
    scene = with_body({"disk": {"center": [0, 0], "radius": 1}})
    scene["supports"] = [{"on": {"body": "rock", "edge": "arc", "from": 0, "to": 2}, "displacement": {"x": 0, "y": 0}}]
    assert len(load(tmp_path, scene).supports) == 1


def test_foundations_may_touch_each_other_and_an_interface(tmp_path: Path):
    scene = two_blocks()
    regions = [{"edge": "left", "to": 1}, {"edge": "left", "from": 1}, {"edge": "bottom", "from": 1}]
    law = {"friction": 1, "cohesion": 2}
    scene["supports"] = [{"on": {"body": "low", **on}, "contact": law} for on in regions]
    *_, support = supports = load(tmp_path, scene).supports
    assert [type(support) for support in supports] == [ContactSupport] * 3
    assert (support.region.sides.tolist(), support.region.limits.tolist()) == ([0], [[0.25, 1]])
    assert (support.contact.friction, support.contact.cohesion) == (1.0, 2.0)


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
    key, message = fault(tmp_path, {**scene, "interfaces": joint("rock cap")})
    assert key == "supports"
    assert "rock and cap" in message


# --- loads -----------------------------------------------------------------------------------------------------------

PULL = [{"on": {"edge": "top"}, "traction": [0, 3]}, {"on": {"edge": "bottom"}, "traction": [0, -3]}]
TURN = {"top": [1, 0], "bottom": [-1, 0], "right": [0, 1], "left": [0, -1]}
SHEAR = [{"on": {"edge": edge}, "traction": traction} for edge, traction in TURN.items()]
PRESSURE = [
    *({"on": {"edge": edge}, "pressure": "2 + x**2"} for edge in ("top", "bottom")),
    *({"on": {"edge": edge}, "pressure": 3} for edge in ("left", "right")),
]


def test_loads(tmp_path: Path):
    scene = changed(two_blocks(), units={"stress": "MPa"})
    scene["bodies"]["low"]["material"]["density"] = 2500
    scene["cracks"] = {"flaw": {"path": {"points": [[1, 1], [2, 1]]}, "contact": "none"}}
    scene["loads"] = [
        {"on": {"body": "low", "edge": "right"}, "traction": [1, "2 kPa"]},
        {"body": "low", "gravity": [1, "-9810 mm/s^2"]},
        {"crack": "flaw", "pressure": -2, "held": True},
        {"body": "top", "stress": [-20, "-10 GPa", 3]},
    ]
    case = load(tmp_path, scene)
    traction, gravity, pressure, stress = case.loads
    assert [type(load) for load in case.loads] == [EdgeTraction, Gravity, FluidPressure, InSituStress]
    assert (traction.region.sides.tolist(), traction.traction) == ([1], (1e6, 2e3))
    assert (gravity.body, gravity.acceleration) == ("low", (1.0, -9.81))
    assert (pressure.surface, pressure.pressure) == (crack_name("flaw"), -2e6)
    assert (stress.body, stress.stress) == ("top", (-2e7, -1e10, 3e6))
    assert [item.held for item in case.loads] == [False, False, True, False]
    assert [item["held"] for item in written(case)["loads"]] == [False, False, True, False]


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


def test_short_forms_mean_what_the_long_ones_do(tmp_path: Path):
    """Vectors as lists and as mappings; the only body need not be named."""
    one, other = (changed(plate(), supports=held("rock")) for _ in range(2))
    for scene in (one, other):
        scene["bodies"]["rock"]["material"] = {**MATERIAL, "density": 2500}
    one["supports"] = [{"on": {"body": "rock", "edge": "bottom"}, "displacement": {"x": 0, "y": "0.1*x"}}]
    other["supports"] = [{"on": {"edge": "bottom"}, "displacement": [0, "0.1*x"]}]
    one["loads"] = [
        {"on": {"body": "rock", "edge": "top"}, "traction": ["2*x", -1]},
        {"body": "rock", "gravity": [0, -9.81]},
        {"body": "rock", "stress": [-1, -2, 0]},
    ]
    other["loads"] = [
        {"on": {"edge": "top"}, "traction": {"y": -1, "x": "2*x"}},
        {"gravity": [0, -9.81]},
        {"stress": [-1, -2, 0]},
    ]
    assert dump_case(load(tmp_path, one)) == dump_case(load(tmp_path, other))


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


def test_a_faulty_definition_is_told_once_and_in_its_line(tmp_path: Path):
    assert fault(tmp_path, named(), "materials.rock.young=-1")[0] == "materials.rock.young"
    scene = with_body(rectangle(0, 0, 4, 6), material="soft")
    scene = {"materials": {"soft": {"young": 1, "poisson": 0.5}}, **scene, "supports": held("rock")}
    assert fault(tmp_path, scene)[0] == "bodies.rock.material.poisson"
    (only,) = faults_of(tmp_path / "scene.yaml")
    lines = (tmp_path / "scene.yaml").read_text(encoding="utf-8").splitlines()
    assert lines[only.line - 1].strip() == "poisson: 0.5"


def test_plane_stress_takes_poisson_one_half(tmp_path: Path):
    scene = changed(plate(), supports=held("rock"), plane="stress")
    case: Case = load(tmp_path, scene, "bodies.rock.material.poisson=0.5")
    assert case.bodies[0].material.poisson == 0.5
