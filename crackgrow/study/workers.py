"""Where the runs of a study go: each is a process `crackgrow run` that a thread waits for, here or on a Dask worker."""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from crackgrow.blas import THREAD_SETTINGS
from crackgrow.errors import CaseError, CrackgrowError

ROOT: Final = Path(__file__).resolve().parents[2]  # that the package is imported from
POLL: Final = 0.05  # s, between looks at whether a process has ended
TRIM: Final = "MALLOC_TRIM_THRESHOLD_"  # Dask sets it so low for its workers that runs take half as long again
CONNECT: Final = "15s"
LEAST_MEMORY: Final = 400_000_000  # bytes: of less a run may take too little data to begin (`cli.LEAST`), measured
MOST_MEMORY: Final = 2**60  # bytes: no machine has more, and systems count no further than 2^63
DATA_PART: Final = 0.8  # of the memory that a run's data may take: the rest is for programs and libraries
END_WITH_STARTER: Final = 1  # PR_SET_PDEATHSIG of Linux
_LIBC: Final = ctypes.CDLL(None) if sys.platform == "linux" else None
_MEMORY: Final = re.compile(r"(\d+\.?\d*(?:e[-+]?\d+)?) *([kmgtp]?)(i?)b?", re.IGNORECASE)
_ADDRESS: Final = re.compile(r"([a-z]+://)?[^/]+:\d+/?|inproc://.+")


class ClusterError(CrackgrowError):
    """The scheduler can't be reached, or has gone away, or Dask is not installed."""

    exit_code = 3


@dataclass(frozen=True, slots=True)
class Workers:
    """How many runs go on at a time, where, and what each may take.

    Making one raises CaseError where what is asked for can't be, ClusterError where Dask is missing.
    """

    number: int | None = None  # processes of this machine at most; None: one a core
    scheduler: str | None = None  # address of a Dask scheduler, whose workers are used instead
    memory: str | None = None  # of a run, such as "2GB"; None does not bound them
    timeout: float | None = None  # s, after which a run is given up

    def __post_init__(self) -> None:
        if self.scheduler is not None and not _ADDRESS.fullmatch(self.scheduler):
            wanted = "is no address of a scheduler; wanted: such as tcp://127.0.0.1:8786"
            raise CaseError.at("--scheduler", f"'{self.scheduler}' {wanted}")
        if self.memory is not None and self.scheduler is None and sys.platform != "linux":
            raise CaseError.at("--memory", "only Linux bounds the memory of a process; leave it out here")
        if self.scheduler is not None and find_spec("distributed") is None:
            raise ClusterError("--scheduler needs Dask, not installed here: pip install 'crackgrow[sweep]'")
        if self.timeout is not None and not 0.0 < self.timeout < math.inf:
            raise CaseError.at("--timeout", f"{self.timeout:g} given; wanted: seconds, more than 0")
        bytes_of(self.memory)

    @contextlib.contextmanager
    def there(self) -> Iterator[Callable[[tuple[str, ...]], Future[str]]]:
        """What has `run_process` done with the words of a command; raises ClusterError where no scheduler is.

        What goes on here when the block is left is killed: it can be gone on with.
        """
        limits = bytes_of(self.memory), self.timeout
        if self.scheduler is not None:
            with _client_of(self.scheduler) as client:
                executor = client.get_executor(pure=False)
                yield lambda words: executor.submit(run_process, words, *limits)
            return
        left = threading.Event()
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        with ThreadPoolExecutor(self.number or cores) as threads:  # cores that this process may use
            try:
                yield lambda words: threads.submit(run_process, words, *limits, left)
            finally:
                left.set()
                threads.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _client_of(scheduler: str) -> Iterator[Any]:
    """The client of a scheduler; raises ClusterError."""
    import logging

    from distributed import Client  # here: an extra of the package
    from distributed.utils import silence_logging_cmgr

    with silence_logging_cmgr(logging.CRITICAL):  # what becomes of workers is told by the table
        try:
            client = Client(scheduler, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler at {scheduler}: {error}; start one with `dask scheduler`") from error
        with client:
            yield client


def run_process(
    words: tuple[str, ...], memory: int | None, timeout: float | None, left: threading.Event | None = None
) -> str:
    """Run a command of the program in a process of one thread; returns why it failed, nothing where it did not.

    left: kills it when it is set; None on a worker of Dask
    """
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, **dict.fromkeys(THREAD_SETTINGS, "1"), "PYTHONPATH": path}
    if left is None:
        environment.pop(TRIM, None)
    began, left = time.monotonic(), left or threading.Event()
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "crackgrow", *words],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            process_group=0,  # Ctrl-C is for the study, which ends its processes itself
            preexec_fn=lambda: _bind(memory),
        )
        why = ""
        while process.poll() is None:
            if left.wait(POLL):
                why = "broken off"
            elif timeout is not None and time.monotonic() - began > timeout:
                why = f"not done after {timeout:g} s"
            if why:
                process.kill()
                process.wait()
        errors.seek(0)
        return why or _reason(process.returncode, errors.read().decode(errors="replace"))


def _bind(memory: int | None) -> None:
    """Let this process, between fork and exec, end with the thread that waits for it, and its memory be bounded."""
    if _LIBC is not None:
        _LIBC.prctl(END_WITH_STARTER, signal.SIGKILL)
    if memory is not None:
        import resource  # here: of POSIX alone

        resource.setrlimit(resource.RLIMIT_DATA, 2 * (int(DATA_PART * memory),))


def _reason(code: int, told: str) -> str:
    """Why a process failed, by its exit code and what it told."""
    if code < 0:
        return f"killed by {signal.Signals(-code).name}, for want of memory perhaps; --resume goes on with it"
    if code == 0:
        return ""
    lines = [line for line in told.splitlines() if line.strip() and not line.startswith("warning: ")]
    if code == 1:  # with a traceback
        return f"internal error: {lines[-1]}" if lines else "internal error"
    own = [number for number, line in enumerate(lines) if line.startswith("crackgrow: ")]
    return " ".join(lines[own[-1] if own else 0 :]).removeprefix("crackgrow: ") or f"exit code {code}"


def bytes_of(memory: str | None) -> int | None:
    """Bytes of a text such as 2GB; raises CaseError, also where no run fits into them or no machine has them."""
    if memory is None:
        return None
    match = _MEMORY.fullmatch(memory.strip())
    number, prefix, binary = match.groups() if match else ("nan", "", "")
    size = float(number) * (1024 if binary else 1000) ** " kmgtp".index(prefix.lower() or " ")
    if not LEAST_MEMORY <= size <= MOST_MEMORY:
        wanted = f"wanted: {LEAST_MEMORY // 10**6} MB or more, such as 2GB or 500MiB"
        raise CaseError.at("--memory", f"'{memory}' is no size of a memory that a run can have; {wanted}")
    return int(size)
