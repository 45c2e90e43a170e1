"""What is declared of a run's folder is what a run writes."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest
import pyvista

from crackgrow import cli
from crackgrow.results.declarations import CRACKS, FRAMES, RUN, SUMMARY

CASES = Path(__file__).parents[3] / "cases"
NAME = "compression30"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of one growth step with its pictures and an export."""
    out = tmp_path_factory.mktemp("run") / NAME
    settings = ["numerics.spacing=4", "growth.steps=1", "output.fields=[displacement, stress, energy_error]"]
    words = [word for setting in settings for word in ("--set", setting)]
    assert cli.main(["run", str(CASES / f"{NAME}.yaml"), *words, "--out", str(out), "--quiet"]) == 0
    assert cli.main(["render", str(out), "--size", "200x200"]) == 0
    assert cli.main(["export", str(out), "--to", "msh"]) == 0
    return out


def declared(name: str) -> re.Pattern[str]:
    """What a declared name of a file stands for."""
    pattern = re.escape(name).replace("NNNN", r"\d{4,}").replace("FIELD", r"\w+").replace("NAME", NAME)
    return re.compile(pattern)


def test_every_file_that_a_run_writes_is_declared(folder: Path) -> None:
    written = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    unknown = {name for name in written if not any(declared(file.name).fullmatch(name) for file in RUN)}
    assert unknown == set()
    missing = {file.name for file in RUN if not any(declared(file.name).fullmatch(name) for name in written)}
    assert missing == {"figures/load_curve.png", "history.csv"}  # its load factor does not vary, it names no points


def test_tables_have_the_columns_that_are_declared(folder: Path) -> None:
    tables = sorted(path.name for path in folder.glob("*.csv"))
    known = {file.name: file.header for file in RUN}
    assert tables == sorted(name for name in known if name.endswith(".csv") and name != "history.csv")
    for name in tables:
        with (folder / name).open(newline="") as file:
            assert tuple(next(csv.reader(file))) == known[name]


def test_the_summary_has_the_keys_that_are_declared(folder: Path) -> None:
    of_some_runs = {"safety", "time"}  # of reduced strength, of subcritical growth
    wanted = tuple(key for key in SUMMARY.header if key not in of_some_runs)
    assert tuple(json.loads((folder / SUMMARY.name).read_text())) == wanted


def test_frames_have_the_fields_that_are_declared(folder: Path) -> None:
    frame = pyvista.read(folder / "frames/step_0000.vtu")
    assert {*frame.point_data.keys(), *frame.cell_data.keys()} == set(FRAMES.header)
    cracks = pyvista.read(folder / "cracks/step_0000.vtp")
    assert {*cracks.point_data.keys(), *cracks.cell_data.keys()} == set(CRACKS.header)
    assert "crack_names" in cracks.field_data
