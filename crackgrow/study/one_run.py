"""A run of a study: solved and written as `crackgrow run` does, but it tells nobody."""

from __future__ import annotations

import time
from collections.abc import Generator
from dataclasses import dataclass, field

from crackgrow.results.writer import RunWriter
from crackgrow.run.ending import Ending
from crackgrow.run.result import RunEnd, StepResult


@dataclass(frozen=True, slots=True)
class Spent:
    """Seconds that steps have taken, without writing."""

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)


def write_run(writer: RunWriter, steps: Generator[StepResult, None, RunEnd], spent: Spent | None = None) -> RunEnd:
    """Write each step as it comes, then the end, and return it; `writer` has begun, `spent` takes the times.

    Whatever a step raises goes into the summary, keeps what was solved, and passes through.
    """
    spent, all_steps = spent or Spent(), Ending(steps)
    try:
        cpu, wall = time.process_time(), time.perf_counter()
        for result in all_steps:
            spent.cpu.append(time.process_time() - cpu)
            spent.wall.append(time.perf_counter() - wall)
            writer.add(result)
            cpu, wall = time.process_time(), time.perf_counter()
        writer.finish(all_steps.end)
    except Exception as error:
        writer.break_off(error)
        raise
    return all_steps.end
