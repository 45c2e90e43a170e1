"""Real, short sweeps: rows are those of single runs, and what breaks is told, and completed when it is gone on with."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import dask
import pytest
from distributed import Client, LocalCluster

import crackgrow
from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.study import workers
from crackgrow.study.plan import Study
from crackgrow.study.sweep import plan_sweep, sweep
from crackgrow.study.workers import ClusterError
from tests.unit.study.test_workers import ENVIRONMENT, FLAW, LONG, PATIENCE, process_of

pytestmark = pytest.mark.physics

SHORT = "growth.steps: 1"


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def written(folder: Path, friction: str = "[0, -1, 0.3]", settings: str = SHORT) -> Path:
    """A sweep over friction; a negative one is refused."""
    path = folder / "study.yaml"
    path.write_text(
        f"base: {FLAW}\nset: {{numerics.spacing: 4, {settings}}}\n"
        f"parameters: {{cracks.flaw.contact.friction: {friction}}}\n"
    )
    return path


LASTING = ", ".join(setting.replace("=", ": ") for setting in LONG if setting.startswith("growth"))


def tables(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text() for name in ("tips.csv", "paths.csv", "contact.csv", "case.yaml")}


def alone(plan: Study, number: int, folder: Path) -> dict[str, str]:
    """The tables of a run without any study."""
    run = plan.runs[number]
    crackgrow.run_case(load_case(run.file.path, run.file.overrides), folder)
    return tables(folder)


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler with two workers, as another program would offer it."""
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1, "distributed.admin.tick.limit": "1h"}),
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0") as cluster,
    ):
        yield cluster.scheduler_address


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

    when = (plan.runs[0].folder / "summary.json").stat().st_mtime_ns
    summary = plan.runs[2].folder / "summary.json"
    summary.write_text(summary.read_text().replace('"status": "completed"', '"status": "running"'))
    assert cli.main([*command, "--resume"]) == 0
    told, complaints = capfd.readouterr()
    assert complaints == ""
    assert "2 runs done, 1 of them done before, 1 not" in told
    assert "000 friction=0" not in told
    assert (plan.runs[0].folder / "summary.json").stat().st_mtime_ns == when
    spent = ("seconds", "cpu_seconds", "peak_memory_mb")
    before, again = ([{**row, **dict.fromkeys(spent)} for row in found] for found in (rows, rows_of(out / "sweep.csv")))
    assert again == before


