"""The door to a run's folder: the same tables, paths and meshes that the run had in memory."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import crackgrow
from crackgrow.results.folder import FolderError, RunFolder, open_run
from tests.scenes import shipped_case

TABLES = ("steps", "tips", "contact", "reactions", "events", "paths", "history")
SETTINGS = ["numerics.spacing=3", "growth.steps=2", "output.frames=every_step", "output.figures=false",
            "output.fields=[displacement, stress, energy_error]",
            "output.points={middle: {at: [0, 20 mm]}}"]  # fmt: skip


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[crackgrow.Run, RunFolder]:
    folder = tmp_path_factory.mktemp("door")
    case = shipped_case("compression30", SETTINGS)
    return crackgrow.run_case(case, folder), open_run(folder)


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
    spent = {"wall_seconds", "cpu_seconds", "peak_memory_mb"}
    assert files.summary["n_solves"] == 3
    assert {key: value for key, value in files.summary.items() if key not in spent} == {
        key: value for key, value in memory.summary.items() if key not in spent
    }
    assert (files.case.name, files.case.to_dict()) == (memory.case.name, memory.case.to_dict())
    np.testing.assert_array_equal(files.path("flaw"), memory.path("flaw"))
    with pytest.raises(KeyError, match="no crack 'flow'; the cracks are flaw"):
        files.path("flow")


def test_a_mesh_of_a_folder_is_that_of_the_step(both: tuple[crackgrow.Run, RunFolder]) -> None:
    memory, files = both
    frame, mesh = memory.solution(1).frame, files.mesh(1)
    np.testing.assert_array_equal(mesh.points[:, :2], frame.points)
    np.testing.assert_array_equal(mesh.point_data["displacement"][:, :2], frame.displacement)
    np.testing.assert_array_equal(mesh.cell_data["stress"][:, [0, 1, 3]], frame.stress)
    for name in ("point_data", "cell_data"):
        ours, theirs = (getattr(one, name) for one in (memory.mesh(1), mesh))
        assert list(ours) == list(theirs)
        for field in ours:
            np.testing.assert_array_equal(ours[field], theirs[field])
    assert list(files.frames) == files.solved == [0, 1, 2]
    np.testing.assert_array_equal(files.mesh().points, files.mesh(2).points)
    with pytest.raises(FolderError, match=r"has no frame of step 7; it has those of 0 to 2"):
        files.mesh(7)


def test_what_is_no_run_is_refused_with_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(FolderError, match=r"is not a folder of results: summary\.json cannot be read"):
        open_run(tmp_path)
    assert RunFolder(tmp_path).found_summary == {}
    (tmp_path / "summary.json").write_text("[" * 100_000)
    assert RunFolder(tmp_path).found_summary == {}


def test_a_run_that_goes_on_is_read_as_far_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(json.dumps({"status": "running", "stop_reason": "the run goes on"}))
    run = open_run(tmp_path)
    assert (run.status, run.finished) == ("running", False)
    with pytest.raises(FolderError, match=re.escape("it has no case, title, n_solves")):
        assert run.summary
