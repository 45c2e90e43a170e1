"""Processes of this machine that do the jobs of a study, in the manner of concurrent.futures.

Each has one thread for linear algebra, and no part in the others: one that dies, or takes too long, ends its job alone.
A process is `python -m crackgrow.study.processes FD`, FD being its end of a pipe.
"""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final, Protocol, TypeVar

from crackgrow.blas import THREAD_SETTINGS
from crackgrow.errors import CrackgrowError, reason_of

CHILD: Final = "crackgrow.study.processes"
ROOT: Final = Path(__file__).resolve().parents[2]  # that the package is imported from
POLL: Final = 1.0  # s, between looks at how many workers there are

Job = TypeVar("Job")
Result = TypeVar("Result")


class JobError(CrackgrowError):
    """A job that gave nothing back; the message says why."""


class LostError(JobError):
    """A job whose workers died, so many; `words` are the last of them."""

    def __init__(self, n_lost: int, words: str = "") -> None:
        super().__init__(f"worker lost: {n_lost} workers died of this run, for want of memory perhaps")
        self.words = words


class TimeLimitError(JobError):
    """A job that took too long."""


class Workers(Protocol):
    """An executor that knows how many jobs it does at once, which may change."""

    @property
    def n_workers(self) -> int: ...

    def submit(self, function: Callable[..., Result], /, *args: Any) -> Future[Result]: ...


def as_they_end(
    workers: Workers, function: Callable[[Job], Result], jobs: Sequence[Job]
) -> Iterator[tuple[Job, Future[Result]]]:
    """Have all jobs done, and yield each as it ends; no more are given at a time than there are workers."""
    waiting, ended = deque(jobs), set[Future[Result]]()
    running: dict[Future[Result], Job] = {}
    while waiting or running:
        told = [(running.pop(future), future) for future in ended]
        try:
            while waiting and len(running) < workers.n_workers:
                job = waiting.popleft()
                running[workers.submit(function, job)] = job
        except CrackgrowError:
            yield from told  # before it is raised that there are no workers any more
            raise
        yield from told  # only now: no worker waits for what is done with it
        ended = set()
        if running:
            ended, _ = wait(running, POLL, FIRST_COMPLETED)
        elif waiting:
            time.sleep(POLL)  # for workers to come


class Processes:
    """So many processes, to be used as a context; a job whose process dies is done again until it has lost its lives.

    timeout: seconds after which a job is given up

    Futures raise JobError.
    """

    def __init__(self, n_workers: int, *, lives: int = 1, timeout: float | None = None) -> None:
        self.n_workers = n_workers
        self._lives, self._timeout = lives, timeout
        self._threads = ThreadPoolExecutor(n_workers)
        self._children = [_Child() for _ in range(n_workers)]
        self._idle = deque(self._children)

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_: object) -> None:
        for child in self._children:
            child.retire()
        self._threads.shutdown(cancel_futures=True)
        for child in self._children:
            child.end()

    def submit(self, function: Callable[..., Result], /, *args: Any) -> Future[Result]:
        """Have a function, which can be pickled, called by one of the processes."""
        return self._threads.submit(self._done, function, args)

    def _done(self, function: Callable[..., Result], arguments: tuple[Any, ...]) -> Result:
        child, lost = self._idle.popleft(), ""
        try:
            for _ in range(self._lives):
                try:
                    result: Result = child.do((function, arguments), self._timeout)
                    return result
                except (EOFError, OSError):
                    lost = child.end()
            raise LostError(self._lives, lost)
        finally:
            self._idle.append(child)


class _Child:
    """A process that does one job after another; one that has ended is started again for the next job."""

    def __init__(self) -> None:
        self._guard = threading.Lock()
        self._retired = False
        self._process: subprocess.Popen[bytes] | None = None

    def do(self, job: object, timeout: float | None) -> Any:
        """The result of a job; raises JobError, and EOFError or OSError where the process dies."""
        self._start()
        self._pipe.send(job)
        if not self._pipe.poll(timeout):
            self.end()
            raise TimeLimitError(f"not done after {timeout:g} s")
        result, fault = self._pipe.recv()
        if fault:
            raise JobError(fault)
        return result

    def _start(self) -> None:
        path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with self._guard:
            if self._retired:
                raise JobError("broken off")
            if self._process is not None:
                return
            self._pipe, theirs = Pipe()
            self._errors = tempfile.TemporaryFile()  # noqa: SIM115  (until the process ends)
            with theirs:
                self._process = subprocess.Popen(
                    [sys.executable, "-m", CHILD, str(theirs.fileno())],
                    pass_fds=[theirs.fileno()],
                    env={**os.environ, **dict.fromkeys(THREAD_SETTINGS, "1"), "PYTHONPATH": path},
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=self._errors,
                    process_group=0,  # Ctrl-C is for the study, which ends its processes itself
                )

    def retire(self) -> None:
        """Kill the process, and start none any more."""
        with self._guard:
            self._retired = True
            if self._process is not None:
                self._process.kill()

    def end(self) -> str:
        """End the process if there is one; returns what it said last, or how it ended."""
        with self._guard:
            process, self._process = self._process, None
        if process is None:
            return ""
        self._pipe.close()
        process.kill()
        code = process.wait()
        with self._errors as errors:
            errors.seek(0)
            lines = errors.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"exit code {code}"


def main(descriptor: int) -> None:
    """Do what comes through the pipe, a pickled function with its arguments, and send back result and fault."""
    pipe = Connection(descriptor)
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(pipe, jobs), daemon=True).start()
    while True:
        try:
            function, arguments = pickle.loads(jobs.get())
            pipe.send((function(*arguments), ""))
        except Exception as error:
            pipe.send((None, reason_of(error)))


def _listen(pipe: Connection, jobs: queue.SimpleQueue[bytes]) -> None:
    """Take in jobs; end the process in the middle of one when nobody is there any more to wait for it."""
    try:
        while True:
            jobs.put(pipe.recv_bytes())
    except (EOFError, OSError):
        os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]))
