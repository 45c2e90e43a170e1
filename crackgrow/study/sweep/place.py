"""Where the runs of a sweep go, as it is asked for."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Final

from crackgrow.errors import CaseError, CrackgrowError

LEAST_MEMORY: Final = 200_000_000  # bytes: the program and its libraries alone take about so much
MOST_MEMORY: Final = 2**60  # bytes: no machine has more, and systems count no further than 2^63
_MEMORY: Final = re.compile(r"(\d+\.?\d*(?:e[-+]?\d+)?) *([kmgtp]?)(i?)b?", re.IGNORECASE)
_ADDRESS: Final = re.compile(r"([a-z]+://)?[^/]+:\d+/?|inproc://.+")


class MissingPackageError(CrackgrowError):
    """A package that only sweeps need is not installed."""

    exit_code = 3


class ClusterError(CrackgrowError):
    """The scheduler can't be reached, or has gone away."""

    exit_code = 3


@dataclass(frozen=True, slots=True)
class Place:
    """Workers of this machine, or those of a scheduler that is there."""

    scheduler: str | None  # address; None: processes of this machine
    workers: int  # processes at most
    memory: int | None  # bytes of each; None does not bound them

    @classmethod
    def of(cls, workers: int | None, scheduler: str | None, memory: str | None) -> Place:
        """What is asked for; raises CaseError where that can't be, MissingPackageError."""
        if scheduler is not None and not _ADDRESS.fullmatch(scheduler):
            raise CaseError.at("--scheduler", f"'{scheduler}' is no address of a scheduler; wanted: such as "
                         "tcp://127.0.0.1:8786")  # fmt: skip
        if memory is not None and scheduler is None and sys.platform != "linux":
            raise CaseError.at("--memory", "only Linux bounds the memory of a process; leave it out here")
        size = None if memory is None else bytes_of(memory)
        needed = ["pyarrow", *(["dask", "distributed"] if scheduler is not None else [])]
        missing = [name for name in needed if find_spec(name) is None]
        if missing:
            names = " and ".join(missing)
            raise MissingPackageError(f"sweeps need {names}, not installed here: pip install 'crackgrow[sweep]'")
        return cls(scheduler, workers or available_cores(), size)


def bytes_of(memory: str) -> int:
    """Bytes of a text such as 2GB; raises CaseError, also where no run fits into it."""
    wanted = "wanted: such as 2GB or 500MiB"
    match = _MEMORY.fullmatch(memory.strip())
    if match is None:
        raise CaseError.at("--memory", f"'{memory}' is no size of a memory; {wanted}")
    number, prefix, binary = match.groups()
    size = float(number) * (1024 if binary else 1000) ** " kmgtp".index(prefix.lower() or " ")
    if size > MOST_MEMORY:
        raise CaseError.at("--memory", f"'{memory}' is more than a machine can have; {wanted}")
    if size < LEAST_MEMORY:
        least = f"a worker takes {LEAST_MEMORY // 10**6} MB at least"
        raise CaseError.at("--memory", f"'{memory}' is {size:.0f} bytes; {least}; {wanted}")
    return int(size)


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
