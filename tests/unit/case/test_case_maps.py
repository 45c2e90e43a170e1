"""Maps of joints: files of programs of maps and drawings, and whole maps, which are brought together and told."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow import cli
from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError
from tests.joint_maps import SHIPPED, case_text, joint_map
from tests.scenes import shipped_case
from tests.unit.case import scenes
from tests.unit.case.scenes import CASES, rectangle, with_body

DXF = """0\nSECTION\n2\nENTITIES
0\nLINE\n8\njoints\n10\n1.0\n20\n1.0\n30\n5.0\n11\n3.0\n21\n2.0\n31\n5.0
0\nLWPOLYLINE\n8\nfaults\n90\n3\n70\n0\n10\n5.0\n20\n5.0\n10\n6.0\n20\n5.5\n10\n7.0\n20\n5.0
0\nENDSEC\n0\nEOF\n"""


def write(file: Path, driver: str = "GPKG", layer: str | None = None, crs: str = "EPSG:3067") -> None:
    """Two features, the second one of two lines, with the attributes `set` and `n`."""
    import pyogrio

    shapes = shapely.from_wkt(["LINESTRING Z (1 1 7, 3 2 8)", "MULTILINESTRING ((5 5, 6 5), (7 7, 8 8))"])
    kind = "Unknown"
    if driver == "ESRI Shapefile":
        shapes = [shapely.MultiLineString(shapely.get_parts(shape).tolist()) for shape in shapely.force_2d(shapes)]
        kind = "MultiLineString"
    values = [np.array(["J1", "J2"], dtype=object), np.array([4, 5])]
    pyogrio.raw.write(
        file, shapely.to_wkb(shapes), values, np.array(["set", "n"], dtype=object),
        crs=crs, geometry_type=kind, driver=driver, layer=layer,
    )  # fmt: skip


def load(folder: Path, shape: Any = None, **path: Any) -> Case:
    """A block of 10 m with the lines of a file as a set of cracks."""
    scene = {**with_body(shape or rectangle(0, 0, 10, 10)), "supports": "minimal"}
    scene["cracks"] = {"j": {"path": path, "contact": "none"}}
    scene["numerics"] = {"spacing": 1}
    return scenes.load(folder, scene)


@pytest.mark.parametrize(("name", "driver"), [("a.gpkg", "GPKG"), ("a.shp", "ESRI Shapefile")])
def test_lines_and_attributes_of_a_program_of_maps(name: str, driver: str, tmp_path: Path):
    write(tmp_path / name, driver)
    case = load(tmp_path, file=name)
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5]], [[7, 7], [8, 8]]]
    chosen = load(tmp_path, file=name, where={"set": "J2"}, names="n")
    assert [crack.name for crack in chosen.cracks] == ["j-5-1", "j-5-2"]


def test_lines_of_a_drawing(tmp_path: Path):
    (tmp_path / "a.dxf").write_text(DXF)
    case = load(tmp_path, file="a.dxf", units="m")
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5.5], [7, 5]]]
    (fault,) = load(tmp_path, file="a.dxf", where={"Layer": "faults"}).cracks
    assert len(fault.points) == 3


@pytest.mark.parametrize(("path", "words"), [
    ({"file": "a.gpkg"}, "has several layers; `layer` says which: it has joints, faults"),
    ({"file": "a.gpkg", "layer": "joint"}, "has no layer 'joint'; it has joints, faults; did you mean 'joints'"),
    ({"file": "degrees.gpkg"}, r"is in degrees of longitude and latitude \(EPSG:4326\)"),
    ({"file": "none.gpkg"}, "cannot be read as|holds nothing"),
    ({"file": "none.shp"}, "cannot be read as|holds nothing"),
    ({"file": "none.dxf"}, "cannot be read as|holds nothing"),
])  # fmt: skip
def test_layers_degrees_and_files_that_are_none_are_told(path: dict[str, str], words: str, tmp_path: Path):
    write(tmp_path / "a.gpkg", layer="joints")
    write(tmp_path / "a.gpkg", layer="faults")
    write(tmp_path / "degrees.gpkg", crs="EPSG:4326")
    for name in ("none.gpkg", "none.shp", "none.dxf"):
        (tmp_path / name).write_text("nothing")
    with pytest.raises(CaseError, match=words):
        load(tmp_path, **path)
    assert len(load(tmp_path, file="a.gpkg", layer="faults").cracks) == 3


def test_without_the_extra_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write(tmp_path / "a.gpkg")
    monkeypatch.setitem(sys.modules, "pyogrio", None)
    with pytest.raises(CaseError, match=r"needs pyogrio to be read: pip install 'crackgrow\[maps\]'"):
        load(tmp_path, file="a.gpkg")


# --- whole maps ------------------------------------------------------------------------------------------------------


@pytest.mark.physics
@pytest.mark.parametrize(("n", "seed"), [*((50, k) for k in range(6)), (200, 0), (700, 0)])
def test_a_map_loads_and_is_brought_together(n: int, seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """No tip is left within the tolerance of anything, and none of the joints that are well drawn is lost."""
    map_ = joint_map(n, seed)
    (map_.write(tmp_path) / "scene.yaml").write_text(case_text(map_))
    case = load_case(tmp_path / "scene.yaml")
    lines = [shapely.LineString(crack.points) for crack in case.cracks]
    rims = [shapely.LinearRing(ring.points) for ring in case.bodies[0].rings]
    tree = shapely.STRtree([*lines, *rims])
    for number, crack in enumerate(case.cracks):
        tips = shapely.points(crack.points[[0, -1]][[crack.tip_at_start, crack.tip_at_end]])
        near = tree.query(tips, predicate="dwithin", distance=0.999 * map_.tolerance)[1]
        assert set(near) <= {number}
    why = Counter(cut.why.split(" ")[0] for cut in case.cut)
    wanted = map_.defects
    assert why["has"] == wanted["no length"]
    assert why["runs"] >= wanted["twice"] + wanted["stacked"]
    rock = shapely.Polygon(case.bodies[0].outline).buffer(-2 * map_.tolerance)
    kept = shapely.union_all(lines).buffer(2.0 * map_.tolerance)
    lost = [
        shapely.LineString(points - case.origin).intersection(rock).difference(kept).length for points, _ in map_.traces
    ]
    assert max(lost) < 10.0 * map_.tolerance
    sets = {str(number): values["set"] for number, (_, values) in enumerate(map_.traces, 1)}
    for crack in case.cracks:
        assert crack.contact.friction == (0.4 if sets[crack.name.split("-")[1]] == "J2" else 0.7)
    if (n, seed) == (200, 0):
        assert cli.main(["check", str(tmp_path / "scene.yaml")]) == 0
        told = capsys.readouterr().out
        assert "these were moved: " in told
        assert "was left out of cracks, " in told


@pytest.mark.physics
def test_the_shipped_map_is_one_of_these_brought_together_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    joint_map(*SHIPPED).write(tmp_path, "joint_map_")
    for name in ("joint_map_joints.geojson", "joint_map_outline.geojson"):
        made, shipped = (json.loads((folder / name).read_text())["features"] for folder in (tmp_path, CASES))
        for one, other in zip(made, shipped, strict=True):
            assert one["properties"] == other["properties"]
            np.testing.assert_allclose(one["geometry"]["coordinates"], other["geometry"]["coordinates"], atol=2e-6)
    case = shipped_case("joint_map")
    assert (len(case.cracks), len({crack.name.split("-")[1] for crack in case.cracks})) == (43, 39)
    assert {crack.contact.friction for crack in case.cracks} == {0.4, 0.7}
    assert cli.main(["check", str(CASES / "joint_map.yaml")]) == 0
    told = capsys.readouterr().out
    assert "these were moved: the end of crack 'joints-3'" in told
    assert "all of 'joints-18' (feature 18)" in told
