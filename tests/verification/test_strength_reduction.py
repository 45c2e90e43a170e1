"""The factor of safety by strength reduction against limit equilibrium, in closed form.

A block on a plane at an angle t with friction mu and cohesion c on an area A, of weight W, with water that lifts it by
U: F = (c A + mu (W cos t - U)) / (W sin t). It is exact for a rigid block, and for any, as long as it slides as one.
"""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import numpy as np
import pytest
import shapely
import yaml

from crackgrow.__main__ import main
from crackgrow.case import load_case
from crackgrow.errors import CaseError, FreePieceError
from crackgrow.run.result import RunEnd, StepResult
from tests.verification.solutions import Solved, solve_case
from tests.whole_run import whole_run

SLOPE, WEIGHT = np.deg2rad(35.0), 2500.0 * 9.81  # rad, N/m^3

INCLINE = """
title: a block on an incline
plane: strain
bodies:
  wedge:
    shape: {polygon: [[0, 0], [8, 0], [8, 4.618802153517006]]}
    material: {young: 1e10, poisson: 0.2}
  block:
    shape: {polygon: [[2.598076, 1.5], [4.330127, 2.5], [3.830127, 3.366025], [2.098076, 2.366025]]}
    material: {young: 1e10, poisson: 0.2, density: 2500}
interfaces: [{between: [wedge, block], contact: {friction: 0.8, cohesion: 0}}]
supports: [{on: {body: wedge, edge: 0}, displacement: {x: 0, y: 0}}]
loads: [{body: block, gravity: [0, -9.81]}]
loading: strength_reduction
numerics: {spacing: 0.5}
output: {frames: none, figures: false}
"""

JOINT = np.array([[0.36397, 1.0], [0.36397 + 6.0 / np.tan(SLOPE), 7.0]]).round(9)
TOP = [[JOINT[1, 0], 10.0], [3.6397, 10.0]]
BACK = np.array([JOINT[1], TOP[0]])
AREA = shapely.Polygon([*JOINT, *TOP]).area
LENGTH = float(np.hypot(*(JOINT[1] - JOINT[0])))

