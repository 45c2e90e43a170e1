"""A run of a study: solved and written as `crackgrow run` does, but it tells nobody."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

from crackgrow.results.writer import RunWriter
from crackgrow.run.result import RunEnd, StepResult


@dataclass(frozen=True, slots=True)
class Spent:
    """Seconds that steps have taken, without writing."""

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)


def write_run(writer: RunWriter, steps: Iterator[StepResult], spent: Spent | None = None) -> RunEnd:
    """Write each step as it comes, then the end, and return it; `writer` has begun, `spent` takes the times.

    Whatever a step raises goes into the summary, keeps what was solved, and passes through.
    """
    spent = spent or Spent()
    try:
        while True:
            cpu, wall = time.process_time(), time.perf_counter()
            try:
                result = next(steps)
            except StopIteration as stop:
                end: RunEnd = stop.value
                writer.finish(end)
                return end
            spent.cpu.append(time.process_time() - cpu)
            spent.wall.append(time.perf_counter() - wall)
            writer.add(result)
    except Exception as error:
        writer.break_off(error)
        raise
