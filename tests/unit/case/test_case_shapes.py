"""Outlines and holes: corners, names of edges, orientation, files, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import dump_case, load_case
from crackgrow.case.model import Body
from tests.unit.case.scenes import changed, fault, faults, load, rectangle, with_body

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]


def body_of(tmp_path: Path, scene: dict[str, Any], *at: float) -> Body:
    """Load a scene with one body, held near a point in it."""
    x, y = at or (2, 1)
    scene = changed(
        scene,
        supports=[{"at": [x, y], "displacement": {"x": 0, "y": 0}}, {"at": [x + 0.1, y], "displacement": {"y": 0}}],
    )
    return load(tmp_path, scene).bodies[0]


def area(points: np.ndarray) -> float:
    x, y = points.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def test_polygon_counter_clockwise(tmp_path: Path):
    body = body_of(tmp_path, with_body({"polygon": SQUARE}))
    assert body.outline.tolist() == SQUARE
    assert body.rings[0].edge_names == ("0", "1", "2", "3")


def test_polygon_clockwise_keeps_the_names_of_its_sides(tmp_path: Path):
    points = [[0, 0], [0, 3], [4, 3], [5, 1], [4, 0]]
    body = body_of(tmp_path, with_body({"polygon": points}))
    assert body.outline.tolist() == [[0, 0], [4, 0], [5, 1], [4, 3], [0, 3]]
    assert body.rings[0].edge_names == ("4", "3", "2", "1", "0")
    for start, end, name in zip(body.outline, np.roll(body.outline, -1, axis=0), body.rings[0].edge_names, strict=True):
        drawn = [points[int(name)], points[(int(name) + 1) % 5]]
        assert drawn == [end.tolist(), start.tolist()]


@pytest.mark.parametrize(
    ("points", "corners", "names"),
    [
        ([[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]], SQUARE, ("0", "1", "2", "3")),
        ([[0, 0], [0, 0], [4, 0], [4, 3], [4, 3], [4, 3], [0, 3]], SQUARE, ("1", "2", "5", "6")),
        ([[0, 0], [4, 0], [4, 3], [0, 3], [0, 3], [0, 0], [1e-12, 0]], SQUARE, ("0", "1", "2", "4")),
    ],
)
def test_repeated_corners_are_dropped_and_edges_keep_their_numbers(points, corners, names, tmp_path: Path):
    body = body_of(tmp_path, with_body({"polygon": points}))
    assert body.outline.tolist() == corners
    assert body.rings[0].edge_names == names


def test_named_edges(tmp_path: Path):
    scene = with_body({"polygon": SQUARE}, edges={"inlet": 3, "wall": [0, 1]})
    assert body_of(tmp_path, scene).rings[0].edge_names == ("wall", "wall", "2", "inlet")
    scene = with_body({"polygon": SQUARE[::-1]}, edges={"inlet": [3, 0]})
    assert body_of(tmp_path, scene).rings[0].edge_names == ("inlet", "2", "1", "inlet")


def test_disk(tmp_path: Path):
    body = body_of(tmp_path, with_body({"disk": {"center": [1, 2], "radius": 3}}), 1, 2)
    assert body.outline.shape == (360, 2)
    assert body.outline[[0, 90, 180, 270]].tolist() == [[4, 2], [1, 5], [-2, 2], [1, -1]]
    rays = np.deg2rad(np.arange(360))
    expected = np.column_stack([1 + 3 * np.cos(rays), 2 + 3 * np.sin(rays)])
    np.testing.assert_allclose(body.outline, expected, atol=1e-15 * 6)  # cos, product and sum round
    assert set(body.rings[0].edge_names) == {"arc"}


def test_holes_run_clockwise(tmp_path: Path):
    holes = [rectangle(1, 1, 1, 0.5), {"polygon": [[3, 1], [3.5, 1.5], [3.5, 1]]}]
    holes.append({"disk": {"center": [1, 2.5], "radius": 0.25}})
    body = body_of(tmp_path, with_body({"polygon": SQUARE, "holes": holes}), 2.5, 1)
    outline, first, second, third = body.rings
    assert area(outline.points) == 12
    assert first.points.tolist() == [[1, 1], [1, 1.5], [2, 1.5], [2, 1]]
    assert second.points.tolist() == [[3, 1], [3.5, 1.5], [3.5, 1]]
    assert (first.edge_names, second.edge_names) == (("hole0",) * 4, ("hole1",) * 3)
    assert third.edge_names == ("hole2",) * 360
    assert third.points[:2].tolist() == [[1.25, 2.5], [1 + 0.25 * np.cos(np.deg2rad(359)), third.points[1, 1]]]
    assert third.points[1, 1] < 2.5
    assert area(third.points) == pytest.approx(-180 * 0.25**2 * np.sin(np.deg2rad(1)), rel=1e-12)


def test_faults_of_several_shapes_at_once(tmp_path: Path):
    shape = {"polygon": SQUARE, "holes": [rectangle(3, 1, 2, 1), {"polygon": [[1, 1], [1, 1]]}]}
    shape["holes"].append({"disk": {"center": [1, 1], "radius": -1}})
    keys = [found.key for found in faults(tmp_path, with_body(shape))]
    assert keys == ["bodies.rock.shape.holes.2.disk.radius"]  # the rest is judged once all holes can be read
    shape["holes"].pop()
    shape["polygon"] = [[0, 0], [1, 1]]
    keys = [found.key for found in faults(tmp_path, with_body(shape))]
    assert keys == ["bodies.rock.shape", "bodies.rock.shape.holes.1"]


# --- files -----------------------------------------------------------------------------------------------------------

WKT = "POLYGON ((0 0, 0 3, 4 3, 4 0, 0 0), (1 1, 2 1, 2 1.5, 1 1.5, 1 1))"
RINGS = [[[0, 0], [0, 3], [4, 3], [4, 0], [0, 0]], [[1, 1], [2, 1], [2, 1.5], [1, 1.5], [1, 1]]]
POLYGON = {"type": "Polygon", "coordinates": RINGS}
FEATURE = {"type": "Feature", "properties": {"name": "rock"}, "geometry": POLYGON}
UNPLACED = {"type": "Feature", "properties": {"name": "not mapped"}, "geometry": None}  # RFC 7946, section 3.2
FILES = {
    "rock.wkt": WKT,
    "rock.geojson": json.dumps(POLYGON),
    "feature.geojson": json.dumps(FEATURE),
    "collection.GeoJSON": json.dumps({"type": "FeatureCollection", "features": [FEATURE]}),
    "unplaced.geojson": json.dumps({"type": "FeatureCollection", "features": [UNPLACED, FEATURE]}),
    "multi.json": json.dumps({"type": "MultiPolygon", "coordinates": [RINGS]}),
}


@pytest.mark.parametrize("name", FILES)
def test_outline_from_a_file(name: str, tmp_path: Path):
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / name).write_text(FILES[name], encoding="utf-8")
    scene = with_body({"file": f"shapes/{name}", "holes": [rectangle(3, 1, 0.5, 0.5)]}, edges={"roof": 1})
    scene["numerics"] = {"spacing": 0.1}
    scene["units"] = {"length": "mm"}
    body = body_of(tmp_path, scene, 2.5, 2)
    np.testing.assert_array_equal(body.outline, np.array([[0, 0], [4, 0], [4, 3], [0, 3]]) / 1000)
    assert body.rings[0].edge_names == ("3", "2", "roof", "0")
    np.testing.assert_array_equal(body.rings[1].points, np.array([[1, 1], [1, 1.5], [2, 1.5], [2, 1]]) / 1000)
    assert [ring.edge_names[0] for ring in body.rings[1:]] == ["hole0", "hole1"]


def test_resolved_case_needs_no_outline_file(tmp_path: Path):
    (tmp_path / "rock.wkt").write_text(WKT, encoding="utf-8")
    (tmp_path / "notch.wkt").write_text("POLYGON ((3 1, 3.5 1, 3.5 1.5, 3 1))", encoding="utf-8")
    scene = with_body({"file": "rock.wkt", "holes": [{"file": "notch.wkt"}]})
    scene["supports"] = [{"on": {"body": "rock", "edge": "3"}, "displacement": {"x": 0, "y": 0}}]
    case = load(tmp_path, scene)
    shape = case.resolved["bodies"]["rock"]["shape"]  # type: ignore[index]
    assert shape == {
        "polygon": [[0.0, 0.0], [0.0, 3.0], [4.0, 3.0], [4.0, 0.0]],
        "holes": [
            {"polygon": [[1.0, 1.0], [2.0, 1.0], [2.0, 1.5], [1.0, 1.5]]},
            {"polygon": [[3.0, 1.0], [3.5, 1.0], [3.5, 1.5]]},
        ],
    }
    (tmp_path / "elsewhere").mkdir()
    again = tmp_path / "elsewhere" / "scene.yaml"
    again.write_text(dump_case(case), encoding="utf-8")
    assert load_case(again).bodies[0].rings[2].points.tolist() == case.bodies[0].rings[2].points.tolist()
    assert yaml.safe_load(dump_case(load_case(again))) == case.resolved


def test_coordinates_of_a_file_are_read_like_those_of_the_case(tmp_path: Path):
    (tmp_path / "rock.wkt").write_text("POLYGON ((0.1 0.7, 33.3 0.7, 33.3 51.9, 0.1 0.7))", encoding="utf-8")
    polygon = {"polygon": [[0.1, 0.7], [33.3, 0.7], [33.3, 51.9]]}
    first, second = (
        body_of(tmp_path, {**with_body(shape), "units": {"length": "mm"}}, 30, 10).outline
        for shape in (polygon, {"file": "rock.wkt"})
    )
    assert first.tobytes() == second.tobytes()


def test_file_that_is_no_text(tmp_path: Path):
    (tmp_path / "rock.wkt").write_bytes(b"POLYGON \xff")
    assert "not a text in UTF-8" in fault(tmp_path, with_body({"file": "rock.wkt"}))[1]
    (tmp_path / "folder.wkt").mkdir()
    assert "is no file" in fault(tmp_path, with_body({"file": "folder.wkt"}))[1]
    assert "wanted: the name of a" in fault(tmp_path, with_body({"file": ""}))[1]
    assert "wanted: the name of a" in fault(tmp_path, with_body({"file": "a\0.wkt"}))[1]
    assert "wanted: the name of a" in fault(tmp_path, with_body({"file": "a" * 5000 + ".wkt"}))[1]
