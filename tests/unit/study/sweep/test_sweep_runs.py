"""Real, short sweeps on workers of this machine: rows are those of single runs, and what breaks is repeated or told."""

from __future__ import annotations

import csv
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import dask
import pytest
from distributed import Client, LocalCluster

from crackgrow import cli
from crackgrow.blas import THREAD_SETTINGS
from crackgrow.errors import CaseError
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.study.sweep import place
from crackgrow.study.sweep.columns import Values
from crackgrow.study.sweep.job import Job, bounded_memory, run_job
from crackgrow.study.sweep.place import ClusterError, MissingPackageError
from crackgrow.study.sweep.plan import SweepPlan, plan_sweep
from crackgrow.study.sweep.runner import SweepRow, sweep
from crackgrow.study.timed_run import write_run

ROOT = Path(__file__).parents[4]
FLAW = ROOT / "cases" / "compression30.yaml"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
SHIPPED = "cases/sweeps/angle_friction.yaml"
PATIENCE = 60.0  # s, for what happens at last


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def written(folder: Path, friction: str = "[0, -1, 0.3]", steps: int = 1) -> Path:
    """A sweep over friction; a negative one is refused."""
    path = folder / "study.yaml"
    path.write_text(
        f"base: {FLAW}\nset: {{numerics.spacing: 4, growth.steps: {steps}}}\n"
        f"parameters: {{cracks.flaw.contact.friction: {friction}}}\n"
    )
    return path


def until(holds) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def alone(plan: SweepPlan, number: int, folder: Path) -> dict[str, str]:
    """The tables of a run without any workers."""
    case = plan.runs[number].case
    assert case is not None
    writer = RunWriter(case, folder)
    writer.begin()
    write_run(writer, grow(case))
    return tables(folder)


