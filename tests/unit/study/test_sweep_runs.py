"""Real, short sweeps: rows are those of single runs, and what breaks is told, and completed when it is gone on with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import dask
import pytest
from distributed import Client, LocalCluster

import crackgrow
from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.results.lock import LOCK
from crackgrow.study import workers
from crackgrow.study.errors import ERRORS, errors_of
from crackgrow.study.pictures import draw_sweep, responses_of
from crackgrow.study.plan import Run, Study
from crackgrow.study.runs import Table, Values, found_in
from crackgrow.study.sweep import plan_sweep, sweep
from crackgrow.study.workers import ClusterError, Workers, run_process
from tests.properties.broken_off import CASES, ENVIRONMENT, ROOT
from tests.scenes import rows_of

FLAW = CASES / "compression30.yaml"
PATIENCE = 60.0  # s, for what happens at last
LONG = ("growth.steps=10", "growth.increment=0.05", "output.frames=none", "output.figures=false", "output.report=false")
COARSE = "numerics.spacing: 4, growth.steps: 1"
LASTING = "numerics.spacing: 4, growth.steps: 10, growth.increment: 0.05"
FRICTION = "cracks.flaw.contact.friction: [0, -1, 0.3]"  # a negative one is refused

pytestmark = pytest.mark.physics


def command(folder: Path, *settings: str) -> tuple[str, ...]:
    return ("run", str(FLAW), "--out", str(folder), "--quiet", *(w for s in settings for w in ("--set", s)))


def until(holds: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def process_of(folder: Path) -> int:
    """The process that runs into a folder, once it has got through a step."""
    until(lambda: (folder / "steps.csv").is_file() and len((folder / "steps.csv").read_text().splitlines()) > 1)
    return int(json.loads((folder / LOCK).read_text())["process"])


def is_there(process: int) -> bool:
    """Whether a process goes on; one that has ended may wait to be asked for its exit code."""
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True, check=False)
    return done.stdout.strip()[:1] not in ("", "Z")


def statuses(folder: Path) -> list[str]:
    return [row["status"] for row in rows_of(folder / "sweep.csv")]


def written(folder: Path, parameters: str = FRICTION, settings: str = COARSE, more: str = "") -> Path:
    path = folder / "study.yaml"
    path.write_text(f"base: {FLAW}\nset: {{{settings}}}\nparameters: {{{parameters}}}\n{more}")
    return path


def planned(folder: Path, *asked: str) -> Study:
    return plan_sweep(written(folder, *asked), folder / "out")


def solve(run: Run) -> Values:
    assert run.case is not None
    crackgrow.run_case(run.case, run.folder)
    return found_in(run)


def tables(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text() for name in ("tips.csv", "paths.csv", "contact.csv", "case.yaml")}


def alone(plan: Study, number: int, folder: Path) -> dict[str, str]:
    """The tables of a run without any study."""
    run = plan.runs[number]
    crackgrow.run_case(load_case(run.file.path, run.file.overrides), folder)
    return tables(folder)


# --- runs as processes -----------------------------------------------------------------------------------------------


def test_what_fails_a_run_is_told_in_its_own_words(tmp_path: Path) -> None:
    assert run_process(("--version",), None, None) == ""
    refused = run_process(command(tmp_path, "cracks.flaw.contact.friction=-1"), None, None)
    assert "friction: '-1' is out of range" in refused
    assert run_process(command(tmp_path), None, 0.01) == "not done after 0.01 s"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems bound no memory")
def test_memory_is_bounded(tmp_path: Path) -> None:
    """Where it does not do to load the program, this says so itself; the linear algebra of many points takes more."""
    assert "KiB of data are allowed" in run_process(command(tmp_path), 200_000_000, None)
    plan = planned(tmp_path, "numerics.spacing: [4, 0.1]", "growth.steps: 0")
    rows = {row.run.number: row.values for row in sweep(plan, memory="600MB")}
    assert [rows[number]["status"] for number in range(2)] == ["completed", "failed"]
    assert str(rows[1]["reason"]).startswith("out of memory")


def test_runs_end_when_their_study_is_left(tmp_path: Path) -> None:
    with Workers(1).there() as submit:
        future, waiting = submit(command(tmp_path, *LONG)), submit(("--version",))
        process = process_of(tmp_path)
    assert future.result() == "broken off"
    assert waiting.cancelled()
    assert not is_there(process)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere they go on to their own end")
def test_runs_end_with_a_study_that_has_no_time_to_end_them(tmp_path: Path) -> None:
    code = f"from crackgrow.study.workers import run_process; run_process({command(tmp_path, *LONG)}, None, None)"
    with subprocess.Popen([sys.executable, "-c", code], cwd=ROOT) as program:
        process = process_of(tmp_path)
        program.kill()
    until(lambda: not is_there(process))


# --- the table -------------------------------------------------------------------------------------------------------


def test_rows_tell_what_files_tell_and_the_overview_takes_words_and_runs_that_are_missing(tmp_path: Path) -> None:
    """Two criteria, two angles, one of which is refused; one run is not done yet."""
    plan = planned(tmp_path, "growth.criterion: [strength, max_hoop_stress], cracks.flaw.path.angle: [30, 45]")
    table, run = Table(plan, {}), plan.runs[0]
    for each in plan.runs[:2]:
        table.ended(each, solve(each))
    table.ended(plan.runs[2], {"status": "refused", "reason": "no such thing"})
    row, ends = table.row(run), [cells for cells in rows_of(run.folder / "tips.csv") if cells["tip"] == "end"]
    assert [row[f"flaw.end.K_II_{step}"] for step in ("first", "last")] == [float(cells["K_II"]) for cells in ends]
    path = rows_of(run.folder / "paths.csv")
    assert (row["flaw.start.x"], row["flaw.end.y"]) == (float(path[0]["x"]), float(path[-1]["y"]))
    assert (row["status"], row["steps"], row["load_factor"]) == ("completed", 1, 1.0)
    assert row["n_dofs"] == int(rows_of(run.folder / "steps.csv")[-1]["n_dofs"])
    draw_sweep(tmp_path / "sweep.png", table)
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")
    chosen = ["flaw.end.K_I_first", "flaw.end.K_II_first", "flaw.end.x", "flaw.end.y"]
    assert responses_of(table, [table.row(each) for each in plan.runs]) == chosen


def test_runs_are_held_against_finer_ones_once_both_have_ended(tmp_path: Path) -> None:
    plan = planned(tmp_path, "numerics.spacing: [5, 4]", "growth.steps: 1", "reference: {numerics.spacing: 2}")
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


# --- whole sweeps ----------------------------------------------------------------------------------------------------


def test_command_line_runs_what_is_missing_and_nothing_else(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    command = ["sweep", str(path), "--out", str(out), "--workers", "2", "--memory", "2GB"]
    assert cli.main(command) == 0
    told, complaints = capfd.readouterr()
    assert complaints == ""
    assert "[3/3]" in told
    assert "001 friction=-1: refused: cracks.flaw.contact.friction: '-1' is out of range" in told
    assert "2 runs done, 1 not" in told
    rows = rows_of(out / "sweep.csv")
    assert [row["status"] for row in rows] == ["completed", "refused", "completed"]
    assert float(rows[0]["cpu_seconds"]) > 0.0
    assert (out / "sweep.png").exists()
    assert not (out / "friction=0" / "frames").exists()
    plan = plan_sweep(path, out)
    assert tables(plan.runs[2].folder) == alone(plan, 2, tmp_path / "alone")

    first, third = (plan.runs[number].folder / "summary.json" for number in (0, 2))
    when = first.stat().st_mtime_ns
    third.write_text(third.read_text().replace('"status": "completed"', '"status": "running"'))
    assert cli.main([*command, "--resume"]) == 0
    told, complaints = capfd.readouterr()
    assert complaints == ""
    assert "2 runs done, 1 of them done before, 1 not" in told
    assert "000 friction=0" not in told
    assert first.stat().st_mtime_ns == when
    spent = dict.fromkeys(("seconds", "cpu_seconds", "peak_memory_mb"))
    assert [{**row, **spent} for row in rows_of(out / "sweep.csv")] == [{**row, **spent} for row in rows]


def test_listed_commands_make_what_the_sweep_would(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    assert cli.main(["sweep", str(path), "--out", str(out), "--list"]) == 0
    commands, complaints = capsys.readouterr()
    assert "friction=-1: refused" in complaints
    assert not out.exists()
    for command in commands.splitlines():
        subprocess.run(command, shell=True, check=True, env=ENVIRONMENT, cwd=tmp_path)
    assert [row.new for row in sweep(plan_sweep(path, out), resume=True) if row.done] == [False, False]
    assert statuses(out) == ["completed", "refused", "completed"]


def test_killed_runs_are_told_and_gone_on_with(tmp_path: Path) -> None:
    """To the same digits as without a break."""
    plan = planned(tmp_path, "cracks.flaw.contact.friction: [0]", LASTING)
    killer = threading.Thread(target=lambda: os.kill(process_of(plan.runs[0].folder), signal.SIGKILL))
    killer.start()
    (row,) = sweep(plan, workers=1)
    killer.join()
    assert str(row.values["reason"]).startswith("killed by SIGKILL")
    assert statuses(plan.folder) == ["failed"]
    assert [row.new for row in sweep(plan, workers=1, resume=True)] == [True]
    assert statuses(plan.folder) == ["completed"]
    assert json.loads((plan.runs[0].folder / "summary.json").read_text())["resumed_with_steps"]
    assert tables(plan.runs[0].folder) == alone(plan, 0, tmp_path / "alone")


def test_a_run_whose_worker_dies_goes_on_with_another_one(tmp_path: Path) -> None:
    """Of a scheduler with two workers, as another program would offer it."""
    plan = planned(tmp_path, "cracks.flaw.contact.friction: [0]", LASTING)

    def kill() -> None:
        process_of(plan.runs[0].folder)
        busy = next(worker for worker, keys in client.processing().items() if keys)
        os.kill(client.run(os.getpid)[busy], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1, "distributed.admin.tick.limit": "1h"}),
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0") as cluster,
        Client(cluster.scheduler_address, set_as_default=False) as client,
    ):
        killer.start()
        rows = list(sweep(plan, scheduler=cluster.scheduler_address))
        killer.join()
    assert [row.values["status"] for row in rows] == ["completed"]
    assert json.loads((plan.runs[0].folder / "summary.json").read_text())["resumed_with_steps"]


def test_earlier_results_are_kept_where_nothing_can_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_sweep(written(tmp_path, "cracks.flaw.contact.friction: [0, -1]"), tmp_path)
    for path in (tmp_path / "sweep.csv", plan.runs[0].folder / "summary.json"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("earlier")
    monkeypatch.setattr(workers, "CONNECT", "0.2s")
    with pytest.raises(ClusterError, match=r"no Dask scheduler at tcp://127\.0\.0\.1:9"):
        list(sweep(plan, scheduler="tcp://127.0.0.1:9"))
    monkeypatch.setattr(workers, "find_spec", lambda name: None)
    with pytest.raises(ClusterError, match=r"needs Dask, .* pip install 'crackgrow\[sweep\]'"):
        list(sweep(plan, scheduler="tcp://127.0.0.1:9"))
    assert (tmp_path / "sweep.csv").read_text() == (plan.runs[0].folder / "summary.json").read_text() == "earlier"


def test_folders_with_files_of_somebody_else_or_of_another_case(tmp_path: Path) -> None:
    """The first fails its own run alone, the second is replaced, also by a study that goes on."""
    plan = plan_sweep(written(tmp_path, "cracks.flaw.contact.friction: [0, 0.1, 0.2]"), tmp_path)
    own = plan.runs[1].folder / "paths.csv"
    own.parent.mkdir()
    own.write_text("digitised")
    alone(plan, 0, plan.runs[2].folder)
    found = {row.run.number: row.values for row in sweep(plan, resume=True)}
    assert [found[number]["status"] for number in range(3)] == ["completed", "failed", "completed"]
    assert "would be replaced" in str(found[1]["reason"])
    assert own.read_text() == "digitised"
    assert found[2]["flaw.end.K_II_first"] != found[0]["flaw.end.K_II_first"]
