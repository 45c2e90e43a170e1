"""Cracks that cross, touch, branch and run through a body: what is allowed, and the words for what is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow.case import Case
from crackgrow.case.meetings import meeting_places
from tests.unit.case.scenes import changed, fault, faults, held, load, rectangle, with_body

SIZE = 10.0 * np.sqrt(2.0)  # m, diagonal of the plate
TOLERANCE = 1e-9 * SIZE  # m; rounding: places no farther apart are one
REACH = 1e-5 * SIZE  # m; what comes nearer is moved together
HALF = np.sqrt(0.5)


def plate(**cracks: tuple[list[list[float]], str]) -> dict[str, Any]:
    """A plate of 10 x 10 m round the origin with cracks: points in m, and tips."""
    named = {
        name: {"path": {"points": points}, "tips": tips, "contact": "none"} for name, (points, tips) in cracks.items()
    }
    scene = changed(with_body(rectangle(-5, -5, 10, 10)), supports=held("rock"), units={"length": "m"})
    return changed(scene, cracks=named)


MAIN = ([[-2, 0], [2, 0]], "both")

MEETINGS = {
    "X": ({"a": MAIN, "b": ([[0, -1], [0, 1]], "both")}, [[0, 0]]),
    "X at vertices": ({"a": ([[-2, 0], [0, 0], [2, 1]], "both"), "b": ([[0, -1], [0, 0], [0, 1]], "both")}, [[0, 0]]),
    "X twice": ({"a": MAIN, "b": ([[-1, -1], [0, 1], [1, -1]], "both")}, [[-0.5, 0], [0.5, 0]]),
    "touch with a vertex": ({"a": MAIN, "b": ([[-1, 1], [0, 0], [1, 1]], "both")}, [[0, 0]]),
    "T": ({"a": MAIN, "b": ([[1, 0], [1, 1]], "end")}, [[1, 0]]),
    "T on a vertex": ({"a": ([[-2, 0], [0, 0], [2, 1]], "both"), "b": ([[0, -1], [0, 0]], "start")}, [[0, 0]]),
    "T with a line of many segments": (
        {"a": MAIN, "b": ([[1, 0], [1.2, 0.5], [1, 1], [1.2, 1.5], [1, 2]], "end")},
        [[1, 0]],
    ),
    "V": ({"a": ([[-2, 0], [2, 0]], "start"), "b": ([[2, 0], [3, 1]], "end")}, [[2, 0]]),
    "V against a tip that is none": ({"a": ([[-2, 0], [2, 0]], "none"), "b": ([[3, 1], [2, 0]], "start")}, [[2, 0]]),
    "straight on": ({"a": ([[-2, 0], [2, 0]], "start"), "b": ([[2, 0], [3, 0]], "end")}, [[2, 0]]),
    "branches": (
        {
            "a": ([[-2, 0], [2, 0]], "start"),
            "b": ([[2, 0], [3, 1]], "end"),
            "c": ([[2, 0], [3, -1]], "end"),
            "d": ([[2, 2], [2, -2]], "both"),
        },
        [[2, 0]],
    ),
    "two that enclose a block": (
        {"a": ([[-2, 0], [0, 1], [2, 0]], "none"), "b": ([[-2, 0], [0, -1], [2, 0]], "none")},
        [[-2, 0], [2, 0]],
    ),
    "through the whole body": ({"a": ([[-5, 1], [5, -1]], "none"), "b": ([[0, -5], [0, 5]], "none")}, [[0, 0]]),
    "from the outline": ({"a": ([[-5, 1], [0, 0]], "end"), "b": ([[3, 5], [3, 0], [4, 0]], "end")}, []),
    "at a corner and at one place of the outline": (
        {"a": ([[-5, -5], [0, 0]], "end"), "b": ([[5, 0], [4, 1]], "end"), "c": ([[5, 0], [4, -1]], "end")},
        [[5, 0]],
    ),
    "apart": ({"a": MAIN, "b": ([[0, 2 * REACH], [0, 1]], "both")}, []),
}


@pytest.mark.parametrize("name", MEETINGS)
def test_cracks_may_meet(name: str, tmp_path: Path):
    cracks, places = MEETINGS[name]
    case = load(tmp_path, plate(**cracks))
    found = meeting_places(case)
    np.testing.assert_allclose(found[np.lexsort(found.T[::-1])], np.reshape(places, (-1, 2)), atol=TOLERANCE)
    assert [crack.points.tolist() for crack in case.cracks] == [points for points, _ in cracks.values()]


def test_every_tip_at_a_meeting_is_a_fault(tmp_path: Path):
    found = faults(tmp_path, plate(a=MAIN, b=([[2, 0], [3, 1]], "both"), c=([[2, 0], [-2, 0.5], [-2, 0]], "both")))
    assert [(each.key.split(".")[1], each.message.partition(" lies")[0]) for each in found] == [
        ("a", "the tip at the start (-2 m, 0 m)"),
        ("a", "the tip at the end (2 m, 0 m)"),
        ("b", "the tip at the start (2 m, 0 m)"),
        ("c", "the tip at the start (2 m, 0 m)"),
        ("c", "the tip at the end (-2 m, 0 m)"),
    ]
    remedies = [each.message.rpartition("`: `")[2] for each in found]
    assert remedies == ["tips: none`", "tips: none`", "tips: end`", "tips: none`", "tips: none`"]


def test_faults_are_in_the_units_of_the_case(tmp_path: Path):
    scene = plate(a=MAIN, b=([[1, 0], [1, 1]], "both"))
    assert "(1 cm, 0 cm) lies on crack 'a'" in fault(tmp_path, scene, "units.length=cm", "numerics.spacing=0.1")[1]


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, 1.5])
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
    assert len(meeting_places(case)) == 1


def test_many_cracks_through_one_place_meet_once(tmp_path: Path):
    """Each ends or passes within half a tolerance of the place."""
    rng = np.random.default_rng(6)
    cracks = {}
    for k, angle in enumerate(np.arange(12) * np.pi / 6.5):
        way = np.array([np.cos(angle), np.sin(angle)])
        near = np.array([0.3, 0.7]) + 0.5 * TOLERANCE * rng.uniform(-HALF, HALF, 2)
        cracks[f"c{k}"] = ([(near - k % 2 * way).tolist(), (near + 2 * way).tolist()], "both" if k % 2 else "end")
    (place,) = meeting_places(load(tmp_path, plate(**cracks)))
    np.testing.assert_allclose(place, [0.3, 0.7], atol=10 * TOLERANCE)


def test_an_end_beyond_the_tolerance_of_a_crack_is_a_tip(tmp_path: Path):
    short = load(tmp_path, plate(a=MAIN, b=([[0, 1.1 * REACH], [0, 1]], "both")))
    beyond = load(tmp_path, plate(a=MAIN, b=([[0, -1.1 * REACH], [0, 1]], "both")))
    assert [len(meeting_places(case)) for case in (short, beyond)] == [0, 1]
    assert short.cracks[1].tip_at_start


def test_cracks_that_lie_nearly_along_each_other(tmp_path: Path):
    """Within the tolerance over a length is along; meeting at a small angle is not."""
    near = plate(a=MAIN, b=([[-1, 0.5 * TOLERANCE], [1, 0.5 * TOLERANCE]], "none"))
    assert "runs along crack 'a'" in fault(tmp_path, near)[1]
    load(tmp_path, plate(a=MAIN, b=([[-1, 1.1 * REACH], [1, 1.1 * REACH]], "both")))
    load(tmp_path, plate(a=MAIN, b=([[-1, 0], [1, 10 * REACH]], "end")))
    load(tmp_path, plate(a=MAIN, b=([[-1, -10 * REACH], [1, 10 * REACH]], "both")))


def random_cracks(n: int, seed: int) -> dict[str, Any]:
    """Straight cracks of up to 0.4 m anywhere in the plate."""
    rng = np.random.default_rng(seed)
    starts, angles = rng.uniform(-4.5, 4.5, (n, 2)), rng.uniform(0, 2 * np.pi, n)
    ends = starts + rng.uniform(0.1, 0.4, n)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return {f"c{k}": ([starts[k].tolist(), ends[k].tolist()], "both") for k in range(n)}


def crossings(case: Case) -> np.ndarray:
    """Places (n, 2) m where lines cross, pair by pair."""
    lines = [shapely.LineString(crack.points) for crack in case.cracks]
    found = [a.intersection(b) for k, a in enumerate(lines) for b in lines[:k] if a.intersects(b)]
    return np.array([(point.x, point.y) for point in found])


def test_meeting_places_of_random_cracks_are_their_crossings(tmp_path: Path):
    case = load(tmp_path, plate(**random_cracks(400, 7)))
    expected, found = crossings(case), meeting_places(case)
    assert len(expected) > 10
    np.testing.assert_allclose(
        found[np.lexsort(found.T)], expected[np.lexsort(expected.T)], atol=1e-12
    )  # each a few roundings of 10 m
