"""Cracks: where they meet and end, what nearly touches, which is brought together, arcs and splines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.plan.cost import sizes_of
from tests.unit.case.scenes import blocks, changed, compression, fault, held, joint, load, rectangle, reread, with_body

# --- cracks that meet ------------------------------------------------------------------------------------------------

SIZE = 10.0 * np.sqrt(2.0)  # m, diagonal of the plate
TOLERANCE = 1e-9 * SIZE  # m; rounding: places no farther apart are one
Line = tuple[list[list[float]], str]


def plate(**cracks: Line) -> dict[str, Any]:
    """A plate of 10 x 10 m round the origin with cracks: points in m, and tips."""
    named = {
        name: {"path": {"points": points}, "tips": tips, "contact": "none"} for name, (points, tips) in cracks.items()
    }
    return {**with_body(rectangle(-5, -5, 10, 10)), "supports": held("rock"), "units": {"length": "m"}, "cracks": named}


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.5])
@pytest.mark.parametrize("off", [-0.9, 0.9])
def test_an_end_within_the_tolerance_of_a_crack_lies_on_it(angle: float, off: float, tmp_path: Path):
    """Short of the other crack or beyond it; it is moved there."""
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    points = [(0.3 * along + off * TOLERANCE * across).tolist(), (across + along).tolist()]
    scene = plate(a=([(-2 * along).tolist(), (2 * along).tolist()], "both"), b=(points, "both"))
    assert "the tip at the start" in fault(tmp_path, scene)[1]
    scene["cracks"]["b"]["tips"] = "end"
    case = load(tmp_path, scene)
    np.testing.assert_allclose(case.cracks[1].points, [0.3 * along, points[1]], atol=1e-15)
    assert case.moved == ()  # no farther than rounding may be


# --- what nearly touches: brought together by a tolerance of the scene, the same at every spacing -------------------


def turned(points: list[list[float]], angle: float, digits: int) -> list[list[float]]:
    """Points turned about the origin, as one types them: with so many digits."""
    cos, sin = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    return [[float(f"{value:.{digits}g}") for value in (x * cos - y * sin, x * sin + y * cos)] for x, y in points]


def incline(angle: float, digits: int) -> dict[str, Any]:
    """A block of 2 m on a slab at an angle; neither side of the contact has its corners on those of the other."""
    slab = [[0.0, -1.0], [10.0, -1.0], [10.0, 0.0], [0.0, 0.0]]
    block = [[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [4.0, 2.0]]
    scene = blocks(slab={"polygon": turned(slab, angle, digits)}, block={"polygon": turned(block, angle, digits)})
    scene["bodies"]["block"]["material"]["density"] = "2500 kg/m^3"
    return changed(
        scene,
        interfaces=joint("slab block", contact={"friction": 0.7, "cohesion": 0}),
        supports=[{"on": {"body": "slab", "edge": "0"}, "displacement": {"x": 0, "y": 0}}],
        loads=[{"body": "block", "gravity": [0, "-9.81 m/s^2"]}],
    )


@pytest.mark.physics
@pytest.mark.parametrize("digits", [5, 9])
def test_block_on_an_incline_holds_however_its_corners_are_typed(digits: int, tmp_path: Path):
    """At a coarse spacing it is solved; finer ones need its cover alone."""
    case = load(tmp_path, incline(30.0, digits), "numerics.spacing=0.25")
    reactions = crackgrow.solve(case).reactions
    (weight,) = reactions["force_y"][reactions["where"] == "slab/block"]
    assert weight == pytest.approx(-4.0 * 2500 * 9.81, rel=1e-4)
    for spacing in (0.1, 0.05, 0.02):
        finer = load(tmp_path, incline(30.0, digits), f"numerics.spacing={spacing}")
        assert sizes_of(finer).n_contact > 1.0 / spacing


@pytest.mark.physics
def test_side_with_a_corner_more_keeps_its_name_and_its_places(tmp_path: Path):
    scene = incline(0.0, 15)
    scene["bodies"]["block"]["shape"] = {"polygon": [[4, 1e-5], [6, 2e-5], [6, 2], [4, 2]]}
    scene["loads"].append({"on": {"body": "slab", "edge": "2", "from": 1, "to": 5}, "traction": [0, -1]})
    case = load(tmp_path, scene, "numerics.spacing=0.25")
    slab = case.bodies[0]
    assert slab.outline.tolist() == [[0, -1], [10, -1], [10, 0], [6, 2e-5], [4, 1e-5], [0, 0]]
    assert slab.rings[0].edge_names == ("0", "1", "2", "2", "2", "3")
    region = case.loads[1].region
    sides = np.stack([slab.outline, np.roll(slab.outline, -1, axis=0)], axis=1)[region.sides]
    places = sides[:, :1] + region.limits[:, :, None] * (sides[:, 1:] - sides[:, :1])
    np.testing.assert_allclose(places[[0, -1], [0, -1], 0], [5.0, 1.0], atol=1e-9)
    told = crackgrow.solve(case).warnings
    assert sum("were moved" in text for text in told) == 1
    assert "a corner of body 'block' by 10 um onto a side of body 'slab' at (4 m, 10 um)" in " ".join(told)


def tunnel(x: float, y: float, tips: str) -> dict[str, Any]:
    """A joint from near the wall of a tunnel of 2 m into the rock."""
    scene = with_body({**rectangle(-20, -20, 40, 40), "holes": [{"disk": {"center": [0, 0], "radius": 2}}]})
    joint = {"path": {"points": [[x, y], [4, 4.5]]}, "tips": tips, "contact": {"friction": 0.5, "cohesion": 0}}
    loads = [{"on": {"body": "rock", "edge": "top"}, "traction": [0, -1e6]}]
    return changed(scene, cracks={"joint": joint}, supports=held("rock"), loads=loads, numerics={"spacing": 1})


@pytest.mark.physics
@pytest.mark.parametrize(("x", "tips", "moved"), [
    (1.41421, "both", 1), (1.4142135623731, "end", 0), (1.414215, "end", 1)
])  # fmt: skip
def test_joint_that_ends_beside_a_wall_ends_on_it(x: float, tips: str, moved: int, tmp_path: Path):
    """Neither refused nor taken for a free tip; where it was moved, it is told, and no tip of `both` is left there."""
    case = load(tmp_path, tunnel(x, x, tips))
    (crack,) = case.cracks
    np.testing.assert_allclose(crack.points[0], np.sqrt(2.0), rtol=1e-4)
    solution = crackgrow.solve(case)
    assert solution.tips["tip"].tolist() == ["end"]
    assert sum("were moved" in text for text in solution.warnings) == len(case.moved) == moved
    again = reread(case, tmp_path)
    assert again.moved == case.moved
    np.testing.assert_array_equal(again.cracks[0].points, crack.points)


@pytest.mark.parametrize("off", [3e-5, -3e-5, 1e-8, 0.0])
def test_ends_on_cracks_that_end_on_walls_follow_them(off: float, tmp_path: Path):
    """c ends on b, b on a, a on the outline: each is moved, and the ends stay on the lines that moved."""
    scene = plate(
        c=([[-2 + off, 1.5], [1 + off, 1.5]], "start"),
        b=([[1, 4], [1, 0.5 + off]], "start"),
        a=([[-5 + off, -1], [5 - off, 1.5 - off]], "none"),
    )
    c, b, a = (crack.points for crack in load(tmp_path, scene).cracks)
    assert a[[0, -1], 0].tolist() == [-5.0, 5.0]
    for end, line in ((c[-1], b), (b[-1], a)):
        step = line[1] - line[0]
        apart = (end - line[0])[0] * step[1] - (end - line[0])[1] * step[0]
        assert abs(apart) <= 1e-14 * np.hypot(*step)


@pytest.mark.parametrize(("start", "end"), [(0.0, 180.0), (180.0, 0.0), (-30.0, 40.0), (0.0, 2.0)])
def test_an_arc_lies_on_its_circle_and_ends_along_it(start: float, end: float):
    arc = f"cracks.flaw.path={{arc: {{center: [1, -2], radius: 3, from: {start}, to: {end}}}}}"
    points = compression(arc).cracks[0].points * 1e3 - [1.0, -2.0]
    np.testing.assert_allclose(np.hypot(*points.T), 3.0, rtol=1e-4)
    ends = np.deg2rad([start, end])
    np.testing.assert_allclose(points[[0, -1]], 3.0 * np.stack([np.cos(ends), np.sin(ends)], axis=1), atol=1e-9)
    along = np.sign(end - start) * np.stack([-np.sin(ends), np.cos(ends)], axis=1)
    steps = np.stack([points[1] - points[0], points[-1] - points[-2]])
    np.testing.assert_allclose(steps / np.hypot(*steps.T)[:, None], along, atol=1e-3)


def test_a_spline_through_places_of_a_parabola_is_that_parabola():
    places = [[x, 0.1 * x * x] for x in range(-6, 6)]
    points = compression(f"cracks.flaw.path={{spline: {places}}}").cracks[0].points * 1e3
    assert max(np.hypot(*(points - place).T).min() for place in places) < 1e-12
    assert np.abs(points[:, 1] - 0.1 * points[:, 0] ** 2).max() < 0.01
