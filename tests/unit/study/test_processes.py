"""Processes that do jobs: what one raises, how one dies or takes too long, is told of its own job alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from crackgrow.errors import SolveError
from crackgrow.study.processes import POLL, JobError, LostError, Processes, Result, TimeLimitError, as_they_end

ROOT = Path(__file__).parents[3]
PATIENCE = 60.0  # s, for what happens at last


def own(number: int) -> tuple[int, int, str | None]:
    """What is asked for, by which process, with how many threads for linear algebra."""
    return number, os.getpid(), os.environ.get("OPENBLAS_NUM_THREADS")


def refuses(number: int) -> int:
    raise SolveError(f"no solution of {number}")


def dies(words: str) -> None:
    sys.stderr.write(f"a line\n{words}\n")
    sys.stderr.flush()
    os.kill(os.getpid(), signal.SIGKILL)


def sleeps(seconds: float) -> None:
    time.sleep(seconds)


def test_jobs_are_shared_by_processes_that_stay() -> None:
    with Processes(2) as processes:
        found = [(job, *future.result()) for job, future in as_they_end(processes, own, range(6))]
    assert sorted(job for job, *_ in found) == list(range(6))
    assert all(job == number for job, number, *_ in found)
    assert len({process for *_, process, _ in found} - {os.getpid()}) == 2
    assert {threads for *_, threads in found} == {"1"}


class Late:
    """Workers of whom none are there at the first looks; they do a job at once."""

    def __init__(self) -> None:
        self.looks = [0, 0, 1]

    @property
    def n_workers(self) -> int:
        return self.looks.pop(0) if len(self.looks) > 1 else self.looks[0]

    def submit(self, function: Callable[..., Result], /, *args: Any) -> Future[Result]:
        done: Future[Result] = Future()
        done.set_result(function(*args))
        return done


def test_workers_that_are_yet_to_come_are_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """At leisure: a scheduler is not asked without end."""
    waited: list[float] = []
    monkeypatch.setattr(time, "sleep", waited.append)
    assert [future.result() for _, future in as_they_end(Late(), abs, [-2, -3])] == [2, 3]
    assert waited == [POLL, POLL]


def test_what_ends_a_job_is_told_and_the_next_one_is_done() -> None:
    with Processes(1, timeout=PATIENCE) as processes:
        with pytest.raises(JobError, match=r"^no solution of 3$"):
            processes.submit(refuses, 3).result()
        with pytest.raises(LostError, match="worker lost: 1 workers died") as lost:
            processes.submit(dies, "the last words").result()
        assert lost.value.words == "the last words"
        assert processes.submit(own, 5).result()[0] == 5
    with Processes(1, timeout=0.01) as processes, pytest.raises(TimeLimitError, match=r"^not done after 0\.01 s$"):
        processes.submit(sleeps, PATIENCE).result()


def test_processes_end_with_the_program_that_started_them(tmp_path: Path) -> None:
    """Also in the middle of a job, and where that program has no time to end them."""
    code = (
        "import sys, os; from crackgrow.study.processes import Processes\n"
        "with Processes(1) as processes:\n"
        "    print(processes.submit(os.getpid).result(), flush=True)\n"
        "    processes.submit(__import__('time').sleep, 600).result()\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        process = int(program.stdout.readline())
        program.kill()
    end = time.monotonic() + PATIENCE
    while is_there(process):
        assert time.monotonic() < end
        time.sleep(0.02)


def is_there(process: int) -> bool:
    """Whether a process goes on; one that has ended may wait to be asked for its exit code."""
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True, check=False)
    return done.stdout.strip()[:1] not in ("", "Z")
