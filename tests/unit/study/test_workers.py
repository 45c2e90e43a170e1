"""Runs as processes: how one dies, takes too long or fails is told, and none outlives what waits for it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from crackgrow.results.lock import LOCK
from crackgrow.study.workers import Workers, run_process

ROOT = Path(__file__).parents[3]
FLAW = ROOT / "cases" / "compression30.yaml"
PATIENCE = 60.0  # s, for what happens at last
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
LONG = ("growth.steps=15", "growth.increment=0.05", "output.frames=none", "output.figures=false", "output.report=false")


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


def test_what_fails_a_run_is_told_in_its_own_words(tmp_path: Path) -> None:
    assert run_process(("--version",), None, None) == ""
    refused = run_process(command(tmp_path, "cracks.flaw.contact.friction=-1"), None, None)
    assert "friction: '-1' is out of range" in refused
    assert run_process(command(tmp_path), None, 0.01) == "not done after 0.01 s"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems bound no memory")
def test_memory_is_bounded(tmp_path: Path) -> None:
    """The program itself says that it has less than it needs to load."""
    assert "KiB of data are allowed" in run_process(command(tmp_path), 200_000_000, None)


@pytest.mark.physics
def test_runs_end_when_their_study_is_left(tmp_path: Path) -> None:
    with Workers(1).there() as submit:
        future, waiting = submit(command(tmp_path, *LONG)), submit(("--version",))
        process = process_of(tmp_path)
    assert future.result() == "broken off"
    assert waiting.cancelled()
    assert not is_there(process)


@pytest.mark.physics
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere they go on to their own end")
def test_runs_end_with_a_study_that_has_no_time_to_end_them(tmp_path: Path) -> None:
    code = f"from crackgrow.study.workers import run_process; run_process({command(tmp_path, *LONG)}, None, None)"
    with subprocess.Popen([sys.executable, "-c", code], cwd=ROOT) as program:
        process = process_of(tmp_path)
        program.kill()
    until(lambda: not is_there(process))
