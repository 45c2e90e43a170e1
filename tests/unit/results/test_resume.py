"""Where a run goes on: the newest checkpoint that fits, for the same case; two runs never write into one folder."""

from __future__ import annotations

import errno
import fcntl
import io
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow import cli
from crackgrow.case.model import Case
from crackgrow.results import resume as resume_module
from crackgrow.results.lock import LOCK, LockedError, locked
from crackgrow.results.resume import ResumeError, Resumption, find_resumption
from crackgrow.results.writer import RunWriter
from tests.properties.broken_off import CASES, command, contents, finished, started, wait_for
from tests.scenes import shipped_case
from tests.unit.results.synthetic import make_case, make_end

pytestmark = pytest.mark.physics

COARSE = ("numerics.spacing=3", "output.frames=none", "output.figures=false")


def case(*settings: str, name: str = "compression30") -> Case:
    return shipped_case(name, [*COARSE, *settings])


def run(folder: Path, *settings: str, name: str = "compression30", resume: bool = False) -> int:
    words = [word for setting in (*COARSE, *settings) for word in ("--set", setting)]
    more = ["--resume"] if resume else []
    return cli.main(["run", str(CASES / f"{name}.yaml"), "--out", str(folder), *words, *more])


def found_in(folder: Path, *settings: str) -> Resumption:
    """Where a run in a folder goes on."""
    found = find_resumption(case(*settings), folder)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of two steps; only to be looked at."""
    folder = tmp_path_factory.mktemp("done")
    assert run(folder, "growth.steps=2") == 0
    return folder


@pytest.fixture
def copy(done: Path, tmp_path: Path) -> Path:
    """A copy of the finished run, to be changed."""
    return Path(shutil.copytree(done, tmp_path / "copy"))


def test_frames_and_pictures_of_steps_to_come_go(tmp_path: Path) -> None:
    frames = ("output.frames=every_step", "growth.steps=1")
    assert run(tmp_path, *frames) == 0
    names = ("frames/step_0007.vtu", "cracks/.step_0001.tmp.vtp", "frames/.step_0001.tmp.vtu")
    stale = [tmp_path / name for name in names]
    pictures = [tmp_path / "render" / "sigma_1" / name for name in ("step_0000.png", "animation.gif")]
    for path in (*stale, *pictures):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"of another run")
    assert run(tmp_path, *frames[:1], "growth.steps=2", resume=True) == 0
    assert not any(path.exists() for path in (*stale, *pictures))
    assert len(list((tmp_path / "frames").glob("*"))) == 3


def test_a_finished_run_goes_on_for_more_steps(copy: Path, tmp_path: Path) -> None:
    """What the first run has spent counts."""
    spent = json.loads((copy / "summary.json").read_text())["cpu_seconds"]
    assert run(copy, "growth.steps=3", resume=True) == 0
    assert run(tmp_path / "at once", "growth.steps=3") == 0
    assert contents(copy) == contents(tmp_path / "at once")
    summary = json.loads((copy / "summary.json").read_text())
    assert summary["cpu_seconds"] > spent > 0.0
    assert summary["resumed_with_steps"] == [2]


def test_what_has_no_part_in_results_may_change(done: Path) -> None:
    found = found_in(done, "growth.steps=9", "title=Another", "source=none", "output.figures=true")
    assert (found.finished, found.checkpoint.step, found.remarks) == (None, 2, ())


def test_a_changed_case_is_refused_with_what_has_changed(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = contents(copy)
    settings = ("growth.steps=2", "cracks.flaw.contact.friction=0.25", "growth.increment=1 mm")
    assert run(copy, *settings, resume=True) == 2
    lines = capsys.readouterr().err.splitlines()
    assert "the case is not that of the run" in lines[0]
    assert "  cracks.flaw.contact.friction: 0.0 then, 0.25 now" in lines[1:]
    assert "  growth.increment: 0.002 then, 0.001 now" in lines[1:]
    assert all("friction" in line or "increment" in line for line in lines[1:])
    assert contents(copy) == before


HISTORY, STAGES = "loading.history=[{}]", "loading={{stages: [{}]}}"
FACTORS = "{factor: 0.5}, {name: more, factor: 1}"
NAMED = "{loads: {shear: 0.5}}, {name: more, loads: {shear: 1}}"


def cyclic(loading: str) -> list[str]:
    """Settings of a coarse scene without growth and its loading; four of its loads have a name in stages."""
    named = ["loading.history=null", *(f"loads.{number}.name=shear" for number in range(2, 6))]
    return ["numerics.spacing=10", *(named if "stages" in loading else []), loading]


def test_another_case_and_fewer_steps_are_refused(done: Path) -> None:
    with pytest.raises(ResumeError, match="name: compression30 then, compression45 now"):
        find_resumption(case("growth.steps=2", name="compression45"), done)
    with pytest.raises(ResumeError, match="has 2 steps already, 1 are asked for"):
        find_resumption(case("growth.steps=1"), done)


@pytest.mark.parametrize(("kind", "so_far", "more", "changed"), [
    (HISTORY, "0.5, 1.0", "0.2", ["0.6, 1.0, 0.2"]),
    # nor may a later stage name a load of theirs that had no name in stages: it would be off in them
    (STAGES, FACTORS, "{factor: 0.2}", [FACTORS.replace("0.5", "0.6"), f"{FACTORS}, {{loads: {{shear: 0.5}}}}"]),
    (STAGES, NAMED, "{loads: {shear: 0.2}}", []),
])  # fmt: skip
def test_loads_to_come_may_change_and_those_before_not(
    kind: str, so_far: str, more: str, changed: list[str], tmp_path: Path
) -> None:
    name, longer = "cyclic_friction", cyclic(kind.format(f"{so_far}, {more}"))
    assert run(tmp_path / "short", *cyclic(kind.format(so_far)), name=name) == 0
    for other in changed:
        with pytest.raises(ResumeError, match=r"loading\.(history|stages)"):
            find_resumption(case(*cyclic(kind.format(other)), name=name), tmp_path / "short")
    assert run(tmp_path / "short", *longer, name=name, resume=True) == 0
    assert run(tmp_path / "at once", *longer, name=name) == 0
    assert contents(tmp_path / "short") == contents(tmp_path / "at once")


def with_header(path: Path, header: Callable[[dict[str, Any]], dict[str, Any]]) -> bytes:
    """A checkpoint with another header."""
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    changed = json.dumps(header(json.loads(arrays["header"].tobytes())))
    arrays["header"] = np.frombuffer(changed.encode(), dtype=np.uint8)
    data = io.BytesIO()
    np.savez(data, **arrays)
    return data.getvalue()


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "no run", "no results"])
def test_a_damaged_checkpoint_is_told_and_the_one_before_it_taken(copy: Path, damage: str) -> None:
    path = copy / "checkpoint" / "step_0002.npz"
    data = path.read_bytes()
    place = data.index(b"compression30")
    flipped = data[:place] + b"C" + data[place + 1 :]
    damaged = {"cut": data[: len(data) // 2], "flipped": flipped, "empty": b""}
    for key in ("run", "results"):
        damaged[f"no {key}"] = with_header(path, lambda header, key=key: {k: header[k] for k in header if k != key})
    path.write_bytes(damaged[damage])
    found = found_in(copy, "growth.steps=3")
    assert found.checkpoint.step == 1
    (remark,) = found.remarks
    assert "step_0002.npz is damaged" in remark
    if damage != "cut":
        return
    assert run(copy, "growth.steps=3", resume=True) == 0
    assert any("is damaged" in text for text in json.loads((copy / "summary.json").read_text())["warnings"])


def test_tables_that_were_changed_do_not_fit(copy: Path) -> None:
    for name in ("tips.csv", "contact.csv"):
        (copy / name).write_bytes((copy / name).read_bytes().replace(b"\n1,", b"\n7,"))
    found = found_in(copy, "growth.steps=3")
    assert found.checkpoint.step == 1  # which counts on step 0 alone
    assert found.remarks == ("the checkpoint of step 2 does not fit tips.csv, contact.csv",)
    (copy / "tips.csv").unlink()
    with pytest.raises(ResumeError, match=r"nothing to go on from.*step 2.*step 1 does not fit tips\.csv"):
        found_in(copy, "growth.steps=3")


def test_another_version_goes_on_with_a_warning_and_another_format_or_none_at_all_is_refused(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resume_module, "__version__", "99.0")
    assert "gone on with by 99.0" in found_in(copy, "growth.steps=3").remarks[0]
    for path in (copy / "checkpoint").iterdir():
        path.write_bytes(with_header(path, lambda header: {"format": 99}))
    with pytest.raises(ResumeError, match=rf"has format 99.*wanted {resume_module.FORMAT}"):
        found_in(copy, "growth.steps=3")
    shutil.rmtree(copy / "checkpoint")
    with pytest.raises(ResumeError, match="no checkpoint to go on from"):
        found_in(copy, "growth.steps=3")


def test_reading_a_checkpoint_runs_no_code(copy: Path, tmp_path: Path) -> None:
    path = copy / "checkpoint" / "step_0002.npz"
    touched = tmp_path / "touched"

    class Harmful:
        def __reduce__(self) -> tuple[object, ...]:
            return Path.touch, (touched,)

    np.save(tmp_path / "bad.npy", np.array([Harmful()], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "a") as archive:
        archive.write(tmp_path / "bad.npy", "bad.npy")
    found = found_in(copy, "growth.steps=3")
    assert found.checkpoint.step == 1
    assert "allow_pickle" in found.remarks[0]
    assert not touched.exists()


COARSER = ("numerics.spacing=4", "growth.steps=2", "output.figures=false", "output.report=false")
HOLDING = """
import pathlib, sys, time
from crackgrow.results.lock import locked
with locked(pathlib.Path(sys.argv[1]), "case slope"):
    print("taken", flush=True)
    time.sleep(600)
