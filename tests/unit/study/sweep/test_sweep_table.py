"""The table: one row for each run whatever became of it, the same in both files, and the picture made of it."""

from __future__ import annotations

import csv
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from pyarrow import parquet
from threadpoolctl import threadpool_info

from crackgrow import blas
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.study.sweep import job
from crackgrow.study.sweep.columns import measured
from crackgrow.study.sweep.job import Job, run_job, solve
from crackgrow.study.sweep.picture import draw, responses_of, shown_as
from crackgrow.study.sweep.plan import SweepPlan, plan_sweep
from crackgrow.study.sweep.runner import done
from crackgrow.study.sweep.table import SweepTable
from crackgrow.study.timed_run import write_run

FLAW = Path(__file__).parents[4] / "cases" / "compression30.yaml"


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def planned(folder: Path, parameters: str, more: str = "") -> SweepPlan:
    path = folder / "study.yaml"
    path.write_text(
        f"base: {FLAW}\nset: {{numerics.spacing: 4, growth.steps: 1}}\nparameters: {{{parameters}}}\n{more}"
    )
    return plan_sweep(path, folder / "out")


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> SweepTable:
    """Two criteria, two angles, one of which is refused; one run is not done yet."""
    parameters = "growth.criterion: [strength, max_hoop_stress], cracks.flaw.path.angle: [30, 45]"
    plan = planned(tmp_path_factory.mktemp("table"), parameters)
    found = {run.number: solve(run.case, run.folder) for run in plan.runs[:2] if run.case}
    found[2] = {"status": "refused", "reason": "no such thing"}
    table = SweepTable(plan, found)
    table.write()
    return table


def test_rows_tell_what_their_files_tell(table: SweepTable):
    run = table.plan.runs[0]
    row = table.row(run)
    tips = rows_of(run.folder / "tips.csv")
    ends = [cells for cells in tips if cells["tip"] == "end"]
    assert [row[f"flaw.end.K_II_{step}"] for step in ("first", "last")] == [float(cells["K_II"]) for cells in ends]
    path = rows_of(run.folder / "paths.csv")
    assert (row["flaw.start.x"], row["flaw.end.y"]) == (float(path[0]["x"]), float(path[-1]["y"]))
    assert (row["status"], row["steps"], row["load_factor"]) == ("completed", 1, 1.0)
    assert row["n_dofs"] == int(rows_of(run.folder / "steps.csv")[-1]["n_dofs"])


def test_both_files_hold_every_run(table: SweepTable):
    rows = rows_of(table.plan.folder / "sweep.csv")
    columns = parquet.read_table(table.plan.folder / "sweep.parquet")
    assert [row["status"] for row in rows] == ["completed", "completed", "refused", "waiting"]
    assert columns.column_names == list(rows[0])
    assert columns["angle"].to_pylist() == [30.0, 45.0, 30.0, 45.0]
    assert columns["criterion"].to_pylist()[::2] == ["strength", "max_hoop_stress"]
    assert columns["steps"].to_pylist() == [1, 1, None, None]
    for name in ("flaw.end.K_II_first", "energy_error_percent", "seconds"):
        assert columns[name].to_pylist() == [float(row[name]) if row[name] else None for row in rows]


def test_parameter_with_the_name_of_a_column_keeps_its_values(tmp_path: Path):
    path = tmp_path / "study.yaml"
    path.write_text(f"base: {FLAW}\nparameters: {{growth.steps: [4, 3]}}\n")
    plan = plan_sweep(path, tmp_path)
    SweepTable(plan, {1: {"status": "arrested", "reason": "", "steps": 2}}).write()
    columns = parquet.read_table(plan.folder / "sweep.parquet")
    assert columns["growth.steps"].to_pylist() == [4.0, 3.0]
    assert columns["steps"].to_pylist() == [None, 2]


def test_overview_takes_words_as_values_and_runs_that_are_missing(table: SweepTable, tmp_path: Path):
    draw(tmp_path / "sweep.png", table)
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")
    chosen = ["flaw.end.K_I_first", "flaw.end.K_II_first", "flaw.end.x", "flaw.end.y"]
    assert responses_of(table, table.rows()) == chosen