ROCK_SLOPE = f"""
title: a slope of 10 m with a joint to a tension crack
plane: strain
bodies:
  rock:
    shape: {{polygon: [[-8, -6], [20, -6], [20, 10], [3.6397, 10], [0, 0], [-8, 0]]}}
    material: {{young: 1e10, poisson: 0.2, density: 2500}}
cracks:
  joint: {{path: {{points: {JOINT.tolist()}}}, tips: none, contact: {{CONTACT}}}}
  back: {{path: {{points: {BACK.tolist()}}}, tips: none, contact: {{friction: 0.5, cohesion: 0}}}}
supports: [{{on: {{body: rock, edge: 0}}, displacement: {{x: 0, y: 0}}}}]
loads:
  - {{body: rock, gravity: [0, -9.81]}}
  - {{crack: joint, pressure: WATER}}
loading: strength_reduction
numerics: {{spacing: 1}}
output: {{frames: none, figures: false}}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def run(folder: Path, text: str) -> tuple[list[StepResult], RunEnd]:
    return whole_run(load_case(written(folder, text)))


@pytest.mark.parametrize("friction", [0.8, 0.4])
def test_block_on_an_incline(friction: float, tmp_path: Path) -> None:
    """With less friction than the slope it does not hold as it is, and the last stable state is all there is."""
    steps, end = run(tmp_path, INCLINE.replace("friction: 0.8", f"friction: {friction}"))
    assert end.safety is not None
    assert end.safety.factor == pytest.approx(friction / np.tan(np.pi / 6.0), rel=2e-3)
    assert end.safety.factor < end.safety.fails_at < 1.001 * end.safety.factor
    assert "body 'block'" in end.safety.mechanism
    assert "it slides along 'wedge/block'" in end.safety.mechanism
    assert len(steps) == (2 if friction > 0.577 else 1)
    last = steps[-1].contact
    ratio = np.abs(last.tangential_traction).sum() / np.abs(last.normal_traction).sum()
    assert ratio == pytest.approx(np.tan(np.pi / 6.0), rel=1e-3)


@pytest.mark.parametrize(
    ("contact", "friction", "cohesion", "pressure", "water"),
    [
        ("friction: 0.9, cohesion: 0", 0.9, 0.0, "0", 0.0),
        ("friction: 0.9, cohesion: 0", 0.9, 0.0, "10 kPa", 1e4),
        ("friction: 0.9, cohesion: 0", 0.9, 0.0, '"9810*min(y - 1, 7 - y)"', 9810.0 * 1.5),
        ("friction: 0.6, cohesion: 1e4, cohesion_after_slip: kept", 0.6, 1e4, "0", 0.0),
    ],
    ids=["friction", "water", "water of a triangle", "cohesion"],
)
def test_slope_with_a_joint(
    contact: str, friction: float, cohesion: float, pressure: str, water: float, tmp_path: Path
) -> None:
    """The triangle is that of Hoek and Bray: from nothing at both ends to the most half way."""
    began = time.process_time()
    text = ROCK_SLOPE.replace("CONTACT", contact).replace("WATER", pressure)
    steps, end = run(tmp_path, text)
    weight, normal = WEIGHT * AREA, WEIGHT * AREA * np.cos(SLOPE) - water * LENGTH
    expected = (cohesion * LENGTH + friction * normal) / (weight * np.sin(SLOPE))
    assert end.safety is not None
    assert end.safety.factor == pytest.approx(expected, rel=2e-3)
    assert "it slides along 'joint'" in end.safety.mechanism
    assert len(steps) == 2
    assert time.process_time() - began < 10.0


def test_safety_is_in_the_summary(tmp_path: Path) -> None:
    path = written(tmp_path, INCLINE)
    assert main(["run", str(path), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "completed"
    assert summary["safety"]["factor"] == pytest.approx(0.8 / np.tan(np.pi / 6.0), rel=2e-3)
    assert summary["safety"]["mechanism"] in summary["stop_reason"]
    assert load_case(tmp_path / "out" / "case.yaml").loading is not None


FLAT = """
title: a block on a floor
plane: strain
bodies: {block: {shape: {rectangle: {center: [0, 0.5], width: 1, height: 1}}, material: {young: 1e9, poisson: 0.2}}}
supports: [{on: {body: block, edge: bottom}, contact: {friction: 0.5, cohesion: 0}}]
loads: [{on: {body: block, edge: top}, traction: [0, -1e5]}]
loading: strength_reduction
numerics: {spacing: 0.25}
output: {frames: none, figures: false}
"""


def test_scene_that_needs_no_strength_does_not_fail(tmp_path: Path) -> None:
    _, end = run(tmp_path, FLAT)
    assert end.safety is not None
    assert np.isinf(end.safety.factor)
    assert "does not fail" in end.reason


def test_scene_that_no_strength_holds_is_told_as_such(tmp_path: Path) -> None:
    with pytest.raises(FreePieceError, match="body 'block'"):
        run(tmp_path, FLAT.replace("[0, -1e5]", "[0, 1e5]"))


def test_a_target_of_K_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(written(tmp_path, FLAT), ["numerics.accuracy=1 %"])
    (fault,) = caught.value.faults
    assert fault.key == "numerics.accuracy"
    assert "wanted: a name" in fault.message


UNIFORM = """
title: a block on a floor under uniform pressure and shear
plane: strain
bodies: {block: {shape: {rectangle: {center: [0, 0.5], width: 2, height: 1}}, material: {young: YOUNG, poisson: 0.25}}}
supports: [{on: {body: block, edge: bottom}, contact: {friction: 0.3, cohesion: 1e4, cohesion_after_slip: AFTER}}]
loads: [TRACTIONS]
loading: strength_reduction
numerics: {spacing: 0.25, contact: {stiffness: STIFFNESS}}
output: {frames: none, figures: false}
"""


@pytest.mark.parametrize("after", ["kept", "lost"])
@pytest.mark.parametrize(("young", "stiffness"), [("1e9", "rigid"), ("1e9", "1"), ("1e13", "1e-3")])
def test_cohesion_under_uniform_traction_is_limit_equilibrium(
    young: str, stiffness: str, after: str, tmp_path: Path
) -> None:
    """All points come to their strength together, however stiff rock and contact are: F = (c + mu p) / tau.

    A uniform stress without strain along the floor has sxx = nu/(1 - nu) syy; shear on the floor is that on the sides.
    """
    p, tau = 2e4, 1e4
    side = p / 3.0
    sides = [("top", [tau, -p]), ("left", [side, -tau]), ("right", [-side, tau])]
    loads = ", ".join(f"{{on: {{body: block, edge: {edge}}}, traction: {list(t)}}}" for edge, t in sides)
    text = UNIFORM.replace("TRACTIONS", loads)
    text = text.replace("YOUNG", young).replace("STIFFNESS", stiffness).replace("AFTER", after)
    _, end = run(tmp_path, text)
    assert end.safety is not None
    assert end.safety.factor == pytest.approx((1e4 + 0.3 * p) / tau, rel=2e-3)
    assert "body 'block'" in end.safety.mechanism
    assert "it slides along 'block.bottom'" in end.safety.mechanism


STACK = """
title: two blocks on a floor under uniform pressure and shear
plane: strain
bodies:
  low: {shape: {rectangle: {center: [0, 0.5], width: 2, height: 1}}, material: {young: 1e9, poisson: 0.25}}
  top: {shape: {rectangle: {center: [0, 1.5], width: 2, height: 1}}, material: {young: 1e9, poisson: 0.25}}
