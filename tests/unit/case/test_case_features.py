"""Lengths of a scene that a lattice must resolve: what counts as one, what does not, and what it gives."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.arrays import Floats
from crackgrow.case.features import Kind, feature_lengths
from tests.unit.case.scenes import MATERIAL, load

BOX = [[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]]
L_SHAPE = [[0.0, 0.0], [12.0, 0.0], [12.0, 2.0], [2.0, 2.0], [2.0, 12.0], [0.0, 12.0]]
V_NOTCHED = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0], [-10.0, 1.0], [-8.0, 0.0], [-10.0, -1.0]]


@dataclass(frozen=True)
class _Ring:
    points: Floats


@dataclass(frozen=True)
class _Body:
    rings: list[_Ring]
    name: str = "rock"


def circle(n: int, radius: float = 2.0, x: float = 0.0, scatter: float = 0.0) -> Floats:
    """A hole (n, 2) round (x, 0), which lies on the right of its outline; `scatter` makes radii and angles uneven."""
    rng = np.random.default_rng(7)
    angles = np.linspace(0.0, -2.0 * np.pi, n, endpoint=False)
    if scatter:
        angles = -np.sort(rng.uniform(0.0, 2.0 * np.pi, n))
    radii = radius * (1.0 + scatter * rng.uniform(-1.0, 1.0, n))
    return np.column_stack([x + radii * np.cos(angles), radii * np.sin(angles)])


def shortest(kind: Kind, *rings: Any) -> float:
    """The shortest length of a kind that a body with these rings has, inf if none."""
    lengths = feature_lengths(_Body([_Ring(np.asarray(ring, dtype=float)) for ring in rings]))
    return min((length.metres for length in lengths if length.kind == kind), default=np.inf)


def turned(points: Any, angle: float) -> Floats:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(points) @ np.array([[cos, sin], [-sin, cos]])


def divided(points: Any, parts: int) -> Floats:
    """A ring with every side in so many parts."""
    ring = np.asarray(points)
    return np.concatenate(
        [np.linspace(a, b, parts, endpoint=False) for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    )


@pytest.mark.parametrize("n", [8, 12, 36, 360, 2000])
def test_round_hole_counts_by_its_diameter_however_many_sides_it_has(n: int):
    assert shortest("feature", BOX, circle(n)) == pytest.approx(4.0, rel=0.08)


def test_uneven_and_rough_sides_of_a_hole_are_no_short_lengths():
    assert shortest("feature", BOX, circle(500, scatter=0.004)) == pytest.approx(4.0, rel=0.02)


def test_rough_outline_has_no_features():
    x = np.linspace(20.0, -20.0, 2000)
    y = 20.0 + 0.1 * np.random.default_rng(1).uniform(-1.0, 1.0, len(x))
    assert shortest("feature", [*BOX[:2], *np.column_stack([x, y])]) == np.inf


def test_slot_counts_by_its_width():
    assert shortest("feature", BOX, [[-6.0, -0.1], [-6.0, 0.1], [6.0, 0.1], [6.0, -0.1]]) == pytest.approx(0.2)


def test_round_notch_counts_by_its_diameter():
    angles = np.linspace(np.pi / 2, -np.pi / 2, 60)
    notch = np.column_stack([-20.0 + 1.5 * np.cos(angles), 1.5 * np.sin(angles)])
    assert shortest("feature", [*BOX, *notch]) == pytest.approx(3.0, rel=0.1)


def test_sharp_notch_counts_by_its_sides_and_convex_corners_do_not():
    assert shortest("feature", V_NOTCHED) == pytest.approx(np.hypot(2.0, 1.0), rel=0.1)
    assert shortest("feature", BOX) == np.inf


@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 2])
@pytest.mark.parametrize("parts", [1, 30])
def test_bridges_of_rock_do_not_depend_on_direction_or_straight_corners(angle: float, parts: int):
    assert shortest("bridge", turned(divided(L_SHAPE, parts), angle)) == pytest.approx(2.0)
    assert shortest("bridge", BOX, circle(360, x=-2.5), circle(360, x=2.5)) == pytest.approx(1.0, rel=1e-3)
    assert shortest("bridge", BOX, circle(360, x=17.5)) == pytest.approx(0.5, rel=1e-3)


def _pressed(width: float, holes: list[Any], loads: list[Any]) -> dict[str, Any]:
    half = width / 2
    shape = {"rectangle": {"center": [0, 0], "width": width, "height": width}, "holes": holes}
    return {
        "title": "a block",
        "units": {"length": "m", "stress": "MPa"},
        "plane": "strain",
        "bodies": {"rock": {"shape": shape, "material": dict(MATERIAL)}},
        "supports": [
            {"at": [-half, -half], "displacement": {"x": 0, "y": 0}},
            {"at": [half, -half], "displacement": {"y": 0}},
        ],
        "loads": loads,
        "numerics": {"spacing": "auto"},
    }


def _in_situ(sigma_h: float, sigma_v: float) -> list[dict[str, Any]]:
    tractions = {"left": [sigma_h, 0], "right": [-sigma_h, 0], "bottom": [0, sigma_v], "top": [0, -sigma_v]}
    return [{"on": {"body": "rock", "edge": edge}, "traction": traction} for edge, traction in tractions.items()]


@pytest.mark.parametrize(("accuracy", "off"), [("draft", 4.0), ("standard", 1.5)])
def test_stress_at_a_tunnel_is_kirschs(accuracy: str, off: float, tmp_path: Path):
    """Kirsch: 3 sigma_h - sigma_v at the crown, 3 sigma_v - sigma_h at the wall; the block's sides add up to 1 MPa."""
    scene = _pressed(40.0, [{"disk": {"center": [0, 0], "radius": 2}}], _in_situ(10, 20))
    solution = crackgrow.solve(load(tmp_path, scene, f"numerics.accuracy={accuracy}"))
    wall, crown = 1e-6 * solution.stress_at([[2.002, 0.0], [0.0, 2.002]])
    assert [wall[1], wall[0], crown[0], crown[1]] == pytest.approx([-50.0, 0.0, -10.0, 0.0], abs=off)


