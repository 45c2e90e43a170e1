"""Crack paths as GeoJSON and DXF: read back they are those of paths.csv, with the numbers of the tables."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

from crackgrow import cli
from crackgrow.results.export import export
from crackgrow.results.export_paths import APPLICATION, UNITS
from crackgrow.results.folder import open_run
from tests.report_runs import make_run


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A flaw with three steps of growth."""
    return make_run(tmp_path_factory.mktemp("run"), ["output.frames=every_step"])


def features(path: Path) -> list[dict[str, Any]]:
    found = json.loads(path.read_text(encoding="utf-8"))
    assert (found["type"], found["units"], found["crs"]) == ("FeatureCollection", UNITS, None)
    return [feature["properties"] | feature["geometry"] for feature in found["features"]]


def test_lines_are_the_paths_piece_by_piece(folder: Path) -> None:
    found = features(export(folder, "geojson"))
    lines = [line for line in found if line["type"] == "LineString"]
    assert [(line["kind"], line["tip"], line["step"]) for line in lines] == [
        ("given", "", 0), ("grown", "start", 1), ("grown", "end", 2), ("grown", "end", 3)
    ]  # fmt: skip
    paths = open_run(folder).paths
    vertices = {tuple(row) for row in paths[["x", "y"]].to_numpy()}
    assert {tuple(point) for line in lines for point in line["coordinates"]} == vertices
    lengths = [np.linalg.norm(np.diff(line["coordinates"], axis=0), axis=1).sum() for line in lines]
    assert [line["length"] for line in lines] == pytest.approx(lengths)
    assert lengths[1:] == pytest.approx([2e-3] * 3)


def test_K_of_a_line_is_that_of_the_tip_that_grew_by_it(folder: Path) -> None:
    tips = open_run(folder).tips
    for line in features(export(folder, "geojson")):
        if line["kind"] == "given":
            assert line["K_I"] is line["K_II"] is None
            continue
        step = line["step"] - 1 if line["kind"] == "grown" else 3
        (row,) = tips[(tips["step"] == step) & (tips["tip"] == line["tip"])].itertuples()
        assert row.advanced == (line["kind"] == "grown")
        assert (line["K_I"], line["K_II"]) == (row.K_I, row.K_II)
        if line["kind"] == "tip":
            assert line["coordinates"] == pytest.approx([row.x, row.y], abs=1e-8)


def test_slip_and_opening_are_those_of_the_faces(folder: Path, tmp_path: Path) -> None:
    contact = open_run(folder).contact
    last = contact[contact["step"] == 3]
    given, *_, end = (line for line in features(export(folder, "geojson")) if line["type"] == "LineString")
    middle = last.iloc[(last["s"] - 9e-3).abs().argmin()]  # of the flaw of 10 mm, behind 4 mm of wing
    assert given["slip"] == pytest.approx(middle["slip"], rel=0.05)
    assert given["opening"] == pytest.approx(0.0, abs=0.05 * abs(given["slip"]))
    assert end["opening"] > 0.1 * abs(given["slip"])
    for file in (folder / "cracks").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
        file.unlink()
    try:  # a run without frames has its contact points alone
        by_points, *_ = features(export(folder, "geojson"))
    finally:
        for file in tmp_path.iterdir():
            (folder / "cracks" / file.name).write_bytes(file.read_bytes())
    assert by_points["slip"] == pytest.approx(given["slip"], rel=0.05)


def test_the_paths_of_an_earlier_step_are_those_of_then(folder: Path) -> None:
    path = export(folder, "geojson", step=1)
    assert path.name == "step_0001.geojson"
    found = features(path)
    assert [line["step"] for line in found if line["type"] == "LineString"] == [0, 1]
    then = open_run(folder).tips
    row = then[(then["step"] == 1) & (then["tip"] == "start")].iloc[0]
    (tip,) = (line for line in found if (line["kind"], line["tip"]) == ("tip", "start"))
    assert (tip["K_I"], tip["coordinates"]) == (row["K_I"], pytest.approx([row["x"], row["y"]], abs=1e-8))


def test_dxf_has_layers_metres_and_attributes(folder: Path) -> None:
    drawing = ezdxf.readfile(export(folder, "dxf"))
    assert drawing.header["$INSUNITS"] == 6  # metres
    assert drawing.audit().errors == []
    known = {}
    for entity in drawing.modelspace():
        told = dict(text.value.split(": ", 1) for text in entity.get_xdata(APPLICATION))
        assert (told["kind"], told["units"]) == (entity.dxf.layer, UNITS)
        at = entity.get_points("xy") if entity.dxftype() == "LWPOLYLINE" else [entity.dxf.location.vec2]
        known[told["kind"], told["tip"], told["step"]] = (told, at)
    for line in features(export(folder, "geojson")):
        told, at = known.pop((line["kind"], line["tip"], str(line["step"])))
        np.testing.assert_allclose(np.reshape(line["coordinates"], (-1, 2)), np.array(at), rtol=1e-12)
        assert {name: told.get(name) for name in ("K_II", "slip")} == {
            name: None if line[name] is None else str(line[name]) for name in ("K_II", "slip")
        }
    assert known == {}


def test_dxf_without_its_library_says_how_to_get_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "ezdxf"]:
        monkeypatch.setitem(sys.modules, name, None)
    assert cli.main(["export", str(folder), "--to", "dxf"]) == 3
    assert capsys.readouterr().err.endswith("ezdxf, which is not there: pip install 'crackgrow[maps]'\n")


def test_a_step_that_was_not_solved_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["export", str(folder), "--to", "geojson", "--step", "7"]) == 3
    assert f"{folder} has no solved step 7; it has 0 to 3" in capsys.readouterr().err