"""


def holder(folder: Path) -> subprocess.Popen[str]:
    """Another process that holds the lock of a folder."""
    process = started([sys.executable, "-c", HOLDING, str(folder)])
    assert wait_for(process, "taken")
    return process


def test_a_lock_says_who_holds_it_and_goes_with_the_process(tmp_path: Path) -> None:
    process = holder(tmp_path)
    with pytest.raises(LockedError, match=f"another run is writing into {tmp_path}") as caught, locked(tmp_path, "it"):
        pass
    assert f"case slope, process {process.pid} on {socket.gethostname()}, since 20" in str(caught.value)
    assert caught.value.exit_code == 3
    process.kill()
    process.communicate()
    assert (tmp_path / LOCK).is_file()
    with locked(tmp_path, "next"):
        assert json.loads((tmp_path / LOCK).read_bytes())["process"] == os.getpid()
    assert not list(tmp_path.iterdir())


def test_a_file_system_without_locks_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(file: int, operation: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    writer = RunWriter(make_case(), tmp_path)
    with writer.held():
        writer.begin()
        writer.finish(make_end(0))
    assert "knows no locks (No locks available)" in (tmp_path / "run.log").read_text()
    assert "see to it that no other run" in json.loads((tmp_path / "summary.json").read_text())["warnings"][0]


def test_a_second_run_in_the_folder_of_one_that_goes_on_ends_and_changes_nothing(tmp_path: Path) -> None:
    process = started(command("compression30", COARSER, tmp_path))
    assert wait_for(process, "step 0")
    process.send_signal(signal.SIGSTOP)
    before = contents(tmp_path)
    for more in ([], ["--resume"]):
        done = finished(command("compression30", COARSER, tmp_path, *more))
        assert done.returncode == 3
        assert f"process {process.pid} on " in done.stderr
        assert len(done.stderr.splitlines()) == 1
        assert contents(tmp_path) == before
    process.send_signal(signal.SIGCONT)
    process.communicate()
    assert process.returncode == 0


@pytest.mark.parametrize("study", ["sweep", "trade"])
def test_studies_hold_their_folders(study: str, tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text(f"base: {CASES / 'compression30.yaml'}\nparameters: {{growth.steps: [0]}}\n")
    file = {"sweep": tmp_path / "sweep.yaml", "trade": CASES / "compression30.yaml"}[study]
    process = holder(tmp_path / "out")
    done = finished([sys.executable, "-m", "crackgrow", study, str(file), "--out", str(tmp_path / "out")])
    process.kill()
    process.communicate()
    assert done.returncode == 3
    assert f"process {process.pid} on " in done.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == [LOCK]
