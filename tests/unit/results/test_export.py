"""Frames as mesh files of other programs: opened again they hold the same cells and fields."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista

from crackgrow import cli
from crackgrow.cli.look import FORMATS as TOLD
from crackgrow.results.export import FORMATS, _write, export, frame_mesh
from crackgrow.results.export_paths import FORMATS as PATHS
from crackgrow.results.folder import FolderError, RunFolder
from crackgrow.results.vtk_frames import write_frame
from tests.report_runs import make_run
from tests.unit.results.synthetic import make_frame

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
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two bodies under two loads, with frames."""
    place = tmp_path_factory.mktemp("layers")
    (place / "layers.yaml").write_text(LAYERS)
    assert cli.main(["run", str(place / "layers.yaml"), "--out", str(place / "run"), "--quiet"]) == 0
    return place / "run"


def by_cell(mesh: meshio.Mesh, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], kind: str) -> object:
    """Values of points at the corners of the cells of a kind: the same however points are numbered."""
    return np.concatenate([values[block.data] for block in mesh.cells if block.type == kind])


@pytest.mark.parametrize("to", WITH_FIELDS)
def test_points_cells_and_fields_are_those_of_the_frame(folder: Path, tmp_path: Path, to: str) -> None:
    path = export(folder, to, step=1, out=tmp_path / f"a.{to}")
    mesh, grid = meshio.read(path), pyvista.read(folder / "frames" / "step_0001.vtu")
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


def test_gmsh_has_bodies_as_physical_groups(folder: Path, tmp_path: Path) -> None:
    mesh = meshio.read(export(folder, "msh", out=tmp_path / "a.msh"))
    body = np.concatenate(mesh.cell_data["body"])
    assert {name: group.tolist() for name, group in mesh.field_data.items()} == {"lower": [1, 2], "upper": [2, 2]}
    np.testing.assert_array_equal(np.concatenate(mesh.cell_data["gmsh:physical"]), body + 1)


def test_abaqus_has_sets_of_plane_elements_for_each_body(folder: Path, tmp_path: Path) -> None:
    path = export(folder, "inp", out=tmp_path / "a.inp")
    mesh, grid = meshio.read(path), pyvista.read(folder / "frames" / "step_0001.vtu")
    assert {line for line in path.read_text().splitlines() if line.startswith("*ELEMENT")} == {
        "*ELEMENT, TYPE=CPS3", "*ELEMENT, TYPE=CPS4"}  # fmt: skip
    np.testing.assert_array_equal(mesh.points, grid.points)
    sizes = {name: sum(len(part) for part in parts) for name, parts in mesh.cell_sets.items()}
    kinds = [("triangle", 5), ("quad", 9)]
    assert sizes == {
        f"{name}_{kind}": np.sum((grid.cell_data["body"] == body) & (grid.celltypes == number))
        for body, name in enumerate(("lower", "upper")) for kind, number in kinds
    }  # fmt: skip


def test_a_surface_that_shares_all_its_points_is_not_lost(tmp_path: Path) -> None:
    """Gmsh's format names each point in one surface; two triangles inside of quads share all of theirs."""
    frame = make_frame()
    whole = replace(frame, triangles=frame.quads[:2, :3])
    write_frame(tmp_path / "a.vtu", whole, ("displacement",))
    grid = pyvista.read(tmp_path / "a.vtu")
    assert isinstance(grid, pyvista.UnstructuredGrid)
    _write(tmp_path / "a.msh", frame_mesh(grid, ["rock"]), "msh")
    mesh = meshio.read(tmp_path / "a.msh")
    corners = np.concatenate([whole.triangles.ravel(), whole.quads.ravel()])
    found = np.concatenate([block.data.ravel() for block in mesh.cells])
    np.testing.assert_array_equal(mesh.points[found, :2], whole.points[corners])
    np.testing.assert_array_equal(mesh.point_data["displacement"][found, :2], whole.displacement[corners])


def test_fields_that_a_run_left_out_are_left_out(tmp_path: Path) -> None:
    run = make_run(tmp_path / "run", ["output.frames=every_step", "growth.steps=0", "output.fields=[displacement]"])
    mesh = meshio.read(export(run, "xdmf"))
    assert set(mesh.point_data) == {"displacement"}


def test_the_command_tells_of_every_format() -> None:
    assert tuple(TOLD) == FORMATS


def test_the_command_says_where_the_file_is(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["export", str(folder), "--to", "vtk"]) == 0
    assert capsys.readouterr().out == f"{folder / 'export' / 'step_0001.vtk'}\n"
    assert cli.main(["export", str(folder), "--to", "vtk", "--step", "0"]) == 0
    assert sorted(path.name for path in (folder / "export").iterdir()) == ["step_0000.vtk", "step_0001.vtk"]


def test_a_step_without_a_frame_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["export", str(folder), "--to", "msh", "--step", "7"]) == 3
    assert f"{folder} has no frame of step 7; it has those of 0 to 1" in capsys.readouterr().err


def test_a_name_that_ends_as_another_format_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wing.vtk"
    assert cli.main(["export", str(folder), "--to", "xdmf", "--out", str(out)]) == 3
    assert "wing.vtk: the name ends in .vtk, and the format that is asked for is xdmf" in capsys.readouterr().err
    assert not out.exists()
    assert cli.main(["export", str(folder), "--to", "xdmf", "--out", str(tmp_path / "step.1")]) == 0


@pytest.mark.parametrize(("arguments", "wanted"), [
    (["--to", "stl"], "'stl' is none of msh, inp, vtk, xdmf, geojson, dxf"),
    (["--to", "msh", "--step", "last"], "'last': the number of a step is wanted, from 0 on"),
    ([], "the following arguments are required: --to"),
])  # fmt: skip
def test_bad_arguments_are_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], wanted: str) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["export", "somewhere", *arguments])
    assert ended.value.code == 2
    assert wanted in capsys.readouterr().err


def test_a_damaged_frame_is_named(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "frames" / "step_0000.vtu"
    write_frame(path, make_frame(), ())
    grid = pyvista.read(path)
    grid.cell_data.clear()
    grid.save(path)
    with pytest.raises(FolderError, match="it has no cells of bodies; run the case again"):
        RunFolder(tmp_path).mesh()
