"""What a worker is given and does. Loading this module loads no numerics: first the worker's threads are settled."""

from __future__ import annotations

import contextlib
import pickle
import resource
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.blas import one_thread, single_threaded, warm_up

Values = dict[str, str | float | int | None]
"""Cells of the table by column, SI; None where there is no value."""

DATA_PART: Final = 0.8  # of a worker's memory that a run's data may take: the rest is for programs and libraries
PEAK_RESET: Final = Path("/proc/self/clear_refs")  # of Linux
FORGET_PEAK: Final = "5"
_ALONE = threading.Lock()  # runs in one process one after the other, however many threads it has


@dataclass(frozen=True, slots=True)
class Job:
    """One run."""

    number: int
    folder: Path  # absolute; the worker must see the same disk
    case: bytes  # pickled: reading it loads numerics
    memory: int | None  # bytes that its process may take; None: not bounded


def job_of(number: int, folder: Path, case: object, memory: int | None) -> Job:
    """The job of a case."""
    return Job(number, folder.resolve(), pickle.dumps(case), memory)


def run_job(job: Job) -> Values:
    """Run the case and return what its folder tells: a run that fails is told like any other."""
    one_thread()
    from crackgrow.study.sweep.solving import solve  # only now: numpy reads the threads when it loads

    with _ALONE, single_threaded():
        warm_up()
        with bounded_memory(job.memory):
            forget_peak_memory()
            return solve(pickle.loads(job.case), job.folder)


@contextlib.contextmanager
def bounded_memory(memory: int | None) -> Iterator[None]:
    """Let allocations fail (MemoryError) beyond a process' share of `memory` bytes, where the system can do that.

    Without it the first to notice is who guards the worker, and kills it.
    """
    if memory is None or sys.platform != "linux":
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = int(DATA_PART * memory)
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if hard == resource.RLIM_INFINITY else min(wanted, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def forget_peak_memory() -> None:
    """Let the peak of the process' memory be that of now, so that a run is not told those before it."""
    with contextlib.suppress(OSError):  # another system, or one that forbids it: then the peak is the worker's
        PEAK_RESET.write_text(FORGET_PEAK)
