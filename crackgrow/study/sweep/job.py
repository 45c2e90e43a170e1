"""A run of a sweep, in its worker."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.blas import single_threaded, warm_up
from crackgrow.case.model import Case
from crackgrow.errors import reason_of
from crackgrow.results.atomic import OccupiedError
from crackgrow.results.lock import LockedError
from crackgrow.results.resume import ResumeError, find_resumption
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.study.sweep.columns import Values, measured
from crackgrow.study.timed_run import write_run

DATA_PART: Final = 0.8  # of a worker's memory that a run's data may take: the rest is for programs and libraries
PEAK_RESET: Final = Path("/proc/self/clear_refs")  # of Linux
FORGET_PEAK: Final = "5"
_ALONE = threading.Lock()  # runs in one process one after the other, however many threads it has


@dataclass(frozen=True, slots=True)
class Job:
    """One run."""

    number: int
    folder: Path  # absolute; the worker must see the same disk
    case: Case
    memory: int | None  # bytes that its process may take; None: not bounded


def run_job(job: Job) -> Values:
    """Run the case and return what its folder tells: a run that fails is told like any other."""
    with _ALONE, single_threaded():
        warm_up()
        with bounded_memory(job.memory):
            forget_peak_memory()
            return solve(job.case, job.folder)


def solve(case: Case, folder: Path) -> Values:
    """Run a case into a folder, from the last checkpoint there if one is of this case; return what the folder tells.

    Whatever a run raises is its reason to fail: it has no part in the runs beside it.
    """
    try:
        return _solve(case, folder)
    except (OccupiedError, LockedError) as error:  # nothing in the folder is this run's
        return {"status": "failed", "reason": reason_of(error)}
    except Exception as error:
        return {**measured(folder), "status": "failed", "reason": reason_of(error)}


def _solve(case: Case, folder: Path) -> Values:
    writer = RunWriter(case, folder)
    with writer.held():
        try:
            found = find_resumption(case, folder)
        except ResumeError:  # the folder is that of another sweep
            found = None
        if found is None or found.finished is None:
            if found is None:
                writer.begin()
            else:
                writer.resume(found)
            write_run(writer, grow(case, None if found is None else found.checkpoint))
        return measured(folder)


@contextlib.contextmanager
def bounded_memory(memory: int | None) -> Iterator[None]:
    """Let allocations fail (MemoryError) beyond a process' share of `memory` bytes, where the system can do that."""
    if memory is None or sys.platform != "linux":
        yield
        return
    import resource  # here: of POSIX alone

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