def test_listed_commands_make_what_the_sweep_would(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    assert cli.main(["sweep", str(path), "--out", str(out), "--list"]) == 0
    commands, complaints = capsys.readouterr()
    assert "friction=-1: refused" in complaints
    assert not out.exists()
    for command in commands.splitlines():
        subprocess.run(command, shell=True, check=True, env=ENVIRONMENT, cwd=tmp_path)
    plan = plan_sweep(path, out)
    assert [row.new for row in sweep(plan, resume=True) if row.done] == [False, False]
    assert [row["status"] for row in rows_of(out / "sweep.csv")] == ["completed", "refused", "completed"]


NO_ADDRESS = "--scheduler: '{}' is no address of a scheduler; wanted: such as tcp://"


@pytest.mark.parametrize(("option", "values", "told"), [
    ("scheduler", ["tcp://127.0.0.1", "127.0.0.1", "tcp://", "tcp://host:", "tcp://host:port"], NO_ADDRESS),
    ("memory", ["1e400GB", "-1e400GB", "1e30GB", "nan", "100MB", "much", "4"], "--memory: '{}' is "),
    ("timeout", ["0", "-5", "nan", "inf"], "--timeout: "),
])  # fmt: skip
def test_options_that_no_machine_can_meet_are_refused_at_once(
    option: str, values: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    for value in values:
        assert cli.main(["sweep", str(path), f"--{option}={value}", "--out", str(out)]) == 2
        assert told.format(value) in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("scheduled", [True, False])
def test_killed_runs_are_told_and_gone_on_with(scheduled: bool, address: str, tmp_path: Path) -> None:
    """To the same digits as without a break."""
    plan = plan_sweep(written(tmp_path, "[0, 0.1]", LASTING), tmp_path / "out")
    where = {"scheduler": address} if scheduled else {"workers": 2}
    killer = threading.Thread(target=lambda: os.kill(process_of(plan.runs[0].folder), signal.SIGKILL))
    killer.start()
    rows = {row.run.number: row.values for row in sweep(plan, **where)}  # type: ignore[arg-type]
    killer.join()
    assert [rows[number]["status"] for number in range(2)] == ["failed", "completed"]
    assert str(rows[0]["reason"]).startswith("killed by SIGKILL")
    assert [row["status"] for row in rows_of(plan.folder / "sweep.csv")] == ["failed", "completed"]
    assert [row.new for row in sweep(plan, **where, resume=True)] == [False, True]  # type: ignore[arg-type]
    assert [row["status"] for row in rows_of(plan.folder / "sweep.csv")] == ["completed", "completed"]
    assert json.loads((plan.runs[0].folder / "summary.json").read_text())["resumed_with_steps"]
    assert tables(plan.runs[0].folder) == alone(plan, 0, tmp_path / "alone")


def test_a_run_that_is_out_of_memory_is_told(tmp_path: Path) -> None:
    """The linear algebra of many points takes more than the rest of them."""
    path = tmp_path / "study.yaml"
    path.write_text(f"base: {FLAW}\nset: {{growth.steps: 0}}\nparameters: {{numerics.spacing: [4, 0.1]}}\n")
    rows = {row.run.number: row.values for row in sweep(plan_sweep(path, tmp_path / "out"), memory="600MB")}
    assert [rows[number]["status"] for number in range(2)] == ["completed", "failed"]
    assert str(rows[1]["reason"]).startswith("out of memory")


def test_a_run_whose_worker_dies_goes_on_with_another_one(address: str, tmp_path: Path) -> None:
    plan = plan_sweep(written(tmp_path, "[0]", LASTING), tmp_path / "out")

    def kill() -> None:
        process_of(plan.runs[0].folder)
        busy = next(worker for worker, keys in client.processing().items() if keys)
        os.kill(client.run(os.getpid)[busy], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    with Client(address, set_as_default=False) as client:
        killer.start()
        rows = list(sweep(plan, scheduler=address))
        killer.join()
    assert [row.values["status"] for row in rows] == ["completed"]
    assert json.loads((plan.runs[0].folder / "summary.json").read_text())["resumed_with_steps"]


def test_earlier_results_are_kept_where_nothing_can_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_sweep(written(tmp_path, "[0, -1]"), tmp_path)
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
    plan = plan_sweep(written(tmp_path, "[0, 0.1, 0.2]"), tmp_path)
    own = plan.runs[1].folder / "paths.csv"
    own.parent.mkdir()
    own.write_text("digitised")
    alone(plan, 0, plan.runs[2].folder)
    found = {row.run.number: row.values for row in sweep(plan, resume=True)}
    assert [found[number]["status"] for number in range(3)] == ["completed", "failed", "completed"]
    assert "would be replaced" in str(found[1]["reason"])
    assert own.read_text() == "digitised"
    assert found[2]["flaw.end.K_II_first"] != found[0]["flaw.end.K_II_first"]


@pytest.mark.slow
def test_interrupted_sweep_leaves_a_whole_table_and_says_how_to_go_on(tmp_path: Path) -> None:
    path, out = written(tmp_path, "[0, 0.1, 0.2]", "growth.steps: 6"), tmp_path / "out"
    command = [sys.executable, "-m", "crackgrow", "sweep", str(path), "--out", str(out), "--workers", "1"]
    process = subprocess.Popen(
        command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("[1/3]"):
            break
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, complaints = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert complaints.splitlines() == [
        f"crackgrow: interrupted, what has ended is in {out}; go on with: {' '.join(command)} --resume"
    ]
    rows = rows_of(out / "sweep.csv")
    assert [row["status"] for row in rows] == ["completed", "waiting", "waiting"]
    done = subprocess.run([*command, "--resume"], env=ENVIRONMENT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert [row["status"] for row in rows_of(out / "sweep.csv")] == 3 * ["completed"]
