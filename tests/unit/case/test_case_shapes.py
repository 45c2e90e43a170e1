"""Outlines, holes and edges: corners, names, orientation, files, parts of edges, and the outline as a whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import Case
from crackgrow.case.model import Body, EdgeRegion, EdgeSupport, FarField
from crackgrow.errors import CaseError
from tests.unit.case.scenes import changed, fault, joint, load, rectangle, reread, same, with_body

SQUARE = [[0, 0], [4, 0], [4, 3], [0, 3]]
CLOCKWISE = [[0, 0], [0, 3], [4, 3], [4, 0]]
DISK = {"disk": {"center": [1, 2], "radius": 3}}
WEDGE = [[0, 0], [6, 0], [3, 4]]  # a side of length 5 from (6, 0) on, another one back


def held_at(scene: dict[str, Any], x: float, y: float) -> dict[str, Any]:
    """The scene with its body held at two points near one in it."""
    given = ((x, {"x": 0, "y": 0}), (x + 0.1, {"y": 0}))
    return changed(scene, supports=[{"at": [along, y], "displacement": components} for along, components in given])


def body_of(tmp_path: Path, scene: dict[str, Any], x: float = 2, y: float = 1) -> Body:
    return load(tmp_path, held_at(scene, x, y)).bodies[0]


@pytest.mark.parametrize(("points", "edges", "corners", "names"), [
    (SQUARE, {}, SQUARE, ("0", "1", "2", "3")),
    # what is drawn clockwise keeps its first corner and the names of its sides
    ([[0, 0], [0, 3], [4, 3], [5, 1], [4, 0]], {}, [[0, 0], [4, 0], [5, 1], [4, 3], [0, 3]], tuple("43210")),
    # corners that are repeated are dropped, and edges keep their numbers
    ([*SQUARE, [0, 0]], {}, SQUARE, ("0", "1", "2", "3")),
    ([[0, 0], [0, 0], [4, 0], [4, 3], [4, 3], [4, 3], [0, 3]], {}, SQUARE, ("1", "2", "5", "6")),
    ([*SQUARE, [0, 3], [0, 0], [1e-12, 0]], {}, SQUARE, ("0", "1", "2", "4")),
    (SQUARE, {"inlet": 3, "wall": [0, 1]}, SQUARE, ("wall", "wall", "2", "inlet")),
    (SQUARE[::-1], {"inlet": [3, 0]}, [[0, 3], [0, 0], [4, 0], [4, 3]], ("inlet", "2", "1", "inlet")),
])  # fmt: skip
def test_polygons_run_counter_clockwise_and_name_their_sides(
    points: list[list[float]], edges: dict[str, Any], corners: list[list[float]], names: tuple[str, ...], tmp_path: Path
):
    body = body_of(tmp_path, with_body({"polygon": points}, **({"edges": edges} if edges else {})))
    assert body.outline.tolist() == corners
    assert body.rings[0].edge_names == names


def test_disk(tmp_path: Path):
    body = body_of(tmp_path, with_body(DISK), 1, 2)
    rays = np.deg2rad(np.arange(360))
    expected = np.column_stack([1 + 3 * np.cos(rays), 2 + 3 * np.sin(rays)])
    np.testing.assert_allclose(body.outline, expected, atol=1e-15 * 6)  # cos, product and sum round
    assert set(body.rings[0].edge_names) == {"arc"}


def test_holes_run_clockwise(tmp_path: Path):
    holes = [rectangle(1, 1, 1, 0.5), {"polygon": [[3, 1], [3.5, 1.5], [3.5, 1]]}]
    holes.append({"disk": {"center": [1, 2.5], "radius": 0.25}})
    _, first, second, third = body_of(tmp_path, with_body({"polygon": SQUARE, "holes": holes}), 2.5, 1).rings
    assert first.points.tolist() == [[1, 1], [1, 1.5], [2, 1.5], [2, 1]]
    assert second.points.tolist() == [[3, 1], [3.5, 1.5], [3.5, 1]]
    assert (first.edge_names, second.edge_names) == (("hole0",) * 4, ("hole1",) * 3)
    assert third.edge_names == ("hole2",) * 360
    rays = np.deg2rad(-np.arange(360))
    np.testing.assert_allclose(third.points, [1, 2.5] + 0.25 * np.stack([np.cos(rays), np.sin(rays)], 1), atol=1e-15)


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
    "collection.GeoJSON": json.dumps({"type": "FeatureCollection", "features": [UNPLACED, FEATURE]}),
    "multi.json": json.dumps({"type": "MultiPolygon", "coordinates": [RINGS]}),
}


@pytest.mark.parametrize("name", FILES)
def test_outline_from_a_file(name: str, tmp_path: Path):
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / name).write_text(FILES[name], encoding="utf-8")
    scene = with_body({"file": f"shapes/{name}", "holes": [rectangle(3, 1, 0.5, 0.5)]}, edges={"roof": 1})
    scene["units"] = {"length": "mm"}
    body = body_of(tmp_path, scene, 2.5, 2)
    np.testing.assert_array_equal(body.outline, np.array(SQUARE) / 1000)
    assert body.rings[0].edge_names == ("3", "2", "roof", "0")
    np.testing.assert_array_equal(body.rings[1].points, np.array([[1, 1], [1, 1.5], [2, 1.5], [2, 1]]) / 1000)
    assert [ring.edge_names[0] for ring in body.rings[1:]] == ["hole0", "hole1"]


def test_resolved_case_needs_no_outline_file(tmp_path: Path):
    (tmp_path / "rock.wkt").write_text(WKT, encoding="utf-8")
    (tmp_path / "notch.wkt").write_text("POLYGON ((3 1, 3.5 1, 3.5 1.5, 3 1))", encoding="utf-8")
    scene = with_body({"file": "rock.wkt", "holes": [{"file": "notch.wkt"}]})
    scene["supports"] = [{"on": {"body": "rock", "edge": "3"}, "displacement": {"x": 0, "y": 0}}]
    case = load(tmp_path, scene)
    (tmp_path / "elsewhere").mkdir()
    again = reread(case, tmp_path / "elsewhere")
    assert len(again.bodies[0].rings) == 3
    assert same(again, case)


def test_names_of_what_is_no_file_of_an_outline(tmp_path: Path):
    (tmp_path / "rock.wkt").write_bytes(b"POLYGON \xff")
    (tmp_path / "folder.wkt").mkdir()
    long = "a" * 5000 + ".wkt"
    told = {"rock.wkt": "not a text in UTF-8", "folder.wkt": "is no file", long: "wanted: the name of a"}
    for name, words in told.items():
        assert words in fault(tmp_path, with_body({"file": name}))[1]


# --- parts of edges --------------------------------------------------------------------------------------------------


def region(tmp_path: Path, shape: dict[str, Any], on: dict[str, Any], **body: Any) -> EdgeRegion:
    """The region of a traction; the body is held at two points in it."""
    scene = held_at(with_body(shape, **body), *((1, 2) if "disk" in shape else (3, 1)))
    scene["loads"] = [{"on": {"body": "rock", **on}, "traction": [0, 1]}]
    found = load(tmp_path, scene).loads[0].region
    assert (found.body, found.edge) == ("rock", on["edge"])
    return found


BOXED = {**rectangle(0, 0, 4, 3), "holes": [rectangle(1, 1, 1, 0.5)]}
"""The hole is drawn counter-clockwise and stored clockwise, its first corner kept: sides 4 to 7."""
PIERCED = {**rectangle(0, 0, 8, 8), "holes": [{"disk": {"center": [4, 4], "radius": 1}}]}
"""The hole is stored clockwise from angle 0: the side from angle k + 1 to k is number 4 + 359 - k."""


# shape, edges, on, sides, limits; worked out by hand
@pytest.mark.parametrize(("shape", "edges", "on", "sides", "limits"), [
    ({"polygon": SQUARE}, {}, {"edge": "0"}, [0], [[0, 1]]),
    ({"polygon": SQUARE}, {}, {"edge": "0", "from": 1}, [0], [[0.25, 1]]),
    ({"polygon": SQUARE}, {}, {"edge": "2", "from": 1}, [2], [[0, 0.75]]),  # runs leftwards: x from 1 to 4
    ({"polygon": SQUARE}, {}, {"edge": "3", "from": 1, "to": 2}, [3], [[1 / 3, 2 / 3]]),
    # drawn clockwise: edge 0 is the left one; it is stored as the last side, first corner kept
    ({"polygon": CLOCKWISE}, {}, {"edge": "0", "from": 1.5}, [3], [[0, 0.5]]),  # y from 1.5 to 3, stored downwards
    ({"polygon": CLOCKWISE}, {}, {"edge": "3", "to": 1}, [0], [[0, 0.25]]),
    # distance from the first corner drawn
    ({"polygon": WEDGE}, {}, {"edge": "1", "from": 1, "to": 2}, [1], [[0.2, 0.4]]),
    ({"polygon": WEDGE[::-1]}, {}, {"edge": "0", "from": 1, "to": 2}, [2], [[0.6, 0.8]]),
    # several sides under one name
    ({"polygon": SQUARE}, {"a": [1, 2]}, {"edge": "a", "from": 1.5, "to": 5}, [1, 2], [[0.5, 1], [0, 0.5]]),
    ({"polygon": SQUARE}, {"a": [3, 0]}, {"edge": "a", "from": 1.5, "to": 4}, [3, 0], [[0.5, 1], [0, 0.25]]),
    ({"polygon": CLOCKWISE}, {"a": [0, 1]}, {"edge": "a", "from": 2, "to": 5}, [2, 3], [[0.5, 1], [0, 1 / 3]]),
    (rectangle(0, 0, 4, 3), {}, {"edge": "left", "from": 1}, [3], [[0, 2 / 3]]),
    (rectangle(0, 0, 4, 3), {}, {"edge": "top", "to": "100 cm"}, [2], [[0.75, 1]]),
    (BOXED, {}, {"edge": "hole0"}, [4, 5, 6, 7], [[0, 1]] * 4),
    # drawn: bottom (stored last, leftwards) from 1/4 on, then right (stored last but one, downwards) up to 1/2
    (BOXED, {}, {"edge": "hole0", "from": 0.25, "to": 1.25}, [6, 7], [[0.5, 1], [0, 0.75]]),
    (PIERCED, {}, {"edge": "hole0", "from": -1, "to": 1.5}, [362, 363, 4], [[0.5, 1], [0, 1], [0, 1]]),
    (DISK, {}, {"edge": "arc", "from": -2, "to": 0.5}, [358, 359, 0], [[0, 1], [0, 1], [0, 0.5]]),
    (DISK, {}, {"edge": "arc", "from": 359, "to": 362}, [359, 0, 1], [[0, 1]] * 3),
])  # fmt: skip
def test_parts_of_edges(
    shape: dict[str, Any], edges: dict[str, Any], on: dict[str, Any], sides: list[int], limits: Any, tmp_path: Path
):
    found = region(tmp_path, shape, on, **({"edges": edges} if edges else {}))
    assert found.sides.tolist() == sides
    round_off = 1e-12 if "deg" in str(on) or "disk" in str(shape) else 1e-15  # tan of a small difference
    np.testing.assert_allclose(found.limits, limits, atol=round_off)


# --- the outline as a whole: `outline` of supports and `far_field` of loads ------------------------------------------

X, Y = (0.0, None), (None, 0.0)
BLOCK = {"rock": rectangle(-5, -5, 10, 10)}
SIDE_BY_SIDE = {"big": rectangle(-5, -5, 10, 10), "small": rectangle(5, -1, 2, 4)}
CORE = {"disk": {"center": [0, 0], "radius": 1}}
AROUND = {"rock": {**rectangle(-5, -5, 10, 10), "holes": [CORE]}, "core": CORE}


def outlined(shapes: dict[str, Any], supports: Any, loads: Any = (), **more: Any) -> Case:
    material = {"young": "30 GPa", "poisson": 0.2}
    bodies = {name: {"shape": shape, "material": material} for name, shape in shapes.items()}
    scene = {"title": "outline", "units": {"stress": "MPa"}, "plane": "strain", "bodies": bodies}
    return Case.from_dict({**scene, "supports": supports, "loads": list(loads), **more})


def held_edges(case: Case) -> list[tuple[Any, ...]]:
    """Body, edge, displacement and limits of supports of edges."""
    assert all(isinstance(support, EdgeSupport) for support in case.supports)
    return [(s.region.body, s.region.edge, s.displacement, s.region.limits.tolist()) for s in case.supports]


def test_rollers_hold_each_side_across_but_for_what_bodies_share():
    case = outlined(SIDE_BY_SIDE, [{"outline": "rollers"}], interfaces=joint("big small"))
    wanted = [("big", "left", X, [[0.0, 1.0]]), ("small", "right", X, [[0.0, 1.0]])]
    wanted += [("big", "right", X, [[0.0, 0.4]]), ("big", "right", X, [[0.8, 1.0]])]
    wanted += [(body, edge, Y, [[0.0, 1.0]]) for body in SIDE_BY_SIDE for edge in ("bottom", "top")]
    assert sorted(held_edges(case), key=str) == sorted(wanted, key=str)
    assert held_edges(Case.from_dict(case.to_dict())) == held_edges(case)


def test_the_outline_of_one_body_and_of_bodies_round_others():
    """Other supports stay by their numbers, and bodies inside of others have no outline of their own."""
    other = {"on": {"body": "big", "edge": "left"}, "displacement": {"y": 0}}
    fixed = {"outline": "fixed", "body": "small"}
    found = held_edges(outlined(SIDE_BY_SIDE, [fixed, other], interfaces=joint("big small")))
    assert found.pop(1) == ("big", "left", Y, [[0.0, 1.0]])
    assert {of_it[:3] for of_it in found} == {("small", edge, (0.0, 0.0)) for edge in ("bottom", "right", "top")}
    glued = joint("rock core", contact="bonded")
    found = held_edges(outlined(AROUND, [{"outline": "fixed"}], interfaces=glued))
    assert {of_it[:2] for of_it in found} == {("rock", edge) for edge in ("left", "right", "bottom", "top")}


def test_far_field_is_stress_times_normal_on_all_that_bodies_do_not_share():
    glued = joint("big small", contact="bonded")
    case = outlined(SIDE_BY_SIDE, "minimal", [{"far_field": [-2, -10, 1]}], interfaces=glued)
    loads = {load.body: load for load in case.loads if isinstance(load, FarField)}
    assert set(loads) == {"big", "small"}
    normals = np.array([[1.0, 0.0], [0.6, 0.8]])
    traction = loads["big"].traction_at(np.zeros((2, 2)), normals)
    np.testing.assert_allclose(traction, normals @ (1e6 * np.array([[-2.0, 1.0], [1.0, -10.0]])))
    assert loads["big"].region.limits.tolist() == [[0.0, 1.0], [0.0, 0.4], [0.8, 1.0], [0.0, 1.0], [0.0, 1.0]]
    assert [load["far_field"] for load in case.to_dict()["loads"]] == [[-2e6, -1e7, 1e6]] * 2
    assert Case.from_dict(case.to_dict()).to_dict() == case.to_dict()


def test_a_far_field_may_vary_if_what_it_leaves_over_is_held():
    lithostatic = {"far_field": ["0.01*(y - 5)", "0.026*(y - 5)", 0]}
    case = outlined(BLOCK, [{"outline": "rollers"}], [lithostatic])
    places, up = np.array([[3.0, 5.0], [3.0, -5.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])
    np.testing.assert_allclose(case.loads[0].traction_at(places, up), [[0.0, 0.0], [0.0, 260000.0]], atol=1e-9)
    with pytest.raises(CaseError, match="'minimal' takes no force"):
        outlined(BLOCK, "minimal", [lithostatic])
