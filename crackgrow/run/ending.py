"""Steps to go through in a loop, and behind it why they ended."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Generic, TypeVar

Step = TypeVar("Step")
End = TypeVar("End")


class Ending(Generic[Step, End]):
    """What a generator yields, and as `end`, once all of it is there, what it returns."""

    end: End

    def __init__(self, steps: Generator[Step, None, End]) -> None:
        self._steps = steps

    def __iter__(self) -> Iterator[Step]:
        self.end = yield from self._steps
