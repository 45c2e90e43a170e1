"""Edges and parts of edges: sides of the rings, and where the part begins and ends on each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case.model import EdgeRegion
from tests.unit.case.scenes import fault, held, load, rectangle, with_body

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]
CLOCKWISE = [[0, 0], [0, 3], [4, 3], [4, 0]]
DISK = {"disk": {"center": [1, 2], "radius": 3}}
WEDGE = [[0, 0], [6, 0], [3, 4]]  # a side of length 5 from (6, 0) on, another one back


def region(tmp_path: Path, scene: dict[str, Any], on: dict[str, Any]) -> EdgeRegion:
    """Return the region of a traction; the body is held at two points off its edges."""
    center = [1, 2] if "disk" in scene["bodies"]["rock"]["shape"] else [3, 1]
    scene["supports"] = [
        {"at": center, "displacement": {"x": 0, "y": 0}},
        {"at": [center[0] + 0.5, center[1]], "displacement": {"y": 0}},
    ]
    scene["loads"] = [{"on": {"body": "rock", **on}, "traction": [0, 1]}]
    found = load(tmp_path, scene).loads[0].region
    assert (found.body, found.edge) == ("rock", on["edge"])
    return found


# shape, edges, on, sides, limits; worked out by hand
STRAIGHT = [
    ({"polygon": SQUARE}, {}, {"edge": "0"}, [0], [[0, 1]]),
    ({"polygon": SQUARE}, {}, {"edge": "0", "from": 1}, [0], [[0.25, 1]]),
    ({"polygon": SQUARE}, {}, {"edge": "1", "to": 1.5}, [1], [[0, 0.5]]),
    ({"polygon": SQUARE}, {}, {"edge": "2", "from": 1}, [2], [[0, 0.75]]),  # runs leftwards: x from 1 to 4
    ({"polygon": SQUARE}, {}, {"edge": "3", "from": 1, "to": 2}, [3], [[1 / 3, 2 / 3]]),
    # drawn clockwise: edge 0 is the left one; it is stored as the last side, first corner kept
    ({"polygon": CLOCKWISE}, {}, {"edge": "0"}, [3], [[0, 1]]),
    ({"polygon": CLOCKWISE}, {}, {"edge": "0", "from": 1.5}, [3], [[0, 0.5]]),  # y from 1.5 to 3, stored downwards
    ({"polygon": CLOCKWISE}, {}, {"edge": "3", "to": 1}, [0], [[0, 0.25]]),
    # distance from the first corner drawn
    ({"polygon": WEDGE}, {}, {"edge": "1", "from": 1, "to": 2}, [1], [[0.2, 0.4]]),
    ({"polygon": WEDGE[::-1]}, {}, {"edge": "0", "from": 1, "to": 2}, [2], [[0.6, 0.8]]),
    # several sides under one name
    ({"polygon": SQUARE}, {"a": [1, 2]}, {"edge": "a"}, [1, 2], [[0, 1], [0, 1]]),
    ({"polygon": SQUARE}, {"a": [1, 2]}, {"edge": "a", "from": 1.5, "to": 5}, [1, 2], [[0.5, 1], [0, 0.5]]),
    ({"polygon": SQUARE}, {"a": [1, 2]}, {"edge": "a", "from": 3}, [2], [[0, 1]]),
    ({"polygon": SQUARE}, {"a": [3, 0]}, {"edge": "a", "from": 1.5, "to": 4}, [3, 0], [[0.5, 1], [0, 0.25]]),
    ({"polygon": CLOCKWISE}, {"a": [0, 1]}, {"edge": "a", "from": 2, "to": 5}, [2, 3], [[0.5, 1], [0, 1 / 3]]),
    (rectangle(0, 0, 4, 3), {}, {"edge": "left", "from": 1}, [3], [[0, 2 / 3]]),
    (rectangle(0, 0, 4, 3), {}, {"edge": "top", "to": "100 cm"}, [2], [[0.75, 1]]),
]


@pytest.mark.parametrize(("shape", "edges", "on", "sides", "limits"), STRAIGHT)
def test_straight_edges(shape, edges, on, sides, limits, tmp_path: Path):
    found = region(tmp_path, with_body(shape, **({"edges": edges} if edges else {})), on)
    assert found.sides.tolist() == sides
    assert found.sides.dtype == np.int64
    np.testing.assert_allclose(found.limits, limits, atol=1e-15)  # one or two roundings


def test_polygon_holes(tmp_path: Path):
    """A hole of 1 by 0.5, drawn counter-clockwise and stored clockwise, its first corner kept: sides 4 to 7."""
    shape = {**rectangle(0, 0, 4, 3), "holes": [rectangle(1, 1, 1, 0.5)]}
    whole = region(tmp_path, with_body(shape), {"edge": "hole0"})
    assert whole.sides.tolist() == [4, 5, 6, 7]
    part = region(tmp_path, with_body(shape), {"edge": "hole0", "from": 0.25, "to": 1.25})
    # drawn: bottom (stored last, leftwards) from 1/4 on, then right (stored last but one, downwards) up to 1/2
    assert part.sides.tolist() == [6, 7]
    np.testing.assert_allclose(part.limits, [[0.5, 1], [0, 0.75]], atol=1e-15)


def test_arc_of_a_disk(tmp_path: Path):
    whole = region(tmp_path, with_body(DISK), {"edge": "arc"})
    assert whole.sides.tolist() == list(range(360))
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "from": 30, "to": 33})
    assert (part.sides.tolist(), part.limits.tolist()) == ([30, 31, 32], [[0, 1]] * 3)
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "to": "2 deg"})
    assert part.sides.tolist() == [0, 1]
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "from": -2, "to": 0.5})
    assert part.sides.tolist() == [358, 359, 0]
    np.testing.assert_allclose(part.limits, [[0, 1], [0, 1], [0, 0.5]], atol=1e-12)  # tan of a small difference
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "from": 359, "to": 362})
    assert part.sides.tolist() == [359, 0, 1]
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "from": 10.5, "to": 370.5})
    assert part.sides.tolist() == [*range(10, 360), *range(11)]


def test_a_place_on_an_arc_is_cut_by_the_ray_at_its_angle(tmp_path: Path):
    part = region(tmp_path, with_body(DISK), {"edge": "arc", "from": 40.2, "to": 40.7})
    (side,), (limits,) = part.sides, part.limits
    corners = np.deg2rad([side, side + 1])
    first, second = 3 * np.column_stack([np.cos(corners), np.sin(corners)])
    for fraction, angle in zip(limits, (40.2, 40.7), strict=True):
        x, y = first + fraction * (second - first)
        assert np.rad2deg(np.arctan2(y, x)) == pytest.approx(angle, abs=1e-11)  # roundings of angles near 40


def test_arc_of_a_hole(tmp_path: Path):
    """Stored clockwise from angle 0: the side from angle k + 1 to k is number 4 + 359 - k."""
    shape = {**rectangle(0, 0, 8, 8), "holes": [{"disk": {"center": [4, 4], "radius": 1}}]}
    whole = region(tmp_path, with_body(shape), {"edge": "hole0"})
    assert whole.sides.tolist() == list(range(4, 364))
    part = region(tmp_path, with_body(shape), {"edge": "hole0", "from": -1, "to": 1.5})
    assert (part.sides - 4).tolist() == [358, 359, 0]
    np.testing.assert_allclose(part.limits, [[0.5, 1], [0, 1], [0, 1]], atol=1e-12)


def test_resolved_places_are_metres_or_degrees(tmp_path: Path):
    scene = with_body(DISK)
    scene["units"] = {"length": "cm"}
    scene["numerics"] = {"spacing": 0.1}
    scene["loads"] = [{"on": {"body": "rock", "edge": "arc", "from": 10, "to": "20 deg"}, "traction": [0, 1]}]
    scene["supports"] = [{"on": {"body": "rock", "edge": "arc"}, "displacement": {"x": 0, "y": 0}}]
    assert load(tmp_path, scene).resolved["loads"][0]["on"] == {  # type: ignore[index]
        "body": "rock",
        "edge": "arc",
        "from": 10.0,
        "to": 20.0,
    }
    scene = with_body(rectangle(0, 0, 4, 3))
    scene["units"] = {"length": "cm"}
    scene["supports"] = held("rock")
    scene["supports"][0]["on"] |= {"from": 1, "to": "20 mm"}
    assert load(tmp_path, scene).resolved["supports"][0]["on"]["from"] == 0.01  # type: ignore[index]


def test_many_edges_are_cut_in_messages(tmp_path: Path):
    rays = np.deg2rad(np.arange(0, 360, 6))
    scene = with_body({"polygon": np.column_stack([np.cos(rays), np.sin(rays)]).tolist()})
    scene["supports"] = [{"on": {"body": "rock", "edge": "60"}, "displacement": {"x": 0, "y": 0}}]
    _, message = fault(tmp_path, scene)
    assert "it has: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, ..., 59" in message
