"""Maps of programs for geographic information and drawing, which GDAL reads; the files are written here."""

from __future__ import annotations

import builtins
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError

LINES = ["LINESTRING Z (1 1 7, 3 2 8)", "MULTILINESTRING ((5 5, 6 5), (7 7, 8 8))"]

DXF = """0\nSECTION\n2\nENTITIES
0\nLINE\n8\njoints\n10\n1.0\n20\n1.0\n30\n5.0\n11\n3.0\n21\n2.0\n31\n5.0
0\nLWPOLYLINE\n8\nfaults\n90\n3\n70\n0\n10\n5.0\n20\n5.0\n10\n6.0\n20\n5.5\n10\n7.0\n20\n5.0
0\nENDSEC\n0\nEOF\n"""


def write(file: Path, driver: str, layer: str | None = None, crs: str = "EPSG:3067", lines: list[str] = LINES) -> None:
    """The lines with the attributes `set` and `n`."""
    import pyogrio

    shapes = shapely.from_wkt(lines)
    if driver == "ESRI Shapefile":
        shapes = [shapely.MultiLineString(shapely.get_parts(shape).tolist()) for shape in shapely.force_2d(shapes)]
    values = [np.array(["J1", "J2"], dtype=object), np.array([4, 5])]
    kind = "MultiLineString" if driver == "ESRI Shapefile" else "Unknown"
    pyogrio.raw.write(
        file, shapely.to_wkb(shapes), values, np.array(["set", "n"], dtype=object),
        crs=crs, geometry_type=kind, driver=driver, layer=layer,
    )  # fmt: skip


def load(folder: Path, **path: Any) -> Case:
    """A block of 10 m with the lines of a file as a set of cracks."""
    body = {"shape": {"rectangle": {"center": [5, 5], "width": 10, "height": 10}},
            "material": {"young": "10 GPa", "poisson": 0.2}}  # fmt: skip
    content = {
        "title": "a map", "plane": "strain", "bodies": {"rock": body}, "numerics": {"spacing": 1},
        "cracks": {"j": {"path": path, "contact": "none"}}, "supports": "minimal",
    }  # fmt: skip
    (folder / "scene.yaml").write_text(json.dumps(content))
    return load_case(folder / "scene.yaml")


@pytest.mark.parametrize(("name", "driver"), [("a.gpkg", "GPKG"), ("a.shp", "ESRI Shapefile")])
def test_lines_and_attributes_of_a_program_of_maps(name: str, driver: str, tmp_path: Path) -> None:
    write(tmp_path / name, driver)
    case = load(tmp_path, file=name)
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5]], [[7, 7], [8, 8]]]
    chosen = load(tmp_path, file=name, where={"set": "J2"}, names="n")
    assert [crack.name for crack in chosen.cracks] == ["j-5-1", "j-5-2"]


def test_lines_of_a_drawing(tmp_path: Path) -> None:
    (tmp_path / "a.dxf").write_text(DXF)
    case = load(tmp_path, file="a.dxf", units="m")
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5.5], [7, 5]]]
    (fault,) = load(tmp_path, file="a.dxf", where={"Layer": "faults"}).cracks
    assert len(fault.points) == 3


def test_an_outline_of_a_program_of_maps(tmp_path: Path) -> None:
    import pyogrio

    ring = shapely.from_wkt(["POLYGON ((0 0, 1200 0, 1200 1200, 0 1200, 0 0), (500 100, 600 100, 600 200, 500 100))"])
    none = np.array([], dtype=object)
    pyogrio.raw.write(tmp_path / "rock.gpkg", shapely.to_wkb(ring), [], none, crs="EPSG:3067", geometry_type="Polygon")
    write(tmp_path / "a.gpkg", "GPKG")
    load(tmp_path, file="a.gpkg")
    content = json.loads((tmp_path / "scene.yaml").read_text())
    content["bodies"]["rock"]["shape"] = {"file": "rock.gpkg", "units": "cm", "origin": [100, 200]}
    (tmp_path / "scene.yaml").write_text(json.dumps(content))
    outline, hole = load_case(tmp_path / "scene.yaml").bodies[0].rings
    assert (outline.points.min(axis=0).tolist(), outline.points.max(axis=0).tolist()) == ([-1, -2], [11, 10])
    assert sorted(hole.points.tolist()) == [[4, -1], [5, -1], [5, 0]]


def test_layers_are_told(tmp_path: Path) -> None:
    write(tmp_path / "a.gpkg", "GPKG", "joints")
    write(tmp_path / "a.gpkg", "GPKG", "faults")
    assert len(load(tmp_path, file="a.gpkg", layer="faults").cracks) == 3
    with pytest.raises(CaseError, match="has several layers; `layer` says which: it has joints, faults"):
        load(tmp_path, file="a.gpkg")
    with pytest.raises(CaseError, match="has no layer 'joint'; it has joints, faults; did you mean 'joints'"):
        load(tmp_path, file="a.gpkg", layer="joint")


def test_degrees_of_a_program_of_maps_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "a.gpkg", "GPKG", crs="EPSG:4326")
    with pytest.raises(CaseError, match=r"is in degrees of longitude and latitude \(EPSG:4326\)"):
        load(tmp_path, file="a.gpkg")


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    for name in ("a.gpkg", "a.shp", "a.dxf"):
        (tmp_path / name).write_text("nothing")
        with pytest.raises(CaseError, match=r"cannot be read as|holds nothing"):
            load(tmp_path, file=name)


def test_without_the_extra_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "a.gpkg", "GPKG")
    real = builtins.__import__

    def without(name: str, *rest: Any) -> Any:
        if name == "pyogrio":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(CaseError, match=r"needs pyogrio to be read: pip install 'crackgrow\[maps\]'"):
        load(tmp_path, file="a.gpkg")
