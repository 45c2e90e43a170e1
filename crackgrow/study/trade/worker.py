"""One timed run in a process of its own: `python -m crackgrow.study.trade.worker CASE FOLDER [KEY=VALUE...]`.

It does what `crackgrow run` does, and writes cost.json beside the results. Loading the program is not in the times.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Generator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from crackgrow.case import load_case
from crackgrow.errors import CaseError, CrackgrowError
from crackgrow.results.atomic import write_text
from crackgrow.results.summary import peak_memory_mb
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.study.one_run import write_run

COST_FILE = "cost.json"


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run has cost, and how it ended."""

    status: str  # that of the run, or refused (a wrong case), unsolved (no first step)
    reason: str
    cpu_seconds: float  # from reading the case to the last file
    wall_seconds: float
    cpu_steps: tuple[float, ...]  # step by step, without writing
    wall_steps: tuple[float, ...]
    peak_memory_mb: float


def main(arguments: Sequence[str]) -> int:
    """Run the case; whatever the program raises on purpose is a result like any other."""
    case_file, folder, *overrides = arguments
    cpu, wall = time.process_time(), time.perf_counter()
    cpu_steps: list[float] = []
    wall_steps: list[float] = []
    try:
        status, reason = _run(case_file, Path(folder), overrides, cpu_steps, wall_steps)
    except CaseError as error:
        status, reason = "refused", str(error)
    except CrackgrowError as error:
        status, reason = "unsolved", str(error)
    cost = Cost(
        status,
        reason,
        time.process_time() - cpu,
        time.perf_counter() - wall,
        tuple(cpu_steps),
        tuple(wall_steps),
        peak_memory_mb(),
    )
    write_text(Path(folder) / COST_FILE, json.dumps(asdict(cost), indent=1) + "\n")
    return 0


def _run(
    case_file: str, folder: Path, overrides: Sequence[str], cpu_steps: list[float], wall_steps: list[float]
) -> tuple[str, str]:
    """Run and write a case, with the times of its steps; returns status and reason."""
    case = load_case(case_file, overrides)
    writer = RunWriter(case, folder)
    writer.begin()
    end = write_run(writer, _timed(grow(case), cpu_steps, wall_steps))
    return end.status, end.reason


def _timed(
    steps: Generator[StepResult, None, RunEnd], cpu_steps: list[float], wall_steps: list[float]
) -> Generator[StepResult, None, RunEnd]:
    """The same steps, with the seconds that each took."""
    while True:
        cpu, wall = time.process_time(), time.perf_counter()
        try:
            result = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            return end
        cpu_steps.append(time.process_time() - cpu)
        wall_steps.append(time.perf_counter() - wall)
        yield result


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
