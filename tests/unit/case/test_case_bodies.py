"""Several bodies: overlaps, shared boundaries, interfaces, foundations, supports, loads; and everything at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import Case, dump_case
from crackgrow.case.model import (
    ContactSupport,
    CoulombContact,
    EdgeSupport,
    EdgeTraction,
    FluidPressure,
    Gravity,
    InSituStress,
    PointSupport,
)
from crackgrow.case.surface import crack_name
from tests.unit.case.scenes import EVERYTHING, blocks, changed, fault, faults, held, load, rectangle, with_body
from tests.unit.case.test_case_load import reread, same

LAW = {"friction": 0.5, "cohesion": 0}


def joint(*names: str, contact: Any = LAW) -> list[dict[str, Any]]:
    """Interfaces between the pairs "a b"."""
    return [{"between": pair.split(), "contact": contact} for pair in names]


def lines(case: Case) -> list[list[list[float]]]:
    """Return the polylines of the only interface."""
    (interface,) = case.interfaces
    return [line.tolist() for line in interface.lines]


# --- shared boundaries -----------------------------------------------------------------------------------------------


def test_interface_of_two_blocks(tmp_path: Path):
    scene = blocks(low=rectangle(0, 0, 6, 1), top=rectangle(1, 1, 2, 2))
    scene["interfaces"] = joint("low top")
    (interface,) = load(tmp_path, scene).interfaces
    assert interface.bodies == ("low", "top")
    assert (interface.contact.friction, interface.contact.cohesion) == (0.5, 0.0)
    assert [line.tolist() for line in interface.lines] == [[[3, 1], [1, 1]]]  # low is on the left
    assert not interface.lines[0].flags.writeable
    scene["interfaces"] = joint("top low", contact="bonded")
    (interface,) = load(tmp_path, scene).interfaces
    assert (interface.bodies, interface.contact) == (("top", "low"), "bonded")
    assert [line.tolist() for line in interface.lines] == [[[1, 1], [3, 1]]]


def test_interface_has_the_corners_of_both(tmp_path: Path):
    step = [[0, 0], [6, 0], [6, 1], [4, 1], [4, 2], [2, 2], [2, 1], [0, 1]]
    cap = [[1, 1], [2, 1], [2, 2], [3, 2], [4, 2], [4, 1], [7, 1], [7, 4], [1, 4]]
    scene = changed(blocks(step={"polygon": step}, cap={"polygon": cap}), interfaces=joint("step cap"))
    expected = [[6, 1], [4, 1], [4, 2], [3, 2], [2, 2], [2, 1], [1, 1]]
    assert lines(load(tmp_path, scene)) == [expected]
    scene["interfaces"] = joint("cap step")
    assert lines(load(tmp_path, scene)) == [expected[::-1]]


def test_interface_in_two_pieces(tmp_path: Path):
    bridge = [[0, 1], [1, 1], [1, 2], [3, 2], [3, 1], [4, 1], [4, 3], [0, 3]]
    scene = changed(blocks(low=rectangle(0, 0, 4, 1), bridge={"polygon": bridge}), interfaces=joint("low bridge"))
    assert lines(load(tmp_path, scene)) == [[[4, 1], [3, 1]], [[1, 1], [0, 1]]]


def test_interface_that_runs_over_the_first_corner_of_a_ring(tmp_path: Path):
    notch = [[1, 1], [1, 0], [2, 0], [2, 2], [0, 2], [0, 1]]  # holds the block's corner (1, 1)
    block = [[1, 1], [0, 1], [0, 0], [1, 0]]
    scene = changed(blocks(notch={"polygon": notch}, block={"polygon": block}), interfaces=joint("notch block"))
    assert lines(load(tmp_path, scene)) == [[[0, 1], [1, 1], [1, 0]]]


def test_inclusion_has_two_lines(tmp_path: Path):
    plate = {**rectangle(0, 0, 4, 4), "holes": [rectangle(1, 1, 2, 1)]}
    scene = changed(blocks(plate=plate, core=rectangle(1, 1, 2, 1)), interfaces=joint("core plate"))
    assert lines(load(tmp_path, scene)) == [[[1, 1], [3, 1], [3, 2]], [[3, 2], [1, 2], [1, 1]]]
    scene["interfaces"] = joint("plate core")
    first, second = lines(load(tmp_path, scene))
    assert first == [[1, 1], [1, 2], [3, 2]]
    assert second == [[3, 2], [3, 1], [1, 1]]


def test_round_inclusion_matches_side_by_side(tmp_path: Path):
    disk = {"disk": {"center": [0.3, 0.7], "radius": 1.1}}
    scene = blocks(plate={**rectangle(-2, -2, 5, 5), "holes": [disk]}, core=disk)
    scene["interfaces"] = joint("core plate")
    case = load(tmp_path, scene)
    (interface,) = case.interfaces
    assert [line.shape for line in interface.lines] == [(181, 2), (181, 2)]
    joined = np.concatenate([interface.lines[0], interface.lines[1][1:-1]])
    np.testing.assert_array_equal(joined, case.bodies[1].outline)
    plate = {tuple(point) for point in case.bodies[0].rings[1].points.tolist()}
    assert {tuple(point) for point in joined.tolist()} == plate


def test_nearly_common_corners_become_common(tmp_path: Path):
    gap = 4e-10 * np.hypot(2, 2)
    near = {"polygon": [[1 + gap, -gap], [2, 0], [2, 2], [1 - gap, 2 + gap]]}
    scene = changed(blocks(left=rectangle(0, 0, 1, 2), right=near), interfaces=joint("right left"))
    case = load(tmp_path, scene)
    assert case.bodies[1].outline.tolist() == [[1, 0], [2, 0], [2, 2], [1, 2]]
    assert lines(case) == [[[1, 2], [1, 0]]]
    assert same(case, reread(case, tmp_path))


def test_three_bodies_meet_at_a_point(tmp_path: Path):
    scene = blocks(low=rectangle(0, 0, 2, 1), left=rectangle(0, 1, 1, 1), right=rectangle(1, 1, 1, 1))
    scene["interfaces"] = joint("low left", "low right", "left right")
    found = [interface.lines[0].tolist() for interface in load(tmp_path, scene).interfaces]
    assert found == [[[1, 1], [0, 1]], [[2, 1], [1, 1]], [[1, 1], [1, 2]]]


def test_bodies_that_touch_at_a_corner_need_no_interface(tmp_path: Path):
    scene = blocks(a=rectangle(0, 0, 1, 1), b=rectangle(1, 1, 1, 1))
    scene["supports"] = held("a", "b")
    assert load(tmp_path, scene).interfaces == ()
    key, message = fault(tmp_path, changed(scene, interfaces=joint("a b")))
    assert (key, message) == ("interfaces.0.between", "'a' and 'b' share no boundary: they touch at points only")


def test_every_missing_interface_is_told(tmp_path: Path):
    scene = blocks(low=rectangle(0, 0, 2, 1), left=rectangle(0, 1, 1, 1), right=rectangle(1, 1, 1, 1))
    pairs = [found.message.partition(" share")[0] for found in faults(tmp_path, scene)]
    assert pairs == ["bodies 'low' and 'left'", "bodies 'low' and 'right'", "bodies 'left' and 'right'"]


def test_details_finer_than_the_scene(tmp_path: Path):
    thin = {"polygon": [[0, 0], [2, 0], [2, 1e-6], [2 - 1e-9, 2e-6], [0, 2e-6]]}
    scene = changed(blocks(thin=thin, far=rectangle(0, 1, 1e4, 1e4)), numerics={"spacing": 5e-7})
    keys = {found.key: found.message for found in faults(tmp_path, scene)}
    assert "details below the smallest length of this scene, 1.41" in keys["bodies.thin.shape"]


# --- cracks ----------------------------------------------------------------------------------------------------------


def cracked(scene: dict[str, Any], points: list[list[float]], tips: str = "none") -> dict[str, Any]:
    return changed(scene, cracks={"flaw": {"path": {"points": points}, "tips": tips, "contact": "none"}})


def two_blocks() -> dict[str, Any]:
    scene = blocks(low=rectangle(0, 0, 4, 2), top=rectangle(0, 2, 4, 2))
    return changed(scene, interfaces=joint("low top"), supports=held("low"))


def test_a_crack_knows_its_body(tmp_path: Path):
    assert load(tmp_path, cracked(two_blocks(), [[1, 1], [2, 1]])).cracks[0].body == "low"
    assert load(tmp_path, cracked(two_blocks(), [[1, 3], [0, 3]])).cracks[0].body == "top"


def test_a_fault_of_an_interface_is_not_told_again_at_a_point_on_it(tmp_path: Path):
    scene = two_blocks()
    scene["interfaces"][0]["contact"] = {"friction": -1}
    low, high = scene["interfaces"][0]["between"]
    key, _ = fault(tmp_path, {**scene, "output": {"points": {"slip": {"interface": [low, high], "at": [0, 0]}}}})
    assert key == "interfaces.0.contact.friction"


@pytest.mark.parametrize(
    ("points", "tips", "body"),
    [
        ([[1, 1], [1, 2]], "start", "low"),
        ([[1, 2], [1, 1]], "end", "low"),
        ([[1, 2], [1, 3]], "end", "top"),
        ([[1, 2], [3, 2.5], [2, 2]], "none", "top"),
        ([[0, 1], [4, 2]], "none", "low"),
        ([[0, 1], [4, 1]], "none", "low"),
    ],
)
def test_a_crack_may_end_on_an_interface(points: list[list[float]], tips: str, body: str, tmp_path: Path):
    (crack,) = load(tmp_path, cracked(two_blocks(), points, tips)).cracks
    assert crack.body == body
    assert crack.points.tolist() == points


def test_a_crack_on_a_slanting_interface_lies_where_its_inside_does(tmp_path: Path):
    """Ends on an interface are rounded to either side of it; the body is still that of the inside."""
    rng = np.random.default_rng(4)
    low, top = [[0, 0], [4, 0], [4, 1.1], [0, 2.3]], [[0, 2.3], [4, 1.1], [4, 4], [0, 4]]
    scene = changed(blocks(low={"polygon": low}, top={"polygon": top}), interfaces=joint("low top"))
    scene["supports"] = [{"at": [0, 0], "body": "low", "displacement": {"x": 0, "y": 0}}]
    sides = [*["low"] * 10, *["top"] * 10]
    cracks = {}
    for index, (side, x) in enumerate(zip(sides, rng.uniform(0.5, 3.5, 20).tolist(), strict=True)):
        points = [[x, 2.3 - 0.3 * x], [x, 0.5 if side == "low" else 3.5]]
        cracks[f"c{index}"] = {"path": {"points": points[:: rng.choice([1, -1])]}, "tips": "none", "contact": "none"}
    assert [crack.body for crack in load(tmp_path, changed(scene, cracks=cracks)).cracks] == sides


HOLED = {**rectangle(0, 0, 6, 4), "holes": [rectangle(2, 1, 2, 2)]}


@pytest.mark.parametrize(
    ("points", "tips", "cut", "lost"),
    [
        ([[1, 2], [3, 2]], ["start"], [[1, 2], [2, 2]], [1.0]),
        ([[3, 2], [1, 2]], ["end"], [[2, 2], [1, 2]], [1.0]),
        ([[-1, 2], [1, 2.5], [3, 2.5]], [], [[0, 2.25], [1, 2.5], [2, 2.5]], [np.hypot(1, 0.25), 1.0]),
        ([[1, 1], [1, -1]], ["start"], [[1, 1], [1, 0]], [1.0]),
    ],
)
def test_an_end_in_a_hole_or_outside_is_cut_at_the_rim_and_listed(
    points: list[list[float]], tips: list[str], cut: list[list[float]], lost: list[float], tmp_path: Path
):
    case = load(tmp_path, cracked(changed(with_body(HOLED), supports=held("rock")), points, "both"))
    (crack,) = case.cracks
    np.testing.assert_allclose(crack.points, cut, atol=1e-15)
    assert [end for end in ("start", "end") if getattr(crack, f"tip_at_{end}")] == tips
    assert [(part.crack, part.whole, part.why) for part in case.cut] == [("flaw", False, "outside of the rock")] * len(
        lost
    )
    np.testing.assert_allclose([part.length for part in case.cut], lost, rtol=1e-12)
    again = Case.from_dict(case.to_dict())
    assert again.cracks[0].points.tolist() == crack.points.tolist()


def test_a_crack_may_end_on_a_hole(tmp_path: Path):
    scene = changed(with_body(HOLED), supports=held("rock"))
    case = load(tmp_path, cracked(scene, [[1, 2], [2, 2]], "start"))
    assert (case.cracks[0].tip_at_start, case.cracks[0].tip_at_end) == (True, False)


def test_only_bodies_whose_cracks_can_grow_need_a_strength(tmp_path: Path):
    growth = {key: value for key, value in EVERYTHING["growth"].items() if key != "direction"}
    scene = changed(two_blocks(), growth=growth)
    scene["growth"] |= {"tip_stress": {"radius": 0.1}}
    assert fault(tmp_path, cracked(scene, [[1, 3], [2, 3]], "start"))[0] == "bodies.top.strength"
    assert load(tmp_path, cracked(scene, [[1, 3], [2, 3]], "none")).bodies[1].strength is None
    scene["bodies"]["top"]["strength"] = {"tension": 1, "cohesion": 9, "friction_angle": 30}
    assert load(tmp_path, cracked(scene, [[1, 3], [2, 3]], "start")).bodies[0].strength is None


# --- supports and loads ----------------------------------------------------------------------------------------------


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
    assert case.resolved["supports"][0]["body"] == "low"  # type: ignore[index]
    assert same(case, reread(case, tmp_path))


def test_bodies_in_contact_need_no_supports_but_others_do(tmp_path: Path):
    scene = changed(two_blocks(), supports=[])
    load(tmp_path, scene)
    scene["bodies"]["loose"] = {"shape": rectangle(9, 9, 1, 1), "material": {"young": 1, "poisson": 0}}
    key, message = fault(tmp_path, scene)
    assert (key, message.partition(":")[0]) == ("supports", "body 'loose' is free to move")
    on = {"body": "loose", "edge": "bottom"}
    load(tmp_path, changed(scene, supports=[{"on": on, "contact": LAW}]))
    load(tmp_path, changed(scene, supports=held("loose")))


def test_a_body_is_not_held_by_the_supports_of_another(tmp_path: Path):
    scene = changed(blocks(a=rectangle(0, 0, 1, 1), b=rectangle(3, 0, 1, 1)), supports=held("a"))
    assert "body 'b' is free to move" in fault(tmp_path, scene)[1]


def test_an_arc_holds_like_its_sides(tmp_path: Path):
    scene = with_body({"disk": {"center": [0, 0], "radius": 1}})
    scene["supports"] = [{"on": {"body": "rock", "edge": "arc"}, "displacement": {"x": 0}}]
    assert "free to move: translation in y" in fault(tmp_path, scene)[1]
    scene["supports"] = [{"on": {"body": "rock", "edge": "arc", "from": 0, "to": 2}, "displacement": {"x": 0, "y": 0}}]
    assert len(load(tmp_path, scene).supports) == 1


def test_foundation(tmp_path: Path):
    scene = with_body(rectangle(0, 0, 4, 2))
    scene["supports"] = [
        {"on": {"body": "rock", "edge": "bottom", "from": 1}, "contact": {"friction": 1, "cohesion": 2}}
    ]
    (support,) = load(tmp_path, scene).supports
    assert isinstance(support, ContactSupport)
    assert (support.region.sides.tolist(), support.region.limits.tolist()) == ([0], [[0.25, 1]])
    assert (support.contact.friction, support.contact.cohesion) == (1.0, 2.0)


def test_foundations_may_touch_each_other_and_an_interface(tmp_path: Path):
    scene = two_blocks()
    regions = [{"edge": "left", "to": 1}, {"edge": "left", "from": 1}, {"edge": "bottom"}]
    scene["supports"] = [{"on": {"body": "low", **on}, "contact": LAW} for on in regions]
    assert len(load(tmp_path, scene).supports) == 3


def test_loads(tmp_path: Path):
    scene = changed(two_blocks(), units={"stress": "MPa"})
    scene["bodies"]["low"]["material"]["density"] = 2500
    scene["cracks"] = {"flaw": {"path": {"points": [[1, 1], [2, 1]]}, "contact": "none"}}
    scene["loads"] = [
        {"on": {"body": "low", "edge": "right"}, "traction": [1, "2 kPa"]},
        {"body": "low", "gravity": [1, "-9810 mm/s^2"]},
        {"crack": "flaw", "pressure": -2},
        {"body": "top", "stress": [-20, "-10 GPa", 3]},
    ]
    traction, gravity, pressure, stress = load(tmp_path, scene).loads
    assert isinstance(traction, EdgeTraction)
    assert (traction.region.sides.tolist(), traction.traction) == ([1], (1e6, 2e3))
    assert isinstance(gravity, Gravity)
    assert (gravity.body, gravity.acceleration) == ("low", (1.0, -9.81))
    assert isinstance(pressure, FluidPressure)
    assert (pressure.surface, pressure.pressure) == (crack_name("flaw"), -2e6)
    assert isinstance(stress, InSituStress)
    assert (stress.body, stress.stress) == ("top", (-2e7, -1e10, 3e6))


# --- numerics --------------------------------------------------------------------------------------------------------


def test_spacing_is_judged_by_the_smallest_body_and_the_whole_scene(tmp_path: Path):
    scene = blocks(a=rectangle(0, 0, 1, 1), b=rectangle(9, 0, 0.1, 1))
    scene = changed(scene, supports=held("a", "b"), numerics={"spacing": 0.06})
    key, message = fault(tmp_path, scene)
    assert key == "numerics.spacing"
    assert "half the smaller side of body 'b', 0.05 m" in message
    scene["bodies"]["b"]["shape"] = rectangle(999, 999, 1, 1)
    scene["numerics"] = {"spacing": 0.4}
    assert "gives about 6.3e+06 lattice nodes" in fault(tmp_path, scene)[1]  # (1000 / 0.4 + 5)^2


def test_a_scene_too_far_from_the_origin(tmp_path: Path):
    scene = changed(blocks(a=rectangle(1e7, 0, 1, 1), b=rectangle(1e7 + 9, 0, 1, 1)), supports=held("a", "b"))
    key, message = fault(tmp_path, scene)
    assert key == "bodies.b.shape"
    assert "too far for a scene of size 10.0499 m" in message
    scene["bodies"]["b"]["shape"] = rectangle(1e7 - 999, 0, 1, 1)
    load(tmp_path, changed(scene, numerics={"spacing": 0.5}))


# --- everything ------------------------------------------------------------------------------------------------------


def test_everything(tmp_path: Path):
    case = load(tmp_path, EVERYTHING)
    foundation, block, plug = case.bodies
    assert [body.name for body in case.bodies] == ["foundation", "block", "plug"]
    assert [len(ring.points) for ring in block.rings] == [4, 360, 4, 3]
    assert block.rings[0].edge_names == ("base", "2", "wall", "wall")
    assert (block.material.density, plug.strength, foundation.material.density) == (2500.0, None, None)
    joint, glue = case.interfaces
    assert [line.tolist() for line in joint.lines] == [[[-0.01, 0.0], [0.01, 0.0]]]
    assert isinstance(joint.contact, CoulombContact)
    assert (glue.contact, len(glue.lines)) == ("bonded", 2)
    bottom, wall, corner = case.supports
    assert isinstance(bottom, ContactSupport)
    assert isinstance(wall, EdgeSupport)
    assert isinstance(corner, PointSupport)
    np.testing.assert_allclose(wall.region.limits, [[0.75, 1], [0, 0.75]], atol=1e-15)
    assert (wall.region.sides.tolist(), bottom.contact.cohesion) == ([2, 3], 1e6)
    points = np.array([[-0.01, 0.005], [0.004, 0.02]])
    x, y = (component(points) for component in wall.displacement)
    np.testing.assert_allclose(x, [-1e-3, 0.26e-3], rtol=1e-14)  # 0.09 * (-10) - 0.1 = -1 mm
    np.testing.assert_allclose(y, [(100 + np.sqrt(0.5)) * 1e-3, 4e-3], rtol=1e-14)
    assert case.loads[0].region.sides.tolist() == [368, 369, 370]
    assert case.loads[1].region.sides.tolist() == [*range(350, 360), *range(11)]
    assert case.growth is not None
    assert (case.growth.criterion, case.growth.direction) == ("max_hoop_stress", "implicit")


def test_everything_reads_back_bit_for_bit(tmp_path: Path):
    case = load(tmp_path, EVERYTHING)
    again = reread(case, tmp_path)
    assert same(case, again)
    assert dump_case(again) == dump_case(case)
