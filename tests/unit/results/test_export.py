"""Frames as mesh files and crack paths as lines of other programs: opened again they hold what the run has."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import ezdxf
import meshio
import numpy as np
import pytest
import pyvista

from crackgrow import cli
from crackgrow.cli.command_line import declared
from crackgrow.results.export import APPLICATION, FORMATS, PATHS, UNITS, export
from crackgrow.results.folder import open_run
from tests.report_runs import make_run

pytestmark = pytest.mark.physics

WITH_FIELDS = [to for to in FORMATS if to not in ("inp", *PATHS)]  # Abaqus' format has none
NAMES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "sigma_1", "sigma_3")

LAYERS = """
title: Two layers with a crack
plane: strain
bodies:
  lower: {shape: {rectangle: {center: [0, -1], width: 4, height: 2}}, material: {young: 1 GPa, poisson: 0.2}}
  upper: {shape: {polygon: [[-2, 0], [2, 0], [1.7, 2], [-2, 1.8]]}, material: {young: 2 GPa, poisson: 0.2}}
interfaces: [{between: [lower, upper], contact: {friction: 0.5, cohesion: 0}}]
cracks: {flaw: {path: {points: [[-0.5, -1.2], [0.6, -0.9]]}, contact: {friction: 0.3, cohesion: 0}}}
supports: [{on: {body: lower, edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{on: {body: upper, edge: "2"}, traction: [0, -1 MPa]}]
loading: {history: [0.5, 1]}
numerics: {spacing: 0.4}
output: {report: false, figures: false, frames: every_step, fields: [displacement, stress, energy_error]}
"""


@pytest.fixture(scope="module")
def layers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two bodies under two loads, with frames."""
    place = tmp_path_factory.mktemp("layers")
    (place / "layers.yaml").write_text(LAYERS)
    assert cli.main(["run", str(place / "layers.yaml"), "--out", str(place / "run"), "--quiet"]) == 0
    return place / "run"


def by_cell(mesh: meshio.Mesh, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], kind: str) -> object:
    """Values of points at the corners of the cells of a kind: the same however points are numbered."""
    return np.concatenate([values[block.data] for block in mesh.cells if block.type == kind])


@pytest.mark.parametrize("to", WITH_FIELDS)
def test_points_cells_and_fields_are_those_of_the_frame(layers: Path, tmp_path: Path, to: str) -> None:
    path = export(layers, to, step=1, out=tmp_path / f"a.{to}")
    mesh, grid = meshio.read(path), pyvista.read(layers / "frames" / "step_0001.vtu")
    kinds = {block.type for block in mesh.cells}
    assert kinds == {"triangle", "quad"}
    order = np.argsort(grid.cell_data["body"], kind="stable")
    for kind, number in (("triangle", 5), ("quad", 9)):
        chosen = order[grid.celltypes[order] == number]
        corners = np.array([grid.get_cell(cell).point_ids for cell in chosen])
        np.testing.assert_array_equal(by_cell(mesh, mesh.points, kind), grid.points[corners])
        given = {"displacement": grid.point_data["displacement"]}
        given |= dict(zip(NAMES[:4], grid.point_data["stress"].T, strict=False))
        given |= {name: grid.point_data[name] for name in NAMES[4:]}
        for name, values in given.items():
            np.testing.assert_array_equal(by_cell(mesh, mesh.point_data[name], kind), values[corners])
        for name in ("body", "sigma_1", "energy_error"):
            np.testing.assert_array_equal(mesh.cell_data_dict[name][kind], grid.cell_data[name][chosen])


def test_gmsh_has_bodies_as_physical_groups(layers: Path, tmp_path: Path) -> None:
    mesh = meshio.read(export(layers, "msh", out=tmp_path / "a.msh"))
    body = np.concatenate(mesh.cell_data["body"])
    assert {name: group.tolist() for name, group in mesh.field_data.items()} == {"lower": [1, 2], "upper": [2, 2]}
    np.testing.assert_array_equal(np.concatenate(mesh.cell_data["gmsh:physical"]), body + 1)


def test_abaqus_has_sets_of_plane_elements_for_each_body(layers: Path, tmp_path: Path) -> None:
    path = export(layers, "inp", out=tmp_path / "a.inp")
    mesh, grid = meshio.read(path), pyvista.read(layers / "frames" / "step_0001.vtu")
    assert {line for line in path.read_text().splitlines() if line.startswith("*ELEMENT")} == {
        "*ELEMENT, TYPE=CPS3", "*ELEMENT, TYPE=CPS4"}  # fmt: skip
    np.testing.assert_array_equal(mesh.points, grid.points)
    sizes = {name: sum(len(part) for part in parts) for name, parts in mesh.cell_sets.items()}
    kinds = [("triangle", 5), ("quad", 9)]
    assert sizes == {
        f"{name}_{kind}": np.sum((grid.cell_data["body"] == body) & (grid.celltypes == number))
        for body, name in enumerate(("lower", "upper")) for kind, number in kinds
    }  # fmt: skip


def test_the_command_says_where_the_file_is(layers: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert tuple(declared()["words"]["formats"]) == FORMATS
    assert cli.main(["export", str(layers), "--to", "vtk"]) == 0
    assert capsys.readouterr().out == f"{layers / 'export' / 'step_0001.vtk'}\n"
    assert cli.main(["export", str(layers), "--to", "vtk", "--step", "0"]) == 0
    assert sorted(path.name for path in (layers / "export").iterdir()) == ["step_0000.vtk", "step_0001.vtk"]
    assert cli.main(["export", str(layers), "--to", "xdmf", "--out", str(layers / "step.1")]) == 0


@pytest.mark.parametrize(("words", "told"), [
    (["--to", "msh", "--step", "7"], "has no frame of step 7; it has those of 0 to 1"),
    (["--to", "geojson", "--step", "7"], "has no solved step 7; it has 0 to 1"),
    (["--to", "xdmf", "--out", "x.vtk"], "x.vtk: the name ends in .vtk, and the format that is asked for is xdmf"),
])  # fmt: skip
def test_what_cannot_be_exported_is_refused(
    words: list[str], told: str, layers: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", str(layers), *words]) == 3
    assert told in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A flaw with three steps of growth."""
    return make_run(tmp_path_factory.mktemp("run"), ["output.frames=every_step"])


def features(path: Path) -> list[dict[str, Any]]:
    found = json.loads(path.read_text(encoding="utf-8"))
    assert (found["type"], found["units"], found["crs"]) == ("FeatureCollection", UNITS, None)
    return [feature["properties"] | feature["geometry"] for feature in found["features"]]


def lines_of(path: Path) -> list[dict[str, Any]]:
    return [line for line in features(path) if line["type"] == "LineString"]


def test_lines_are_the_paths_piece_by_piece(folder: Path) -> None:
    lines = lines_of(export(folder, "geojson"))
    assert [(line["kind"], line["tip"], line["step"]) for line in lines] == [
        ("given", "", 0), ("grown", "start", 1), ("grown", "end", 2), ("grown", "end", 3)
    ]  # fmt: skip
    vertices = {tuple(row) for row in open_run(folder).paths[["x", "y"]].to_numpy()}
    assert {tuple(point) for line in lines for point in line["coordinates"]} == vertices
    lengths = [np.linalg.norm(np.diff(line["coordinates"], axis=0), axis=1).sum() for line in lines]
    assert [line["length"] for line in lines] == pytest.approx(lengths)
    assert lengths[1:] == pytest.approx([2e-3] * 3)


@pytest.mark.parametrize(("step", "grown"), [(3, [1, 2, 3]), (1, [1])])
def test_K_of_a_line_is_that_of_the_tip_that_grew_by_it(step: int, grown: list[int], folder: Path) -> None:
    """Also in an earlier step, whose paths and tips are those of then."""
    tips = open_run(folder).tips
    path = export(folder, "geojson", step=step)
    assert path.name == f"step_{step:04d}.geojson"
    found = features(path)
    assert [line["step"] for line in found if line["kind"] == "grown"] == grown
    for line in found:
        if line["kind"] == "given":
            assert line["K_I"] is line["K_II"] is None
            continue
        then = line["step"] - 1 if line["kind"] == "grown" else step
        (row,) = tips[(tips["step"] == then) & (tips["tip"] == line["tip"])].itertuples()
        assert row.advanced or line["kind"] == "tip"
        assert (line["K_I"], line["K_II"]) == (row.K_I, row.K_II)
        if line["kind"] == "tip":
            assert line["coordinates"] == pytest.approx([row.x, row.y], abs=1e-8)


def test_slip_and_opening_are_those_of_the_faces(folder: Path, tmp_path: Path) -> None:
    contact = open_run(folder).contact
    last = contact[contact["step"] == 3]
    given, *_, end = lines_of(export(folder, "geojson"))
    middle = last.iloc[(last["s"] - 9e-3).abs().argmin()]  # of the flaw of 10 mm, behind 4 mm of wing
    assert given["slip"] == pytest.approx(middle["slip"], rel=0.05)
    assert given["opening"] == pytest.approx(0.0, abs=0.05 * abs(given["slip"]))
    assert end["opening"] > 0.1 * abs(given["slip"])
    without = Path(shutil.copytree(folder, tmp_path / "without", ignore=shutil.ignore_patterns("cracks")))
    by_points, *_ = lines_of(export(without, "geojson"))  # a run without frames has its contact points alone
    assert by_points["slip"] == pytest.approx(given["slip"], rel=0.05)


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
        for name in ("K_II", "slip"):
            assert told.get(name) == (None if line[name] is None else str(line[name]))
    assert known == {}