def tables(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text() for name in ("tips.csv", "paths.csv", "contact.csv", "case.yaml")}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler with two workers, as another program would offer it."""
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1, "distributed.admin.tick.limit": "1h"}),
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0") as cluster,
    ):
        yield cluster.scheduler_address


def test_command_line_runs_what_is_missing_and_nothing_else(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    path, out = written(tmp_path), tmp_path / "out"
    monkeypatch.setattr(sys, "argv", ["crackgrow"])
    command = ["sweep", str(path), "--out", str(out), "--workers", "2", "--memory", "2GB"]
    assert cli.main(command) == 0
    told, complaints = capfd.readouterr()
    assert complaints == ""
    assert "[3/3]" in told
    assert "001 friction=-1: refused: cracks.flaw.contact.friction: '-1' is out of range" in told
    assert "2 runs done, 1 not" in told
    rows = rows_of(out / "sweep.csv")
    assert [row["status"] for row in rows] == ["completed", "refused", "completed"]
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
    again = rows_of(out / "sweep.csv")
    assert [{**row, "seconds": "", "peak_memory_mb": ""} for row in again] == [
        {**row, "seconds": "", "peak_memory_mb": ""} for row in rows
    ]


@pytest.mark.parametrize(("status", "code"), [("failed", 3), ("arrested", 0)])
def test_exit_code_tells_whether_any_run_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, status: str, code: int
):
    def ended(plan: SweepPlan, **_: object) -> Iterator[SweepRow]:
        values: Values = {"status": status, "reason": "so", "steps": 1, "seconds": 1.0, "peak_memory_mb": 1.0}
        yield SweepRow(plan.runs[0], values, True)

    monkeypatch.setattr("crackgrow.sweep", ended)
    assert cli.main(["sweep", str(written(tmp_path, "[0]")), "--out", str(tmp_path)]) == code


@pytest.mark.parametrize("scheduler", ["tcp://127.0.0.1", "127.0.0.1", "tcp://", "tcp://host:", "tcp://host:port"])
def test_a_scheduler_s_address_without_a_port_is_refused_at_once(scheduler: str, tmp_path: Path, capsys):
    out = tmp_path / "out"
    assert cli.main(["sweep", str(written(tmp_path)), "--scheduler", scheduler, "--out", str(out)]) == 2
    assert f"--scheduler: '{scheduler}' is no address of a scheduler; wanted: such as tcp://" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("memory", ["1e400GB", "-1e400GB", "1e30GB", "nan", "100MB", "much"])
def test_a_memory_that_no_machine_has_is_refused(memory: str, tmp_path: Path, capsys):
    out = tmp_path / "out"
    assert cli.main(["sweep", str(written(tmp_path)), f"--memory={memory}", "--out", str(out)]) == 2
    assert f"--memory: '{memory}' is " in capsys.readouterr().err
    assert not out.exists()


def test_scenes_without_cracks_are_swept_too(tmp_path: Path):
    """And a value that has no letter in it has a name of a folder."""
    path = tmp_path / "study.yaml"
    flaw = "{flaw: {path: {center: [0, 0], length: 10, angle: 30}, tips: both, contact: {friction: 0, cohesion: 0}}}"
    scene = f"base: {FLAW}\nset: {{numerics.spacing: 4, growth.steps: 0}}\n"
    path.write_text(f"{scene}parameters: {{cracks: [{{}}, {flaw}]}}\n")
    rows = sorted(sweep(plan_sweep(path, tmp_path / "out"), workers=1), key=lambda row: row.run.number)
    assert [row.values["status"] for row in rows] == ["completed"] * 2
    without, with_flaw = (str(row.values["reason"]) for row in rows)
    assert without == "the static solve is done"
    assert with_flaw.startswith(f"{without}; the most critical is at ")
    assert rows[0].run.folder.name == "cracks=none"
    assert (tmp_path / "out" / "sweep.png").is_file()
    path.write_text(f"{scene}parameters: {{cracks: [{{}}]}}\n")
    assert [row.done for row in sweep(plan_sweep(path, tmp_path / "none"), workers=1)] == [True]
    assert (tmp_path / "none" / "sweep.png").is_file()


def test_workers_are_not_asked_for_beside_a_scheduler(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["sweep", str(written(tmp_path)), "--workers", "2", "--scheduler", "tcp://127.0.0.1:9"])
    assert stopped.value.code == 2
    assert "--scheduler: not allowed with argument --workers" in capsys.readouterr().err


def look(job: Job) -> Values:
    """What a worker has for its run."""
    with bounded_memory(job.memory):
        limit = resource.getrlimit(resource.RLIMIT_DATA)[0]
    threads = ",".join(os.environ.get(name, "none") for name in (*THREAD_SETTINGS, "MALLOC_TRIM_THRESHOLD_"))
    return {"status": "looked", "reason": threads, "n_dofs": limit, "steps": os.getpid()}


def test_workers_have_one_thread_for_linear_algebra_and_bounded_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
    plan = plan_sweep(written(tmp_path, "[0, 0.1]"), tmp_path)
    free = list(sweep(plan, workers=1, function=look))
    assert len({row.values["steps"] for row in free}) == 1  # one process for both runs, that is not this one
    assert free[0].values["steps"] != os.getpid()
    assert free[0].values["n_dofs"] == resource.getrlimit(resource.RLIMIT_DATA)[0]
    rows = list(sweep(plan, workers=1, memory="1GB", function=look))
    assert rows[0].values["reason"] == "1,1,1,none"  # memory is kept from array to array, as in a run alone
    assert rows[0].values["n_dofs"] == 8e8


def test_memory_that_the_system_does_not_bound_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(CaseError, match="--memory: only Linux bounds the memory of a process"):
        next(sweep(plan_sweep(written(tmp_path), tmp_path), memory="1GB"))


def test_run_of_a_killed_worker_is_gone_on_with(address: str, tmp_path: Path):
    plan = plan_sweep(written(tmp_path, "[0]", steps=8), tmp_path / "out")
    steps = plan.runs[0].folder / "steps.csv"

    def kill() -> None:
        until(lambda: steps.is_file() and len(steps.read_text().splitlines()) > 3)
        busy = next(worker for worker, keys in client.processing().items() if keys)
        os.kill(client.run(os.getpid)[busy], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    with Client(address, set_as_default=False) as client:
        killer.start()
        rows = list(sweep(plan, scheduler=address))
        killer.join()
    assert [row.values["status"] for row in rows] == ["completed"]
    assert json.loads((plan.runs[0].folder / "summary.json").read_text())["resumed_with_steps"]
    assert tables(plan.runs[0].folder) == alone(plan, 0, tmp_path / "alone")


def dies_once(job: Job) -> Values:
    first = job.folder.parent / "died"
    if not first.exists():
        first.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return run_job(job)


def test_run_whose_only_worker_dies_goes_on_with_the_next_one(tmp_path: Path):
    plan = plan_sweep(written(tmp_path, "[0, 0.1]"), tmp_path)
    found = {row.run.number: row.values["status"] for row in sweep(plan, workers=1, function=dies_once)}
    assert found == {0: "completed", 1: "completed"}


def deadly(job: Job) -> Values:
    if job.number == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    if job.number == 1:
        raise ValueError("a bug")
    return run_job(job)


@pytest.mark.parametrize("scheduled", [True, False])
def test_run_that_kills_its_workers_is_told_and_the_others_are_run(scheduled: bool, address: str, tmp_path: Path):
    plan = plan_sweep(written(tmp_path, "[0, 0.1, -1, 0.2]"), tmp_path)
    workers = {"scheduler": address} if scheduled else {"workers": 2}
    found = {row.run.number: row.values for row in sweep(plan, **workers, function=deadly)}  # type: ignore[arg-type]
    assert found[1]["reason"] == "internal error: ValueError: a bug"
    assert [found[number]["status"] for number in range(4)] == ["failed", "failed", "refused", "completed"]
    lost = 2 if scheduled else 3
    assert str(found[0]["reason"]).startswith(f"worker lost: {lost} workers died of this run")
    table = rows_of(tmp_path / "sweep.csv")
    assert [row["status"] for row in table] == ["failed", "failed", "refused", "completed"]


def test_sweep_that_is_left_ends_its_workers_at_once(tmp_path: Path):
    rows = sweep(plan_sweep(written(tmp_path, "[0, 0.1]"), tmp_path), workers=2, function=sleeps_but_once)
    next(rows)
    began = time.monotonic()
    rows.close()  # type: ignore[attr-defined]
    assert time.monotonic() - began < PATIENCE / 2


def sleeps_but_once(job: Job) -> Values:
    if job.number:
        time.sleep(2 * PATIENCE)
    return {"status": "looked"}


def test_recipe_for_slurm_needs_no_more_of_its_cluster_than_an_address(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """The script of the README, with the workers of this machine in place of SLURM's."""

    class Cluster:
        scheduler_address = address

        def __init__(self, **settings: object) -> None:
            assert settings["cores"] == settings["processes"] == 1

        def __enter__(self) -> Cluster:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def scale(self, jobs: int) -> None:
            assert jobs > 0

    scripts = (ROOT / "cases/sweeps/README.md").read_text(encoding="utf-8").split("```text\n")[1:]
    script = next(text for text in scripts if "SLURMCluster" in text).split("```")[0]
    monkeypatch.setitem(sys.modules, "dask_jobqueue", SimpleNamespace(SLURMCluster=Cluster))
    monkeypatch.chdir(tmp_path)
    assert script.count(SHIPPED) == 1
    exec(script.replace(SHIPPED, str(written(tmp_path, "[0.3]"))), {"__name__": "__main__"})
    assert capsys.readouterr().out == "friction=0.3 completed\n"
    assert (tmp_path / "outputs" / "study" / "sweep.csv").exists()


