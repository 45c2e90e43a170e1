"""Sets of cracks from files: cut where they leave the rock, brought together, named, and what was changed is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import Case, dump_case, load_case
from tests.unit.case.scenes import reread

CONTACT = {"friction": 0.3, "cohesion": 0}
Lines = list[list[list[float]]]


def load(folder: Path, lines: Lines, cracks: dict[str, Any] | None = None, **path: Any) -> Case:
    """A block of 1 m on each side with these lines, in mm, as a set of cracks."""
    (folder / "traces.geojson").write_text(json.dumps({"type": "MultiLineString", "coordinates": lines}))
    return of_file(folder, "traces.geojson", path, cracks=cracks)


def of_file(folder: Path, name: str, beside: dict[str, Any], cracks: Any = None, **crack: Any) -> Case:
    """The block with the lines of a file, with keys beside it and others of the set."""
    body = {"shape": {"rectangle": {"center": [500, 500], "width": 1000, "height": 1000}},
            "material": {"young": "10 GPa", "poisson": 0.2}}  # fmt: skip
    joints = {"path": {"file": name, **beside}, "tips": "both", "contact": CONTACT, **crack}
    content = {
        "title": "A block with joints", "units": {"length": "mm"}, "plane": "strain", "bodies": {"rock": body},
        "cracks": {"joints": joints, **(cracks or {})}, "numerics": {"spacing": 50},
        "supports": [{"on": {"body": "rock", "edge": "bottom"}, "displacement": {"x": 0, "y": 0}}],
    }  # fmt: skip
    (folder / "scene.yaml").write_text(json.dumps(content))
    return load_case(folder / "scene.yaml")


def tips_of(case: Case) -> list[tuple[str, ...]]:
    ends = [(("start", crack.tip_at_start), ("end", crack.tip_at_end)) for crack in case.cracks]
    return [tuple(end for end, grows in both if grows) for both in ends]


# --- at the rims of the rock -----------------------------------------------------------------------------------------


def test_lines_become_cracks_that_end_where_they_leave_the_rock(tmp_path: Path):
    inside, leaving = [[200, 200], [300, 250], [400, 250]], [[900, 500], [1200, 500]]
    through, outside = [[-100, 700], [1100, 800]], [[1200, 0], [1300, 0]]
    case = load(tmp_path, [inside, leaving, through, outside])
    found = {crack.name: crack for crack in case.cracks}
    assert list(found) == ["joints-1", "joints-2", "joints-3"]
    np.testing.assert_allclose(found["joints-1"].points, np.array(inside) / 1000, rtol=1e-15)
    np.testing.assert_allclose(found["joints-2"].points, [[0.9, 0.5], [1, 0.5]], rtol=1e-15)
    np.testing.assert_allclose(found["joints-3"].points[:, 1], 0.7 + 0.1 / 12 + np.array([0, 0.1 / 1.2]), rtol=1e-12)
    assert tips_of(case) == [("start", "end"), ("start",), ()]
    assert [cut.crack for cut in case.cut] == ["joints-2", "joints-3", "joints-4"]
    assert [cut.whole for cut in case.cut] == [False, False, True]
    np.testing.assert_allclose([cut.length for cut in case.cut], [0.2, np.hypot(1.2, 0.1) / 6, 0.1], rtol=1e-12)


def test_an_end_within_the_tolerance_of_the_outline_lies_on_it(tmp_path: Path):
    case = load(tmp_path, [[[900, 500], [999.995, 500]], [[900, 600], [1000.005, 600]], [[300, 300], [400, 400]]])
    assert [crack.points[-1][0] for crack in case.cracks] == [1.0, 1.0, 0.4]
    assert tips_of(case) == [("start",), ("start",), ("start", "end")]
    np.testing.assert_allclose([move.distance for move in case.moved], [5e-6], rtol=1e-6)
    np.testing.assert_allclose([cut.length for cut in case.cut], [5e-6], rtol=1e-6)


def test_a_set_keeps_the_tips_that_it_is_given_and_needs_its_file_no_more(tmp_path: Path):
    load(tmp_path, [[[300, 300], [400, 400]], [[900, 500], [1200, 500]]])
    case = of_file(tmp_path, "traces.geojson", {}, tips="end")
    assert tips_of(case) == [("end",), ()]
    (tmp_path / "traces.geojson").unlink()
    again = reread(case, tmp_path)
    assert [crack.points.tolist() for crack in again.cracks] == [crack.points.tolist() for crack in case.cracks]
    assert tips_of(again) == tips_of(case)


# --- tables ----------------------------------------------------------------------------------------------------------

LINES: Lines = [[[200, 200], [300, 250], [400, 250]], [[600, 500], [700, 500]]]  # mm


def table(header: str, separator: str = ",", scale: float = 1.0, comma: str = ".") -> str:
    """LINES as a table with these columns, in mm times a scale."""
    rows = []
    for name, line in zip("ab", LINES, strict=True):
        for k, (x, y) in enumerate(line):
            values = {"crack": name, "vertex": str(k), "step": "0"}
            place = {"x": round(x * scale, 9), "y": round(y * scale, 9)}
            cells = [
                values.get(key) or repr(place[key[0].lower()]).replace(".", comma) for key in header.split(separator)
            ]
            rows.append(separator.join(cells))
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize(("text", "beside"), [
    (table("crack,x,y"), {}),
    (table("crack;x;y", ";", 0.1, ","), {"units": "cm"}),
    (table("crack\tx\ty", "\t"), {}),
    ("\ufeff" + table("crack,x,y").replace("\n", "\r\n"), {}),
    (table("crack,vertex,x,y,step", scale=1e-3), {}),
    (table("crack,vertex,x,y,step"), {"units": "mm"}),
    (table("crack,x_m,y_m", scale=1e-3), {}),
    (table("crack,y_mm,x_mm"), {}),
    (table("crack,X,Y"), {"columns": {"crack": "crack", "x": "X", "y": "Y"}}),
])  # fmt: skip
def test_a_table_of_vertices_is_a_set(text: str, beside: dict[str, Any], tmp_path: Path):
    """Rows in turn of one crack are a line; columns besides do no harm; paths.csv of a run is in m."""
    one = load(tmp_path, LINES)
    (tmp_path / "traces.csv").write_text(text)
    other = of_file(tmp_path, "traces.csv", beside)
    for first, second in zip(one.cracks, other.cracks, strict=True):
        assert first.name == second.name
        np.testing.assert_array_equal(first.points, second.points)


def test_a_table_with_a_row_for_each_line(tmp_path: Path):
    (tmp_path / "traces.csv").write_text("FID,START_X,START_Y,END_X,END_Y\n7,0.2,0.2,0.3,0.25\n9,0.6,0.5,0.7,0.5\n")
    columns = {"start": ["START_X", "START_Y"], "end": ["END_X", "END_Y"]}
    case = of_file(tmp_path, "traces.csv", {"columns": columns, "units": "m", "names": "FID"})
    assert {crack.name: crack.points.tolist() for crack in case.cracks} == {
        "joints-7": [[0.2, 0.2], [0.3, 0.25]], "joints-9": [[0.6, 0.5], [0.7, 0.5]]
    }  # fmt: skip


# --- traces that meet ------------------------------------------------------------------------------------------------

TIPS = [("start", "end"), ("end",)]


@pytest.mark.parametrize("off", [0.0, 1e-6, -1e-6, 4.0, -4.0])
def test_an_end_on_or_near_another_trace_is_no_tip(off: float, tmp_path: Path):
    """Exactly on it, short of it or beyond it by no more than the tolerance."""
    lines: Lines = [[[200, 500], [800, 500]], [[500, 500 - off], [500, 200]]]
    case = load(tmp_path, lines, tolerance="5 mm")
    assert tips_of(case) == TIPS
    np.testing.assert_allclose(case.cracks[1].points[0], [0.5, 0.5], atol=1e-15)
    assert len(case.moved) == (abs(off) > 1e-5)
    beyond = load(tmp_path, lines, tolerance="3 mm")
    assert tips_of(beyond) == (TIPS if abs(off) < 3.0 else [("start", "end")] * 2)


def test_traces_that_cross_or_are_near_a_named_crack(tmp_path: Path):
    """Crossings stay as they are; a crack of the case stays where it is, and a trace ends on it."""
    named = {"fault": {"path": {"points": [[100, 700], [900, 700]]}, "contact": CONTACT}}
    case = load(tmp_path, [[[200, 600], [200, 800]], [[400, 500], [400, 698]]], named, tolerance="5 mm")
    joints = {crack.name: crack.points.tolist() for crack in case.cracks}
    assert joints["joints-1"] == [[0.2, 0.6], [0.2, 0.8]]
    np.testing.assert_allclose(joints["joints-2"], [[0.4, 0.5], [0.4, 0.7]], atol=1e-15)
    assert tips_of(case) == [("start", "end"), ("start",), ("start", "end")]


def test_what_is_drawn_twice_or_over_another_trace_is_there_once(tmp_path: Path):
    long: list[list[float]] = [[200, 300], [500, 310], [800, 300]]
    near: list[list[float]] = [[250, 304], [500, 308], [700, 301]]
    goes_on: list[list[float]] = [[700, 303], [800, 301], [900, 340]]
    case = load(tmp_path, [long, long[::-1], near, goes_on, [[400, 200], [400, 290]]], tolerance="5 mm")
    assert [crack.name for crack in case.cracks] == ["joints-1", "joints-4", "joints-5"]
    first, rest, _ = case.cracks
    np.testing.assert_allclose(first.points, np.array(long) / 1000, atol=0.005)
    np.testing.assert_allclose(rest.points, [first.points[-1], [0.9, 0.34]], atol=1e-15)
    assert tips_of(case) == [("start",), ("end",), ("start", "end")]
    told = [(cut.crack, cut.whole, cut.why) for cut in case.cut]
    assert told == [(f"joints-{k}", k < 4, "runs along crack 'joints-1'") for k in (2, 3, 4)]


def test_what_is_no_line_is_left_out_and_told(tmp_path: Path):
    loop: list[list[float]] = [[100, 600], [300, 700], [350, 650], [300, 600], [100, 700]]
    ring: list[list[float]] = [[600, 600], [700, 600], [700, 700], [600, 700], [600, 600]]
    repeated: list[list[float]] = [[500, 100], [500, 100], [500, 200], [500, 200], [500, 300]]
    lines: Lines = [[[100, 100], [100, 100]], [[200, 100], [203, 100]], loop, ring, repeated]
    case = load(tmp_path, lines, tolerance="5 mm")
    names = [crack.name for crack in case.cracks]
    assert names == ["joints-3-1", "joints-3-2", "joints-3-3", "joints-3-4", "joints-4-1", "joints-4-2", "joints-5"]
    assert case.cracks[-1].points.tolist() == [[0.5, 0.1], [0.5, 0.2], [0.5, 0.3]]
    told = {cut.crack: (cut.whole, cut.why, cut.where) for cut in case.cut}
    assert told == {
        "joints-1": (True, "has no length", "the shape, part 1"),
        "joints-2": (True, "is shorter than the tolerance", "the shape, part 2"),
        "joints-3": (False, "meets itself, and is divided there", "the shape, part 3"),
        "joints-4": (False, "meets itself, and is divided there", "the shape, part 4"),
        "joints-5": (False, "2 of its vertices repeat others", "the shape, part 5"),
    }


# --- attributes ------------------------------------------------------------------------------------------------------

ATTRIBUTES = [
    {"set": "J1", "id": 4, "note": "seen"},
    {"set": "J2", "id": 5.0},
    {"set": "J3", "id": None},
    {"set": "J1", "id": "a/b"},
]


def with_attributes(folder: Path) -> None:
    """Four lines with attributes as GeoJSON in a projected system, z and all."""
    features = [
        {"type": "Feature", "properties": values,
         "geometry": {"type": "LineString", "coordinates": [[200, 100 * k, 7], [400, 100 * k, 8]]}}
        for k, values in enumerate(ATTRIBUTES, 1)
    ]  # fmt: skip
    system = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3067"}}
    text = json.dumps({"type": "FeatureCollection", "crs": system, "features": features})
    (folder / "map.geojson").write_text(text)


def test_attributes_choose_lines_name_them_and_give_laws(tmp_path: Path):
    with_attributes(tmp_path)
    rough, smooth = {"friction": 0.8, "cohesion": 0}, {"friction": 0.1, "cohesion": 0}
    beside = {"where": {"set": ["J1", "J2"]}, "names": "id"}
    case = of_file(tmp_path, "map.geojson", beside, contact=rough, contact_by={"set": {"J2": smooth}})
    frictions = {crack.name: crack.contact.friction for crack in case.cracks}
    assert frictions == {"joints-4": 0.8, "joints-5": 0.1, "joints-a_b": 0.8}
    assert "contact_by" not in dump_case(case)
    (one,) = of_file(tmp_path, "map.geojson", {"where": {"set": "J1", "id": 4}}).cracks
    assert one.name == "joints-1"
    open_ = of_file(tmp_path, "map.geojson", {}, contact_by={"set": {"J1": "none", "J3": smooth}})
    assert [crack.contact and crack.contact.friction for crack in open_.cracks] == [None, 0.3, 0.1, None]
    without = of_file(tmp_path, "map.geojson", {}, contact_by={"note": {"": smooth}})  # an attribute that some have
    assert [crack.contact.friction for crack in without.cracks] == [0.3, 0.1, 0.1, 0.1]
