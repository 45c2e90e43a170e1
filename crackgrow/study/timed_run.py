"""A run of a study, solved and written as `crackgrow run` does, but it tells nobody; and its times.

Those are taken in a process of its own: nothing is carried over from one run to the next, one BLAS thread.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from crackgrow.case import load_case
from crackgrow.errors import CaseError, CrackgrowError
from crackgrow.results.summary import peak_memory_mb
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.study.processes import JobError, LostError, Processes, TimeLimitError
from crackgrow.study.setting import CaseFile


@dataclass(frozen=True, slots=True)
class Spent:
    """Seconds that steps have taken, without writing."""

    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)


def write_run(writer: RunWriter, steps: Generator[StepResult, None, RunEnd], spent: Spent | None = None) -> RunEnd:
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
                break
            spent.cpu.append(time.process_time() - cpu)
            spent.wall.append(time.perf_counter() - wall)
            writer.add(result)
        writer.finish(end)
    except Exception as error:
        writer.break_off(error)
        raise
    return end


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run has cost, and how it ended."""

    status: str  # that of the run, or refused (a wrong case), unsolved (no first step), timeout, crashed
    reason: str
    cpu_seconds: float  # from reading the case to the last file
    wall_seconds: float
    cpu_steps: tuple[float, ...]  # step by step, without writing
    wall_steps: tuple[float, ...]
    peak_memory_mb: float


def run_in_processes(
    file: CaseFile, overrides: Sequence[str], folder: Path, repeat: int, timeout: float | None
) -> Cost:
    """Run a setting `repeat` times into a folder and return its median cost; the results are those of the last run.

    A run that ends in any other way than a result tells it in `status`: `timeout` after so many seconds, `crashed`.
    Only a setting that was solved is repeated.
    """
    costs: list[Cost] = []
    while len(costs) < repeat and (not costs or costs[-1].cpu_steps):
        try:
            with Processes(1, timeout=timeout) as process:
                costs.append(process.submit(timed_run, file, overrides, folder).result())
        except TimeLimitError as error:
            return _failed("timeout", str(error))
        except JobError as error:
            return _failed("crashed", error.words if isinstance(error, LostError) else str(error))
    return median_cost(costs) if costs[-1].cpu_steps else costs[-1]


def median_cost(costs: Sequence[Cost]) -> Cost:
    """The last of several costs of the same run, with the median of every time and memory."""
    middle = statistics.median
    return replace(
        costs[-1],
        cpu_seconds=middle(cost.cpu_seconds for cost in costs),
        wall_seconds=middle(cost.wall_seconds for cost in costs),
        cpu_steps=tuple(middle(step) for step in zip(*(cost.cpu_steps for cost in costs), strict=False)),
        wall_steps=tuple(middle(step) for step in zip(*(cost.wall_steps for cost in costs), strict=False)),
        peak_memory_mb=middle(cost.peak_memory_mb for cost in costs),
    )


def timed_run(file: CaseFile, overrides: Sequence[str], folder: Path) -> Cost:
    """Run the case as `crackgrow run` does; whatever the program raises on purpose is a result like any other.

    Loading the program is not in the times.
    """
    cpu, wall, spent = time.process_time(), time.perf_counter(), Spent()
    status: str
    try:
        case = load_case(file.path, (*file.overrides, *overrides))
        writer = RunWriter(case, folder)
        writer.begin()
        end = write_run(writer, grow(case), spent)
        status, reason = end.status, end.reason
    except CaseError as error:
        status, reason = "refused", str(error)
    except CrackgrowError as error:
        status, reason = "unsolved", str(error)
    total = time.process_time() - cpu, time.perf_counter() - wall
    return Cost(status, reason, *total, tuple(spent.cpu), tuple(spent.wall), peak_memory_mb())


def _failed(status: str, reason: str) -> Cost:
    return Cost(status, reason, math.nan, math.nan, (), (), math.nan)