interfaces: [{between: [low, top], contact: {friction: 0.3, cohesion: BETWEEN}}]
supports: [{on: {body: low, edge: bottom}, contact: {friction: 0.3, cohesion: FLOOR}}]
loads:
  - {on: {body: top, edge: top}, traction: [9e3, -18e3]}
  - {on: {body: top, edge: left}, traction: [6e3, -9e3]}
  - {on: {body: top, edge: right}, traction: [-6e3, 9e3]}
  - {on: {body: low, edge: left}, traction: [6e3, -9e3]}
  - {on: {body: low, edge: right}, traction: [-6e3, 9e3]}
loading: strength_reduction
numerics: {spacing: 0.25}
output: {frames: none, figures: false}
"""


@pytest.mark.parametrize(("between", "floor", "slides"), [(9e3, 18e3, "low/top"), (18e3, 9e3, "low.bottom")])
def test_of_a_stack_the_weaker_joint_counts(between: float, floor: float, slides: str, tmp_path: Path) -> None:
    _, end = run(tmp_path, STACK.replace("BETWEEN", str(between)).replace("FLOOR", str(floor)))
    assert end.safety is not None
    assert end.safety.factor == pytest.approx((9e3 + 0.3 * 18e3) / 9e3, rel=2e-3)
    assert f"it slides along '{slides}'" in end.safety.mechanism


def brittle(tmp_path: Path, more: str = "", spacing: float = 0.5) -> RunEnd:
    """A block whose weight presses and shears the incline unevenly: cohesion is lost where it is loaded most first."""
    contact = f"friction: 0.4, cohesion: 1e4{more}"
    text = INCLINE.replace("friction: 0.8, cohesion: 0", contact).replace("spacing: 0.5", f"spacing: {spacing}")
    return run(tmp_path, text)[1]


BLOCK = 2.0 * WEIGHT
LIMIT = (1e4 * 2.0 + 0.4 * BLOCK * np.cos(np.pi / 6.0)) / (BLOCK * np.sin(np.pi / 6.0))
"""Limit equilibrium of that block: all of its cohesion acts at once."""


def test_brittle_cohesion_fails_below_limit_equilibrium_and_says_why(tmp_path: Path) -> None:
    """It is not less than friction alone has, and the end names the body, the joint and the factor of the whole."""
    safety = brittle(tmp_path).safety
    assert safety is not None
    assert 0.4 / np.tan(np.pi / 6.0) < safety.factor < 0.95 * LIMIT
    assert "body 'block' is free to move" in safety.mechanism
    assert "it slides along 'wedge/block'" in safety.mechanism
    assert "contact has lost strength on 'wedge/block'" in safety.mechanism
    told = re.search(r"it would hold up to ([\d.]+):", safety.mechanism)
    assert told is not None
    assert float(told[1]) == pytest.approx(LIMIT, rel=2e-3)


@pytest.mark.parametrize("more", [", cohesion_after_slip: kept", ", weakening_length: 10"])
def test_cohesion_that_slip_does_not_take_is_limit_equilibrium(more: str, tmp_path: Path) -> None:
    safety = brittle(tmp_path, more).safety
    assert safety is not None
    assert safety.factor == pytest.approx(LIMIT, rel=2e-3)
    assert "slides along 'wedge/block'" in safety.mechanism


def test_with_a_weakening_length_cells_do_not_matter(tmp_path: Path) -> None:
    """Where bonds break at once the factor falls with every finer lattice, as at a crack without toughness."""
    ends = [[brittle(tmp_path, more, h).safety for h in (0.25, 0.125)] for more in ("", ", weakening_length: 1e-5")]
    ratios = [second.factor / first.factor for first, second in ends if first and second]
    assert ratios[0] < 0.95
    assert ratios[1] == pytest.approx(1.0, abs=1e-2)


COLUMNS = """
title: a slender column on an incline that leans on a stocky one
plane: strain
bodies:
  base: {shape: {polygon: [[-4, -2], [6, -2], [6, 0], [-4, 0]]}, material: {young: 1e10, poisson: 0.2}}
  low: {shape: {polygon: [[0, 0], [1, 0], [1, 1], [0, 1]]}, material: {young: 1e10, poisson: 0.2, density: 2500}}
  high: {shape: {polygon: [[1, 0], [2, 0], [2, 4], [1, 4]]}, material: {young: 1e10, poisson: 0.2, density: 2500}}
interfaces:
  - {between: [base, low], contact: {friction: 1.2, cohesion: 0}}
  - {between: [base, high], contact: {friction: 1.2, cohesion: 0}}
  - {between: [low, high], contact: {friction: 0.6, cohesion: 0}}