def test_overview_has_units():
    for name, shown in (
        ("flaw.end.K_I_last", (1e-6, "MPa sqrt(m)")),
        ("flaw.start.y", (1e3, "mm")),
        ("n_dofs", (1.0, "")),
        ("seconds", (1.0, "s")),
    ):
        assert shown_as(name, (1e3, "mm")) == shown


@pytest.mark.parametrize("more", ["", "responses: [n_dofs]"])
def test_overview_of_one_parameter_and_of_no_run_that_is_done(tmp_path: Path, more: str):
    plan = planned(tmp_path, "cracks.flaw.path.angle: [30]", more)
    table = SweepTable(plan, {})
    draw(tmp_path / "sweep.png", table)
    assert not (tmp_path / "sweep.png").exists()
    run = plan.runs[0]
    assert run.case is not None
    table.found[0] = solve(run.case, run.folder)
    draw(tmp_path / "sweep.png", table)
    assert (tmp_path / "sweep.png").exists()


def test_run_that_raises_is_a_row_with_its_reason_and_what_it_solved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def breaks(case, checkpoint):
        yield next(grow(case, checkpoint))
        raise MemoryError("no room")

    run = planned(tmp_path, "cracks.flaw.path.angle: [30]").runs[0]
    assert run.case is not None
    monkeypatch.setattr(job, "grow", breaks)
    values = solve(run.case, run.folder)
    assert (values["status"], values["steps"]) == ("failed", 0)
    assert str(values["reason"]).startswith("out of memory: no room; a larger numerics.spacing takes less")
    assert values == measured(run.folder)
    monkeypatch.undo()
    assert solve(run.case, run.folder)["status"] == "completed"


def test_folder_of_another_case_is_replaced(tmp_path: Path):
    one, other = planned(tmp_path, "cracks.flaw.path.angle: [30, 45]").runs
    assert one.case is not None
    assert other.case is not None
    writer = RunWriter(other.case, one.folder)
    writer.begin()
    write_run(writer, grow(other.case))
    before = measured(one.folder)
    assert before["flaw.end.K_II_first"] != solve(one.case, one.folder)["flaw.end.K_II_first"]


def test_nothing_is_told_of_a_run_that_has_not_begun(tmp_path: Path):
    assert measured(tmp_path) == {}


def test_folder_with_files_of_something_else_is_a_run_that_failed(tmp_path: Path):
    run = planned(tmp_path, "cracks.flaw.path.angle: [30]").runs[0]
    assert run.case is not None
    run.folder.mkdir(parents=True)
    (run.folder / "summary.json").write_text('{"of": "another program"}', encoding="utf-8")
    values = solve(run.case, run.folder)
    assert values["status"] == "failed"
    assert "summary.json would be replaced" in str(values["reason"])
    assert (run.folder / "summary.json").read_text(encoding="utf-8") == '{"of": "another program"}'


def test_run_whose_summary_is_damaged_or_of_another_version_is_not_done(tmp_path: Path):
    run = planned(tmp_path, "cracks.flaw.path.angle: [30]").runs[0]
    assert run.case is not None
    solve(run.case, run.folder)
    assert done(run)
    for text in ('{"status": "compl', "[]", '{"status": "completed"}'):
        (run.folder / "summary.json").write_text(text, encoding="utf-8")
        assert not done(run)


def test_runs_of_a_process_have_one_thread_and_come_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """As on workers that somebody has started with several threads."""
    monkeypatch.setattr(blas, "_settled", False)
    running: list[int] = []

    def solve(case: int, folder: Path) -> dict[str, int]:
        running.append(case)
        time.sleep(0.05)
        beside = len(running) - 1
        running.remove(case)
        pools = [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]
        return {"beside": beside, "threads": max(pools)}

    monkeypatch.setattr(job, "solve", solve)
    jobs = [Job(number, tmp_path, number, None) for number in range(3)]
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(run_job, jobs))
    assert found == 3 * [{"beside": 0, "threads": 1}]
