"""The Python interface: its examples run, and what it gives is what is on disk, is declared, and was solved."""

from __future__ import annotations

import doctest
import html
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import pyvista
from pandas.testing import assert_frame_equal

import crackgrow
from crackgrow import api, cli
from crackgrow.api import SolvedRun
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from crackgrow.results import vtk_frames
from crackgrow.results.atomic import FolderError
from crackgrow.results.declarations import FILES, RUN
from crackgrow.results.folder import RunFolder, open_run
from tests.scenes import shipped_case
from tests.unit.results.synthetic import make_frame, make_result

pytestmark = pytest.mark.physics

ROOT = Path(__file__).resolve().parents[2]
COARSE = ("numerics.spacing=3", "output.figures=false")
NAME = "compression30"
TABLES = ("steps", "tips", "contact", "reactions", "events", "paths", "history")
SETTINGS = ["numerics.spacing=3", "growth.steps=2", "output.frames=every_step",
            "output.fields=[displacement, stress, energy_error]",
            "output.points={middle: {at: [0, 20 mm]}}"]  # fmt: skip


def case(name: str, *overrides: str) -> Case:
    return shipped_case(name, [*COARSE, *overrides])


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[SolvedRun, RunFolder]:
    """Two steps of growth, in memory and in a folder."""
    folder = tmp_path_factory.mktemp("run")
    return crackgrow.run_case(shipped_case(NAME, SETTINGS), folder), open_run(folder)


@pytest.fixture(scope="module")
def run(both: tuple[SolvedRun, RunFolder]) -> SolvedRun:
    return both[0]


def test_examples_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(api)
    assert found.attempted >= 10
    assert found.failed == 0


def test_solution_is_the_first_step_of_a_run(run: SolvedRun) -> None:
    solution = crackgrow.solve(run.case)
    for name in ("tips", "contact", "reactions"):
        table = getattr(run, name)
        assert_frame_equal(getattr(solution, name), table[table["step"] == 0], check_exact=True)
    assert solution.paths["step"].max() == 0


def test_step_that_is_solved_again_is_the_same(run: SolvedRun) -> None:
    again = run.solution(1)
    table = run.tips
    assert_frame_equal(again.tips, table[table["step"] == 1].reset_index(drop=True), check_exact=True)
    assert run.solution(2) is run.last
    with pytest.raises(IndexError, match="steps 0 to 2"):
        run.solution(3)


def test_fields_at_points_are_those_of_the_frame(run: SolvedRun) -> None:
    frame, solution = run.last.frame, run.last
    corners = frame.points[frame.triangles]
    cells = np.concatenate([corners.mean(axis=1), frame.points[frame.quads].mean(axis=1)])
    size = np.abs(frame.stress).max()
    np.testing.assert_allclose(solution.stress_at(cells), frame.stress, rtol=0, atol=1e-6 * size)
    nested = solution.stress_at(cells[:6].reshape(2, 3, 2))
    np.testing.assert_array_equal(nested, solution.stress_at(cells[:6]).reshape(2, 3, 3))
    _, counts = np.unique(frame.points.round(9), axis=0, return_counts=True)
    assert (counts > 1).any()  # nodes are double along the crack, where a point has two displacements
    far = np.abs(frame.points).max(axis=1) > 0.0115
    found = solution.displacement_at(frame.points[far])
    np.testing.assert_allclose(found, frame.displacement[far], rtol=0, atol=1e-9 * np.abs(found).max())


def test_there_is_nothing_outside_and_no_stress_at_a_tip() -> None:
    solution = crackgrow.solve(case("compression30"))
    tip = solution.tips[["x", "y"]].to_numpy()[0]
    outside = [[0.1, 0.0], [1e300, 0.0], [np.nan, 0.0], [0.0, np.inf]]
    assert np.isnan(solution.stress_at([*outside, tip])).all()
    assert np.isnan(solution.displacement_at(outside)).all()
    assert np.isfinite(solution.displacement_at(tip)).all()
    assert np.isfinite(solution.stress_at(tip + np.array([1e-5, 0.0]))).all()
    assert solution.stress_at(np.empty((0, 2))).shape == (0, 3)
    for points in (1.0, [1.0, 2.0, 3.0], [[1.0], [2.0]]):
        with pytest.raises(ValueError, match="x and y in m"):
            solution.stress_at(points)


def test_what_notebooks_and_prompts_show(run: SolvedRun) -> None:
    """Texts of a notebook are escaped, and what a prompt shows is one line."""
    solution = crackgrow.solve(case("compression30", 'title="a < b"'))
    shown = solution._repr_html_()
    assert "a &lt; b" in shown
    assert "<td>flaw</td>" in shown
    (warning,) = [text for text in solution.warnings if "no error is measured" in text]
    assert warning.startswith("step 0: ")
    assert html.escape(warning) in shown
    assert "completed: all 2 growth steps are done" in run._repr_html_()
    assert repr(run) == "<Run of compression30: completed: all 2 growth steps are done>"
    assert repr(run.last) == "<Solution of compression30: step 2, load factor 1, 880 unknowns>"
    assert repr(run.case) == "<Case compression30: Closed crack at 30 degrees under uniaxial compression>"


def test_mistakes_at_a_prompt_are_told(run: SolvedRun) -> None:
    path = str(ROOT / "cases" / "compression30.yaml")
    for wrong in (crackgrow.solve, crackgrow.run_case):
        with pytest.raises(TypeError, match=r"a Case is wanted, as crackgrow.load_case\(path\) gives, not '.*yaml'"):
            wrong(path)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="overrides are a list"):
        crackgrow.load_case(path, "growth.steps=2")
    with pytest.raises(KeyError, match="no crack 'flw'; the cracks are flaw"):
        run.path("flw")


@pytest.mark.parametrize(("error", "status", "reason"), [
    (SolveError("too soft"), "failed", "too soft"), (KeyboardInterrupt(), "interrupted", "by Ctrl-C, after step 0")
])  # fmt: skip
def test_what_was_solved_before_an_error_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, status: str, reason: str
) -> None:
    def breaking(case: Case, solved_steps: Any = api.solved_steps) -> Iterator[Any]:
        yield next(solved_steps(case))
        raise error

    monkeypatch.setattr(api, "solved_steps", breaking)
    with pytest.raises(type(error)):
        crackgrow.run_case(case("compression30", "output.frames=none"), tmp_path)
    kept = crackgrow.open_run(tmp_path)
    assert (kept.status, kept.reason, len(kept.tips)) == (status, reason, 2)


def test_what_a_run_its_pictures_and_its_export_write_is_declared(both: tuple[SolvedRun, RunFolder]) -> None:
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
    for file in ("frames/step_NNNN.vtu", "cracks/step_NNNN.vtp"):
        mesh = pyvista.read(folder / file.replace("NNNN", "0000"))
        assert {*mesh.point_data.keys(), *mesh.cell_data.keys()} == set(FILES[file].header)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_of_a_folder_is_that_of_the_run(both: tuple[SolvedRun, RunFolder], name: str) -> None:
    """To the last digit, and with the same types; the times are those of the files alone."""
    memory, files = (getattr(run, name) for run in both)
    times = [column for column in memory.columns if column.startswith("seconds_")]
    pd.testing.assert_frame_equal(
        memory.drop(columns=times), files.drop(columns=times), check_exact=True, check_dtype=len(memory) > 0
    )


def test_status_paths_and_warnings_are_those_of_the_run(both: tuple[SolvedRun, RunFolder]) -> None:
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


def test_a_mesh_of_a_folder_is_that_of_the_step(both: tuple[SolvedRun, RunFolder]) -> None:
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
