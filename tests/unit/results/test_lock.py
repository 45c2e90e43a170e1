"""Two runs never write into one folder at once, and a run that is gone is in nobody's way."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from crackgrow.results.lock import LOCK, FolderLock, LockedError
from crackgrow.results.writer import RunWriter
from tests.properties.broken_off import CASES, command, contents, finished, started, wait_for
from tests.unit.results.synthetic import make_case, make_end

pytestmark = pytest.mark.physics

COARSE = ("numerics.spacing=4", "growth.steps=2", "output.figures=false", "output.report=false")
HOLDING = """
import pathlib, sys, time
from crackgrow.results.lock import FolderLock
lock = FolderLock(pathlib.Path(sys.argv[1]), "case slope")
lock.take()
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
    with pytest.raises(LockedError, match=f"another run is writing into {tmp_path}") as caught:
        FolderLock(tmp_path, "other").take()
    assert f"case slope, process {process.pid} on {socket.gethostname()}, since 20" in str(caught.value)
    assert caught.value.exit_code == 3
    process.kill()
    process.communicate()
    assert (tmp_path / LOCK).is_file()
    with FolderLock(tmp_path, "next").held():
        assert json.loads((tmp_path / LOCK).read_bytes())["process"] == os.getpid()
    assert not list(tmp_path.iterdir())


def test_a_file_system_without_locks_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(file: int, operation: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", refuse)
    writer = RunWriter(make_case(), tmp_path)
    writer.begin()
    writer.finish(make_end(0))
    assert "knows no locks (No locks available)" in (tmp_path / "run.log").read_text()
    assert "see to it that no other run" in json.loads((tmp_path / "summary.json").read_text())["warnings"][0]


def test_a_second_run_in_the_folder_of_one_that_goes_on_ends_and_changes_nothing(tmp_path: Path) -> None:
    process = started(command("compression30", COARSE, tmp_path))
    assert wait_for(process, "step 0")
    process.send_signal(signal.SIGSTOP)
    before = contents(tmp_path)
    for more in ([], ["--resume"]):
        done = finished(command("compression30", COARSE, tmp_path, *more))
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
