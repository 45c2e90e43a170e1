"""The table: what rows tell of runs, held against finer ones, and the picture made of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import crackgrow
from crackgrow.study.errors import ERRORS, errors_of
from crackgrow.study.pictures import draw_sweep, responses_of
from crackgrow.study.plan import Run, Study
from crackgrow.study.runs import Table, Values, found_in
from crackgrow.study.sweep import plan_sweep
from tests.unit.study.test_sweep_runs import rows_of
from tests.unit.study.test_workers import FLAW

COARSE = "numerics.spacing: 4, growth.steps: 1"


def planned(folder: Path, parameters: str, more: str = "", settings: str = COARSE) -> Study:
    path = folder / "study.yaml"
    path.write_text(f"base: {FLAW}\nset: {{{settings}}}\nparameters: {{{parameters}}}\n{more}")
    return plan_sweep(path, folder / "out")


def solve(run: Run) -> Values:
    assert run.case is not None
    crackgrow.run_case(run.case, run.folder)
    return found_in(run)


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Table:
    """Two criteria, two angles, one of which is refused; one run is not done yet."""
    parameters = "growth.criterion: [strength, max_hoop_stress], cracks.flaw.path.angle: [30, 45]"
    plan = planned(tmp_path_factory.mktemp("table"), parameters)
    table = Table(plan, {})
    for run in plan.runs[:2]:
        table.ended(run, solve(run))
    table.ended(plan.runs[2], {"status": "refused", "reason": "no such thing"})
    table.write()
    return table


def test_rows_tell_what_their_files_tell(table: Table) -> None:
    run = table.study.runs[0]
    row = table.row(run)
    tips = rows_of(run.folder / "tips.csv")
    ends = [cells for cells in tips if cells["tip"] == "end"]
    assert [row[f"flaw.end.K_II_{step}"] for step in ("first", "last")] == [float(cells["K_II"]) for cells in ends]
    path = rows_of(run.folder / "paths.csv")
    assert (row["flaw.start.x"], row["flaw.end.y"]) == (float(path[0]["x"]), float(path[-1]["y"]))
    assert (row["status"], row["steps"], row["load_factor"]) == ("completed", 1, 1.0)
    assert row["n_dofs"] == int(rows_of(run.folder / "steps.csv")[-1]["n_dofs"])


@pytest.mark.physics
def test_runs_are_held_against_finer_ones_once_both_have_ended(tmp_path: Path) -> None:
    plan = planned(tmp_path, "numerics.spacing: [5, 4]", "reference: {numerics.spacing: 2}", "growth.steps: 1")
    table = Table(plan, {})
    coarse, fine, reference = plan.runs
    assert "K_error" not in table.ended(coarse, solve(coarse)).values
    assert "K_error" not in table.ended(reference, solve(reference)).values
    table.ended(fine, solve(fine))
    far, near = (table.row(run) for run in (coarse, fine))
    assert 0.0 < float(near["slip_error"] or 0.0) < float(far["slip_error"] or 0.0) < 0.1
    assert {name: far[name] for name in ERRORS} == errors_of(coarse.folder, reference.folder, grows=True)
    table.write()
    assert [row["K_error"] == "" for row in rows_of(plan.folder / "sweep.csv")] == [False, False, True]


def test_overview_takes_words_as_values_and_runs_that_are_missing(table: Table, tmp_path: Path) -> None:
    draw_sweep(tmp_path / "sweep.png", table)
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")
    chosen = ["flaw.end.K_I_first", "flaw.end.K_II_first", "flaw.end.x", "flaw.end.y"]
    assert responses_of(table, [table.row(run) for run in table.study.runs]) == chosen


def test_nothing_is_told_of_a_folder_that_is_damaged_of_another_version_or_of_another_case(tmp_path: Path) -> None:
    one, other = planned(tmp_path, "cracks.flaw.path.angle: [30, 45]").runs
    assert found_in(one) == {}
    assert solve(one)["status"] == "completed"
    one.folder.rename(other.folder)
    assert found_in(other) == {}
    other.folder.rename(one.folder)
    for text in ('{"status": "compl', "[]", '{"status": "completed"}'):
        (one.folder / "summary.json").write_text(text, encoding="utf-8")
        assert found_in(one) == {}