def test_wrong_addresses_sizes_and_missing_packages_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plan = plan_sweep(written(tmp_path), tmp_path)
    monkeypatch.setattr("crackgrow.study.sweep.cluster.CONNECT", "0.2s")
    with pytest.raises(ClusterError, match=r"no Dask scheduler at tcp://127\.0\.0\.1:9"):
        list(sweep(plan, scheduler="tcp://127.0.0.1:9"))
    with pytest.raises(CaseError, match="--memory: 'much' is no size of a memory"):
        list(sweep(plan, memory="much"))
    with pytest.raises(
        CaseError, match="--memory: '4' is 4 bytes; a worker takes 200 MB at least; wanted: such as 2GB"
    ):
        list(sweep(plan, memory="4"))
    monkeypatch.setattr(place, "find_spec", lambda name: None if name == "pyarrow" else object())
    with pytest.raises(MissingPackageError, match=r"sweeps need pyarrow, .* pip install 'crackgrow\[sweep\]'"):
        list(sweep(plan))


def test_earlier_results_are_kept_where_nothing_can_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plan = plan_sweep(written(tmp_path, "[0, -1]"), tmp_path)
    for path in (tmp_path / "sweep.csv", plan.runs[0].folder / "summary.json"):
        path.parent.mkdir(exist_ok=True)
        path.write_text("earlier")
    monkeypatch.setattr("crackgrow.study.sweep.cluster.CONNECT", "0.2s")
    with pytest.raises(ClusterError):
        list(sweep(plan, scheduler="tcp://127.0.0.1:9"))
    assert (tmp_path / "sweep.csv").read_text() == (plan.runs[0].folder / "summary.json").read_text() == "earlier"


def test_folder_with_files_of_somebody_else_fails_its_own_run_alone(address: str, tmp_path: Path):
    plan = plan_sweep(written(tmp_path, "[0, 0.1]"), tmp_path)
    own = plan.runs[1].folder / "paths.csv"
    own.parent.mkdir()
    own.write_text("digitised")
    found = {row.run.number: row.values for row in sweep(plan, scheduler=address)}
    assert [found[number]["status"] for number in range(2)] == ["completed", "failed"]
    assert "would be replaced" in str(found[1]["reason"])
    assert own.read_text() == "digitised"


@pytest.mark.slow
def test_cluster_started_by_hand_is_used(tmp_path: Path):
    place = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    scheduler = [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", place]
    worker = [*dask, "worker", "--scheduler-file", place, "--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1"]
    with (tmp_path / "log").open("w") as log:
        started = [
            subprocess.Popen(list(map(str, command)), env=ENVIRONMENT, cwd=tmp_path, stdout=log, stderr=log)
            for command in (scheduler, worker, worker)
        ]
        try:
            until(lambda: place.is_file() and place.read_text().endswith("}"))
            address = json.loads(place.read_text())["address"]
            plan = plan_sweep(written(tmp_path), tmp_path / "out")
            rows = list(sweep(plan, scheduler=address))
        finally:
            for process in reversed(started):
                process.terminate()
            for process in started:
                process.wait(PATIENCE)
    assert sorted(str(row.values["status"]) for row in rows) == ["completed", "completed", "refused"]
    assert tables(plan.runs[0].folder) == alone(plan, 0, tmp_path / "alone")


@pytest.mark.slow
def test_interrupted_sweep_leaves_a_whole_table_and_says_how_to_go_on(tmp_path: Path):
    path, out = written(tmp_path, "[0, 0.1, 0.2]", steps=6), tmp_path / "out"
    command = [sys.executable, "-m", "crackgrow", "sweep", str(path), "--out", str(out), "--workers", "1"]
    process = subprocess.Popen(
        command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("[1/3]"):
            break
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: the workers get it too
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
