"""What a step costs: wall time by phase, and factorizations, of all that is done for it in a thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Spent(threading.local):
    """What has been spent since the step began."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Count from here on."""
        self.seconds = dict.fromkeys(("cover", "assembly", "factorize", "contact", "criterion"), 0.0)
        self.n_factorizations = 0


SPENT = Spent()


@contextmanager
def timed(phase: str) -> Iterator[None]:
    """Add the wall time of a block to a phase."""
    start = time.perf_counter()
    yield
    SPENT.seconds[phase] += time.perf_counter() - start
