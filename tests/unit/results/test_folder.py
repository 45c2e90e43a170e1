"""The folder of a run: what is written is declared, and reads back as the tables, paths and meshes of the run."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import pyvista

import crackgrow
from crackgrow import cli
from crackgrow.results import vtk_frames
from crackgrow.results.declarations import FILES, RUN
from crackgrow.results.folder import FolderError, RunFolder, open_run
from tests.scenes import shipped_case
from tests.unit.results.synthetic import make_frame, make_result

pytestmark = pytest.mark.physics

NAME = "compression30"
TABLES = ("steps", "tips", "contact", "reactions", "events", "paths", "history")
SETTINGS = ["numerics.spacing=3", "growth.steps=2", "output.frames=every_step",
            "output.fields=[displacement, stress, energy_error]",
            "output.points={middle: {at: [0, 20 mm]}}"]  # fmt: skip


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[crackgrow.Run, RunFolder]:
    folder = tmp_path_factory.mktemp("door")
    return crackgrow.run_case(shipped_case(NAME, SETTINGS), folder), open_run(folder)


def test_what_a_run_its_pictures_and_its_export_write_is_declared(both: tuple[crackgrow.Run, RunFolder]) -> None:
    folder = both[1].folder
    assert cli.main(["render", str(folder), "--size", "200x200"]) == 0
    assert cli.main(["export", str(folder), "--to", "msh"]) == 0
    written = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    for known in RUN:
        pattern = re.escape(known.name).replace("NNNN", r"\d{4,}").replace("FIELD", r"\w+").replace("NAME", NAME)
        found = {name for name in written if re.fullmatch(pattern, name)}
        curves = ("figures/load_curve.png", "figures/stress_strain.png")  # loads do not vary
        assert bool(found) == (known.name not in curves), known.name
        written -= found
    assert written == set()
    of_some_runs = {"safety", "time", "cycles"}  # of reduced strength, of growth at a rate
    assert tuple(both[1].summary) == tuple(key for key in FILES["summary.json"].header if key not in of_some_runs)
    for name, file in (
        ("frames/step_0000.vtu", "frames/step_NNNN.vtu"),
        ("cracks/step_0000.vtp", "cracks/step_NNNN.vtp"),
    ):
        mesh = pyvista.read(folder / name)
        assert {*mesh.point_data.keys(), *mesh.cell_data.keys()} == set(FILES[file].header)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_of_a_folder_is_that_of_the_run(both: tuple[crackgrow.Run, RunFolder], name: str) -> None:
    """To the last digit, and with the same types; the times are those of the files alone."""
    memory, files = (getattr(run, name) for run in both)
    times = [column for column in memory.columns if column.startswith("seconds_")]
    pd.testing.assert_frame_equal(
        memory.drop(columns=times), files.drop(columns=times), check_exact=True, check_dtype=len(memory) > 0
    )


def test_status_paths_and_warnings_are_those_of_the_run(both: tuple[crackgrow.Run, RunFolder]) -> None:
    memory, files = both
    assert (files.status, files.reason, files.finished) == (memory.status, memory.reason, True)
    assert files.warnings == memory.warnings
    spent = dict.fromkeys(("wall_seconds", "cpu_seconds", "peak_memory_mb"))
    assert files.summary["n_solves"] == 3
    assert {**files.summary, **spent} == {**memory.summary, **spent}
    assert (files.case.name, files.case.to_dict()) == (memory.case.name, memory.case.to_dict())
    np.testing.assert_array_equal(files.path("flaw"), memory.path("flaw"))
    with pytest.raises(KeyError, match="no crack 'flow'; the cracks are flaw"):
        files.path("flow")


def test_a_mesh_of_a_folder_is_that_of_the_step(both: tuple[crackgrow.Run, RunFolder]) -> None:
    memory, files = both
    mesh, kept = files.mesh(1), memory.mesh(1)
    np.testing.assert_array_equal(mesh.points, kept.points)
    for ours, theirs in ((kept.point_data, mesh.point_data), (kept.cell_data, mesh.cell_data)):
        assert list(ours) == list(theirs)
        for field in ours:
            np.testing.assert_array_equal(ours[field], theirs[field])
    assert list(files.frames) == files.solved == [0, 1, 2]
    np.testing.assert_array_equal(files.mesh().points, files.mesh(2).points)
    with pytest.raises(FolderError, match=r"has no frame of step 7; it has those of 0 to 2"):
        files.mesh(7)


@pytest.mark.parametrize("where", ["points", "cells"])
def test_stress_is_a_named_tensor_with_its_principal_values(tmp_path: Path, where: str) -> None:
    frame = make_frame()
    vtk_frames.write_frame(tmp_path / "a.vtu", frame, ("stress",))
    grid = pyvista.read(tmp_path / "a.vtu")
    data = grid.point_data if where == "points" else grid.cell_data
    given, zz = (frame.point_stress, frame.point_stress_zz) if where == "points" else (frame.stress, frame.stress_zz)
    array = data.VTKObject.GetArray("stress")
    assert [array.GetComponentName(k) for k in range(6)] == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
    np.testing.assert_array_equal(data["stress"][:, [0, 1, 3]], given)
    np.testing.assert_array_equal(data["stress"][:, 2], zz)
    principal = np.linalg.eigvalsh(np.array([[[xx, xy], [xy, yy]] for xx, yy, xy in given]))  # ascending
    np.testing.assert_allclose(data["sigma_3"], principal[:, 0], rtol=1e-12)
    np.testing.assert_allclose(data["sigma_1"], principal[:, 1], rtol=1e-9)  # cancellation near zero
    assert "displacement" not in grid.point_data


def test_faces_of_cracks_read_back_whatever_script_their_names_are_in(tmp_path: Path) -> None:
    (face,) = (replace(face, crack="Spalt_ü節") for face in make_result(2).faces)
    vtk_frames.write_cracks(tmp_path / "a.vtp", [face])
    mesh = pyvista.read(tmp_path / "a.vtp")
    assert mesh.n_cells == 1
    np.testing.assert_array_equal(mesh.get_cell(0).point_ids, range(4))
    np.testing.assert_array_equal(mesh.points[:, :2], face.points)
    for name in ("s", "opening", "slip", "normal_traction", "tangential_traction", "state"):
        np.testing.assert_array_equal(mesh.point_data[name], getattr(face, name))
    np.testing.assert_array_equal(mesh.cell_data["crack"], [0])
    assert mesh.GetFieldData().GetAbstractArray("crack_names").GetValue(0) == "Spalt_ü節"


def test_a_run_that_goes_on_is_read_as_far_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("[" * 10_000)
    assert RunFolder(tmp_path).found_summary == {}
    (tmp_path / "summary.json").write_text(json.dumps({"status": "running", "stop_reason": "the run goes on"}))
    run = open_run(tmp_path)
    assert (run.status, run.finished) == ("running", False)
    with pytest.raises(FolderError, match=re.escape("it has no case, title, n_solves")):
        assert run.summary