def test_displacement_under_a_loaded_part_is_that_of_a_fine_lattice(tmp_path: Path):
    loads = [
        {"on": {"body": "rock", "edge": "top", "from": -1, "to": 1}, "traction": [0, -10]},
        {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, 1]},
    ]
    scene = _pressed(20.0, [], loads)
    found = [crackgrow.solve(load(tmp_path, scene, *more)) for more in ([], ["numerics.spacing=0.2"])]
    assert found[0].case.numerics.spacing == 2.0
    depressed, reference = (solution.displacement_at([[0.0, 10.0]])[0, 1] for solution in found)
    assert depressed == pytest.approx(reference, rel=0.02)


def test_parts_that_follow_each_other_count_as_one(tmp_path: Path):
    parts = [
        {"on": {"body": "rock", "edge": "hole0", "from": start, "to": start + 10}, "traction": [0, 1]}
        for start in range(0, 360, 10)
    ]
    scene = _pressed(40.0, [{"disk": {"center": [0, 0], "radius": 2}}], [])
    uniform = "numerics.refine={tips: 0, kinks: 0, corners: 0}"
    whole = load(tmp_path, scene, uniform).numerics
    assert load(tmp_path, {**scene, "loads": parts}, uniform).numerics.spacing == whole.spacing
    few = load(tmp_path, {**scene, "loads": parts[:2]}, uniform).numerics
    assert few.auto_rule == "loaded part of hole0 of body 'rock' / 2"
    assert few.spacing == pytest.approx(2.0 * np.deg2rad(20.0) / 2, rel=1e-3)


def test_short_interface_counts(tmp_path: Path):
    cap = {"polygon": [[-0.2, 0], [0.2, 0], [5, 6], [-5, 6]]}
    base = {"rectangle": {"center": [0, -5], "width": 20, "height": 10}}
    scene = _pressed(1.0, [], [])
    scene["bodies"] = {name: {"shape": shape, "material": MATERIAL} for name, shape in (("base", base), ("cap", cap))}
    scene["interfaces"] = [{"between": ["cap", "base"], "contact": {"friction": 0.5, "cohesion": 0}}]
    scene["supports"] = [{"on": {"body": "base", "edge": "bottom"}, "displacement": {"x": 0, "y": 0}}]
    assert load(tmp_path, scene).numerics.spacing == pytest.approx(0.6)
    numerics = load(tmp_path, scene, "numerics.refine={corners: 0}").numerics
    assert numerics.spacing == pytest.approx(0.1)
    assert numerics.auto_rule == "interface between bodies 'base' and 'cap' / 4"


def test_spacing_given_by_hand_is_told_where_there_is_a_hole(tmp_path: Path):
    scene = _pressed(40.0, [{"disk": {"center": [0, 0], "radius": 2}}], _in_situ(10, 20))
    told = crackgrow.solve(load(tmp_path, scene, "numerics.spacing=2")).warnings
    assert len(told) == 1
    assert "no error is measured" in told[0]
    assert crackgrow.solve(load(tmp_path, scene, "numerics.accuracy=draft")).warnings == ()


def test_spacing_that_is_too_fine_tells_what_forces_it_and_a_way_out(tmp_path: Path):
    scene = _pressed(40.0, [{"disk": {"center": [0, 0], "radius": 0.05}}], _in_situ(10, 20))
    with pytest.raises(crackgrow.CaseError) as caught:
        load(tmp_path, scene, "numerics.refine={corners: 0}")
    (fault,) = caught.value.faults
    assert "(auto: width of hole0 of body 'rock' / 8)" in fault.message
    assert "give a spacing by hand, of 0.021 m or more, or a smaller body" in fault.message
    load(tmp_path, scene, "numerics.spacing=0.021")
    assert load(tmp_path, scene).numerics.spacing == 4.0  # small cells at the hole alone
