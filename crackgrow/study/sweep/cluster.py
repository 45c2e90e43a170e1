"""The workers of a Dask scheduler that is there, by the interface of concurrent.futures."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from functools import partial
from typing import Any, Final

import dask
from distributed import Client, KilledWorker
from distributed.utils import silence_logging_cmgr

from crackgrow.study.processes import LostError, Result
from crackgrow.study.sweep.place import ClusterError

GONE: Final = "the Dask scheduler is gone; what has ended is in the table, go on with --resume"
CONNECT: Final = "15s"


class Cluster:
    """All workers of a scheduler, whose number may change. Futures raise ClusterError and JobError.

    A job whose worker dies is done again by another one, as often as the scheduler allows it.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False)

    @property
    def n_workers(self) -> int:
        """How many there are now; raises ClusterError. A job that no worker has may be lost with others' workers."""
        try:
            return len(self._client.nthreads())
        except OSError as error:
            raise ClusterError(f"{GONE}: {error}") from error

    def submit(self, function: Callable[..., Result], /, *args: Any) -> Future[Result]:
        """Have a function called by one of the workers."""
        told: Future[Result] = Future()
        self._executor.submit(function, *args).add_done_callback(partial(_tell, told))
        return told


@contextlib.contextmanager
def connected(scheduler: str) -> Iterator[Cluster]:
    """The workers of the scheduler at an address; raises ClusterError where there is none."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set({"distributed.admin.tick.limit": "1h"}))  # of a busy machine nobody asks
        stack.enter_context(silence_logging_cmgr(logging.CRITICAL))  # what becomes of workers is told by the table
        try:
            client = Client(scheduler, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ClusterError(f"no Dask scheduler at {scheduler}: {error}; start one with `dask scheduler`") from error
        yield Cluster(stack.enter_context(client))


def _tell(told: Future[Result], found: Future[Result]) -> None:
    """Hand on what has become of a job, in the words of studies."""
    try:
        told.set_result(found.result())
    except CancelledError as error:
        told.set_exception(ClusterError(f"{GONE}: {error}"))
    except KilledWorker as error:
        told.set_exception(LostError(error.allowed_failures + 1))
    except Exception as error:
        told.set_exception(error)
