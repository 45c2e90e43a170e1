"""What nearly touches is brought together by a tolerance of the scene: the same at every spacing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case import dump_case, load_case
from crackgrow.plan.sizes import sizes_of
from tests.unit.case.scenes import MATERIAL, held, load, rectangle, with_body

HEAVY = {**MATERIAL, "density": "2500 kg/m^3"}
DOWN = [0, "-9.81 m/s^2"]


def turned(points: list[list[float]], angle: float, digits: int) -> list[list[float]]:
    """Points turned about the origin, as one types them: with so many digits."""
    cos, sin = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return [[float(f"{value:.{digits}g}") for value in (x * cos - y * sin, x * sin + y * cos)] for x, y in points]


def incline(angle: float, digits: int, scale: float = 1.0, mirror: bool = False) -> dict[str, Any]:
    """A block of 2 m on a slab at an angle; neither side of the contact has its corners on those of the other."""
    slab = [[0.0, -1.0], [10.0, -1.0], [10.0, 0.0], [0.0, 0.0]]
    block = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [4.0, 2.0]]
    shapes = {}
    for name, corners in (("slab", slab), ("block", block)):
        points = turned((scale * np.array(corners)).tolist(), angle, digits)
        shapes[name] = {"polygon": [[-x, y] for x, y in points] if mirror else points}
    return {
        "title": "a block on an incline",
        "plane": "strain",
        "bodies": {name: {"shape": shape, "material": dict(HEAVY)} for name, shape in shapes.items()},
        "interfaces": [{"between": ["slab", "block"], "contact": {"friction": 0.7, "cohesion": 0}}],
        "supports": [{"on": {"body": "slab", "edge": "0"}, "displacement": {"x": 0, "y": 0}}],
        "loads": [{"body": "block", "gravity": DOWN}],
        "numerics": {"spacing": scale},
    }


@pytest.mark.parametrize("digits", [5, 7, 9, 15])
def test_block_on_an_incline_holds_however_its_corners_are_typed(digits: int, tmp_path: Path):
    """At a coarse spacing it is solved; finer ones need its cover alone."""
    case = load(tmp_path, incline(30.0, digits), "numerics.spacing=0.25")
    reactions = crackgrow.solve(case).reactions
    (weight,) = reactions["force_y"][reactions["where"] == "slab/block"]
    assert weight == pytest.approx(-4.0 * 2500 * 9.81, rel=1e-4)
    for spacing in (0.1, 0.05, 0.02):
        finer = load(tmp_path, incline(30.0, digits), f"numerics.spacing={spacing}")
        assert sizes_of(finer).n_contact > 1.0 / spacing


@pytest.mark.parametrize(
    ("angle", "scale", "mirror"), [(30, 1e-3, False), (120, 1.0, False), (30, 1.0, True), (10, 1e3, False)]
)
def test_turned_scaled_and_mirrored_copies_are_brought_together_alike(
    angle: float, scale: float, mirror: bool, tmp_path: Path
):
    copy = load(tmp_path, incline(angle, 6, scale, mirror))
    first = load(tmp_path, incline(30, 6))
    assert (
        [interface.lines[0].shape for interface in copy.interfaces]
        == [(2, 2)]
        == [interface.lines[0].shape for interface in first.interfaces]
    )
    beyond = incline(angle, 6, scale, mirror)
    beyond["bodies"]["block"]["shape"]["polygon"] = [
        [x, y + 5e-4 * scale] for x, y in beyond["bodies"]["block"]["shape"]["polygon"]
    ]
    with pytest.raises(crackgrow.CaseError):
        load(tmp_path, beyond)


def test_side_with_a_corner_more_keeps_its_name_and_its_places(tmp_path: Path):
    scene = incline(0.0, 15)
    scene["bodies"]["block"]["shape"] = {"polygon": [[4, 1e-5], [6, 2e-5], [6, 2], [4, 2]]}
    scene["loads"].append({"on": {"body": "slab", "edge": "2", "from": 1, "to": 5}, "traction": [0, -1]})
    case = load(tmp_path, scene, "numerics.spacing=0.25")
    slab = case.bodies[0]
    assert slab.outline.tolist() == [[0, -1], [10, -1], [10, 0], [6, 2e-5], [4, 1e-5], [0, 0]]
    assert slab.rings[0].edge_names == ("0", "1", "2", "2", "2", "3")
    region = case.loads[1].region  # type: ignore[union-attr]
    sides = np.stack([slab.outline, np.roll(slab.outline, -1, axis=0)], axis=1)[region.sides]
    places = sides[:, :1] + region.limits[:, :, None] * (sides[:, 1:] - sides[:, :1])
    np.testing.assert_allclose(places[[0, -1], [0, -1], 0], [5.0, 1.0], atol=1e-9)
    told = crackgrow.solve(case).warnings
    assert sum("were moved" in text for text in told) == 1
    assert "a corner of body 'block' by 10 um onto a side of body 'slab' at (4 m, 10 um)" in " ".join(told)


def tunnel(x: float, y: float, tips: str = "end") -> dict[str, Any]:
    """A joint from near the wall of a tunnel of 2 m into the rock."""
    shape = {"rectangle": {"center": [0, 0], "width": 40, "height": 40}}
    scene = with_body({**shape, "holes": [{"disk": {"center": [0, 0], "radius": 2}}]})
    path = {"points": [[x, y], [4, 4.5]]}
    scene["cracks"] = {"joint": {"path": path, "tips": tips, "contact": {"friction": 0.5, "cohesion": 0}}}
    scene["supports"] = held("rock")
    scene["loads"] = [{"on": {"body": "rock", "edge": "top"}, "traction": [0, -1e6]}]
    return {**scene, "numerics": {"spacing": 1}}


@pytest.mark.parametrize("tips", ["end", "both"])
@pytest.mark.parametrize("x", [1.41421, 1.4142135623731, 1.414215])
def test_joint_that_ends_beside_a_wall_ends_on_it(x: float, tips: str, tmp_path: Path):
    """Neither refused nor taken for a free tip; where it was moved, it is told, and no tip of `both` is left there."""
    if tips == "both" and abs(x - np.sqrt(2.0)) < 1e-8:
        return  # an end on the wall by intent: a tip there is a fault, as ever
    case = load(tmp_path, tunnel(x, x, tips))
    (crack,) = case.cracks
    assert not crack.tip_at_start
    np.testing.assert_allclose(crack.points[0], np.sqrt(2.0), rtol=1e-4)
    corner = case.bodies[0].rings[1].points
    assert np.hypot(*(corner - crack.points[0]).T).min() < 1e-3
    solution = crackgrow.solve(case)
    assert solution.tips["tip"].tolist() == ["end"]
    told = [text for text in solution.warnings if "were moved" in text]
    assert len(told) == len(case.moved) == int(abs(x - np.sqrt(2.0)) > 1e-8)


def test_an_end_too_far_off_to_be_moved_is_cut_off_at_the_wall(tmp_path: Path):
    case = load(tmp_path, tunnel(1.41, 1.41))
    assert case.moved == ()
    (cut,) = case.cut
    assert (cut.crack, cut.why) == ("joint", "outside of the rock")
    assert cut.length == pytest.approx(0.00596, rel=0.02)
    assert np.hypot(*case.cracks[0].points[0]) == pytest.approx(2.0, rel=1e-4)
    assert not case.cracks[0].tip_at_start


@pytest.mark.parametrize("off", [3e-5, -3e-5, 1e-8, 0.0])
def test_ends_on_cracks_that_end_on_walls_follow_them(off: float, tmp_path: Path):
    """c ends on b, b on a, a on the outline: each is moved, and the ends stay on the lines that moved."""
    scene = with_body(rectangle(-5, -5, 10, 10))
    points = {
        "c": [[-2 + off, 1.5], [1 + off, 1.5]],
        "b": [[1, 4], [1, 0.5 + off]],
        "a": [[-5 + off, -1], [5 - off, 1.5 - off]],
    }
    scene["cracks"] = {
        name: {"path": {"points": line}, "tips": "start" if name != "a" else "none", "contact": "none"}
        for name, line in points.items()
    }
    case = load(tmp_path, {**scene, "supports": held("rock")})
    c, b, a = (crack.points for crack in case.cracks)
    assert a[[0, -1], 0].tolist() == [-5.0, 5.0]
    for end, line in ((c[-1], b), (b[-1], a)):
        step = line[1] - line[0]
        apart = (end - line[0])[0] * step[1] - (end - line[0])[1] * step[0]
        assert abs(apart) <= 1e-14 * np.hypot(*step)
    assert [(crack.tip_at_start, crack.tip_at_end) for crack in case.cracks] == [(True, False)] * 2 + [(False, False)]


def test_short_cracks_and_details_are_not_bent_by_what_is_near(tmp_path: Path):
    """A crack of a millimetre that starts a reach from a wall stays where it is."""
    scene = with_body(rectangle(-5, -5, 10, 10))
    scene["cracks"] = {"a": {"path": {"points": [[-4.99995, 0], [-4.999, 0]]}, "contact": "none"}}
    case = load(tmp_path, {**scene, "supports": held("rock")})
    assert case.cracks[0].points[0, 0] == -4.99995
    assert case.moved == ()


def test_case_as_it_ran_is_moved_alike(tmp_path: Path):
    case = load(tmp_path, tunnel(1.41421, 1.41421))
    path = tmp_path / "again.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    again = load_case(path)
    assert again.moved == case.moved != ()
    np.testing.assert_array_equal(again.cracks[0].points, case.cracks[0].points)
