"""Where the runs go: workers of this machine, or those of a scheduler that is there."""

from __future__ import annotations

import contextlib
import logging
import os
import queue
import re
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import dask
from dask.utils import parse_bytes
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, Worker, WorkerPlugin
from distributed.utils import silence_logging_cmgr

from crackgrow.blas import THREAD_SETTINGS
from crackgrow.errors import CaseError, CrackgrowError, Fault, reason_of
from crackgrow.study.sweep.job import Job, Values

LOOPBACK: Final = "127.0.0.1"
LOST_WORKERS: Final = 2  # a run may lose so many and is repeated; the next one is its own fault
GONE: Final = "the Dask scheduler is gone; what has ended is in the table, go on with --resume"
LEAST_MEMORY: Final = 200_000_000  # bytes: the program and its libraries alone take about so much
MOST_MEMORY: Final = 2**60  # bytes: no machine has more, and systems count no further than 2^63
_ADDRESS: Final = re.compile(r"([a-z]+://)?[^/]+:\d+/?|inproc://.+")
POLL: Final = 1.0  # s, between looks at how many workers there are
CONNECT: Final = "15s"
SETTINGS: Final = {
    "distributed.scheduler.allowed-failures": LOST_WORKERS,
    "distributed.admin.tick.limit": "1h",  # nobody wants to know of a busy machine
    "distributed.worker.profile.enabled": False,  # it would look at every worker a hundred times a second
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # else arrays are paged in anew each time
}


class _Deaf(WorkerPlugin):
    """Lets a worker pass over Ctrl-C, which a terminal sends to all processes: the sweep itself ends its workers."""

    def setup(self, worker: Worker) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


class ClusterError(CrackgrowError):
    """The scheduler can't be reached, or has gone away."""

    exit_code = 3


def bytes_of(memory: str) -> int:
    """Bytes of a text such as 2GB; raises CaseError, also where no run fits into it."""
    try:
        size = int(parse_bytes(memory))
    except (ValueError, OverflowError):
        raise _memory_error(f"'{memory}' is no size of a memory") from None
    if size > MOST_MEMORY:
        raise _memory_error(f"'{memory}' is more than a machine can have")
    if size < LEAST_MEMORY:
        raise _memory_error(f"'{memory}' is {size} bytes; a worker takes {LEAST_MEMORY // 10**6} MB at least")
    return size


def _memory_error(message: str) -> CaseError:
    return CaseError([Fault("--memory", None, "", f"{message}; wanted: such as 2GB or 500MiB")])


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True, slots=True)
class Place:
    """Where runs go. Raises CaseError where the scheduler's address is none."""

    scheduler: str | None  # address; None: processes of this machine
    workers: int  # processes at most
    memory: int | None  # bytes of each; None does not bound them

    def __post_init__(self) -> None:
        if self.scheduler is not None and not _ADDRESS.fullmatch(self.scheduler):
            message = f"'{self.scheduler}' is no address of a scheduler; wanted: such as tcp://127.0.0.1:8786"
            raise CaseError([Fault("--scheduler", None, "", message)])


@contextlib.contextmanager
def connected(place: Place, n_jobs: int) -> Iterator[Client]:
    """A client of the scheduler, or of as many processes of this machine as there are jobs for; raises ClusterError."""
    scheduler, memory = place.scheduler, place.memory
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(SETTINGS))
        stack.enter_context(silence_logging_cmgr(logging.CRITICAL))  # what becomes of workers is told by the table
        ours = scheduler is None
        if scheduler is None:
            cluster = LocalCluster(
                n_workers=min(place.workers, n_jobs),
                threads_per_worker=1,
                processes=True,
                host=LOOPBACK,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": f"{LOOPBACK}:0"},  # else its HTTP server asks for a fixed port
                memory_limit=0 if memory is None else memory,  # 0: not bounded
                env=dict.fromkeys(THREAD_SETTINGS, "1"),
                silence_logs=logging.CRITICAL,
            )
            scheduler = stack.enter_context(cluster).scheduler_address
        try:
            client = Client(scheduler, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler at {scheduler}: {error}; start one with `dask scheduler`") from error
        stack.enter_context(client)
        if ours:
            client.register_plugin(_Deaf())
        yield client


def run_all(client: Client, jobs: Sequence[Job], function: Callable[[Job], Values]) -> Iterator[tuple[Job, Values]]:
    """Run the jobs on the workers and yield each with what came of it, as they end.

    No more are given than there are workers: when one dies, Dask holds that against all that it was given. Nor is any
    bound to a worker: Dask never gives it to another one if none was left when its own died.
    A run whose worker dies is repeated by Dask; one that loses several is `failed`. Raises ClusterError.
    """
    waiting = deque(jobs)
    running: dict[object, tuple[Job, Future[Values]]] = {}  # held here: Dask drops what nobody asks for
    ended: queue.SimpleQueue[Future[Values]] = queue.SimpleQueue()
    told: list[tuple[Job, Values]] = []
    while True:
        try:
            n_workers = len(client.nthreads())
        except OSError as error:
            yield from told
            raise ClusterError(f"{GONE}: {error}") from error
        while waiting and len(running) < n_workers:
            job = waiting.popleft()
            future = client.submit(function, job, pure=False)
            running[future.key] = job, future
            future.add_done_callback(ended.put)
        yield from told  # only now: no worker waits for what is done with it
        told.clear()
        if not waiting and not running:
            return
        try:
            future = ended.get(timeout=POLL)
        except queue.Empty:
            continue
        values = _outcome(future)
        if values is None:
            future.add_done_callback(ended.put)
        else:
            job, _ = running.pop(future.key)
            told.append((job, values))


def _outcome(future: Future[Values]) -> Values | None:
    """What a job returned, or why it didn't; None where that was lost with its worker, and the job is run again."""
    try:
        values: Values = future.result(timeout=POLL)
    except CancelledError as error:
        raise ClusterError(f"{GONE}: {error}") from error
    except KilledWorker as error:
        reason = f"worker lost: {error.allowed_failures + 1} workers died of this run, for want of memory perhaps"
        return {"status": "failed", "reason": reason}
    except Exception as error:
        if isinstance(error, TimeoutError) and future.status != "error":
            return None
        return {"status": "failed", "reason": reason_of(error)}
    return values