supports: [{on: {body: base, edge: 0}, displacement: {x: 0, y: 0}}]
loads: [{body: low, gravity: GRAVITY}, {body: high, gravity: GRAVITY}]
loading: strength_reduction
numerics: {spacing: SPACING}
output: {frames: none, figures: false}
"""


COLUMNS_SIN, COLUMNS_COS = float(np.sin(np.deg2rad(20.0))), float(np.cos(np.deg2rad(20.0)))
PUSH = 4.0 * (2.0 * COLUMNS_SIN - 0.5 * COLUMNS_COS)
"""Of the high column about its lower corner, 1 m deep: push times height over the weight of the low one, m."""

COLUMNS_LIMIT = 0.6 * PUSH / (PUSH + 0.5 * COLUMNS_SIN - 0.5 * COLUMNS_COS)
"""Factor with the push on the top of the low column (Goodman, Bray 1976). Lower by h, in parts of the height, the push
is 1 / h as large, and so is its friction: the factor is this over h."""


def standing(spacing: float, side: float = 1.0) -> str:
    """The columns on such cells; with a side of -1 as in a mirror."""
    text = COLUMNS.replace("GRAVITY", str([-9.81 * COLUMNS_SIN, -9.81 * COLUMNS_COS]))
    if side > 0.0:
        return text.replace("SPACING", str(spacing))
    scene = yaml.safe_load(text.replace("SPACING", str(spacing)))
    for body in scene["bodies"].values():
        ring = body["shape"]["polygon"]
        body["shape"]["polygon"] = [[-ring[1 - k][0], ring[1 - k][1]] for k in range(len(ring))]  # edge 0 stays first
    for load in scene["loads"]:
        load["gravity"][0] *= -1.0
    return str(yaml.safe_dump(scene))


def test_columns_that_topple_are_named_at_their_limit_equilibrium(tmp_path: Path) -> None:
    """The high one turns about its lower corner and pushes the top of the low one, which turns, too."""
    for spacing in (0.5, 0.125):
        safety = run(tmp_path, standing(spacing))[1].safety
        assert safety is not None
        assert safety.factor == pytest.approx(COLUMNS_LIMIT, rel=1e-3)
        assert re.search(
            r"hold up to 1\.\d+: there body 'low' \(and with it body 'high'\).* turns about", safety.mechanism
        )


@pytest.mark.parametrize(("spacing", "side"), [(0.25, 1.0), (0.1, 1.0), (0.1, -1.0), (0.0625, 1.0)])
def test_columns_hold_by_how_high_the_push_between_them_acts(spacing: float, side: float, tmp_path: Path) -> None:
    """Both turn by the same angle, so that they touch all along: small cells let the rock spread the push downwards."""
    safety = run(tmp_path, standing(spacing, side))[1].safety
    assert safety is not None
    weaker = standing(spacing, side).replace("loading: strength_reduction\n", "")
    for friction in (1.2, 0.6):
        weaker = weaker.replace(f"friction: {friction}", f"friction: {friction / safety.factor}")
    last = solve_case(load_case(written(tmp_path, weaker)))
    forces, places, names = contact_forces(last)
    weight = 9.81 * 2500.0 * np.array([-side * COLUMNS_SIN, -COLUMNS_COS])
    for column, middle, heavy in (("low", (0.5, 0.5), 1.0), ("high", (1.5, 2.0), 4.0)):
        first = np.array([float(name.startswith(column)) - float(name.endswith(column)) for name in names])
        on_it = first[:, None] * forces
        np.testing.assert_allclose(on_it.sum(axis=0), -heavy * weight, atol=1e-6 * WEIGHT)
        turning = cross(places, on_it).sum() + cross(np.array([side * middle[0], middle[1]]), heavy * weight)
        assert abs(turning) < 1e-6 * WEIGHT
    joint = names == "low/high"
    height = (forces[joint, 0] @ places[joint, 1]) / forces[joint, 0].sum()
    assert safety.factor * height == pytest.approx(COLUMNS_LIMIT, rel=1e-3)
    assert safety.factor < 1.03 * COLUMNS_LIMIT


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def contact_forces(solved: Solved) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces (n, 2) N/m on the first of two bodies, where they act (n, 2) m, and the names (n,) of the interfaces."""
    contact, faces = solved.result.contact, solved.solution.faces
    normal = faces.nodes.normal
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    traction = contact.normal_traction[:, None] * normal + contact.tangential_traction[:, None] * along
    forces = -faces.weights[:, None] * solved.scene.lattice.spacing * traction
    places = faces.functions @ (faces.lengths[:, None] * faces.points.points) / faces.weights[:, None]
    return forces, solved.scene.lattice.to_metres(places), np.array(contact.crack)
