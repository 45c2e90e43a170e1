"""One run in a process of its own: `python -m tests.benchmarks.measure NAME` prints its measurement as JSON.

All seconds but those that say wall are CPU seconds: another process on the machine adds nothing to them. The program
times its phases by the wall clock, in whose place the CPU clock is put while a run goes on.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from unittest import mock

import numpy as np

from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.configuration import Configuration
from crackgrow.run.result import StepResult
from tests.benchmarks.accuracy import K_II_error, path_deviation_mm
from tests.benchmarks.floor import condensation, floor, from_nothing, yardstick
from tests.benchmarks.paths import ROOT
from tests.benchmarks.record import PHASES, Environment, Measurement
from tests.benchmarks.scenes import NO_FILES, Run, all_runs

COMMANDS = 3
"""Repeats of a whole command."""

ENOUGH_SAMPLES, ENOUGH_FIRSTS, ENOUGH_SECONDS = 3, 7, 6.0
"""The floor, and the first step, are measured at least so many times, or so many CPU seconds."""

START_UP = """
import sys, pathlib, crackgrow.cli
from crackgrow.results.writer import RunWriter
case = crackgrow.load_case(sys.argv[1], sys.argv[2:])
RunWriter(case, pathlib.Path("never_written"))
crackgrow.grow(case)
"""


@dataclass(frozen=True, slots=True)
class TimedStep:
    """A step and what it took."""

    result: StepResult
    seconds: float
    wall: float


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """What steps are held against, again and again: CPU seconds."""

    configuration: Configuration
    condensed: bool  # whether the contact points are condensed too
    factorize: list[float] = field(default_factory=list)
    solve: list[float] = field(default_factory=list)
    condensation: list[float] = field(default_factory=list)
    yardstick: list[float] = field(default_factory=list)

    def take(self) -> None:
        """Measure each once more."""
        bare = floor(self.configuration)
        self.factorize.append(bare.factorize)
        self.solve.append(bare.solve)
        self.condensation.append(condensation(self.configuration)[0] if self.condensed else np.nan)
        self.yardstick.append(yardstick())


def timed_steps(case: Case, between: Callable[[], None] = lambda: None) -> list[TimedStep]:
    """The steps of a run; `between` is called after each."""
    steps: list[TimedStep] = []
    with mock.patch("time.perf_counter", time.process_time):
        run = grow(case)
        while True:
            start, start_wall = time.process_time(), time.monotonic()
            result = next(run, None)
            if result is None:
                return steps
            steps.append(TimedStep(result, time.process_time() - start, time.monotonic() - start_wall))
            between()


def first_step(case: Case) -> float:
    """CPU seconds of step 0, as in a new process."""
    start = time.process_time()
    next(grow(case))
    return time.process_time() - start


def measured(run: Run) -> Measurement:
    """Run it for its memory, then again with its floor measured after every step: speed changes from second to second.

    Without repeats the first run is the one that is timed, and its floor is measured afterwards.
    """
    case = run.load()
    steps = timed_steps(case)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    configuration = from_nothing(case)
    samples = Samples(configuration, run.part != "sizes" and configuration.faces.n > 0)
    passes = [timed_steps(case, samples.take) for _ in range(run.repeats)] or [steps]
    start = time.process_time()
    while len(samples.yardstick) < ENOUGH_SAMPLES:
        samples.take()
        if time.process_time() - start > ENOUGH_SECONDS:
            break
    firsts = [steps[0].seconds]
    while len(firsts) < ENOUGH_FIRSTS and sum(firsts) < ENOUGH_SECONDS:
        firsts.append(first_step(case))
    usual = [step for one in passes for step in (one[1:] or one)]
    command, command_wall = _process(("-m", "crackgrow", *_arguments(run))) if run.command else (np.nan, np.nan)
    start_up, start_up_wall = _process(("-c", START_UP, run.path)) if run.command else (np.nan, np.nan)
    accurate = run.case == "compression30" and run.part == "runs"
    return Measurement(
        part=run.part,
        run=run.name,
        n_dofs=len(configuration.scaled),
        n_contact=configuration.faces.n,
        steps=len(steps),
        first=float(np.median(firsts)),
        step=float(np.median([step.seconds for step in usual])),
        step_wall=float(np.median([step.wall for step in usual])),
        **{phase: float(np.median([step.result.seconds[phase] for step in usual])) for phase in PHASES},
        floor_factorize=float(np.median(samples.factorize)),
        floor_solve=float(np.median(samples.solve)),
        condensation=float(np.median(samples.condensation)),
        yardstick=float(np.median(samples.yardstick)),
        peak_MB=peak,
        K_II_error=K_II_error(steps[0].result) if accurate else np.nan,
        path_deviation_mm=path_deviation_mm(steps[-1].result) if accurate and run.command else np.nan,
        command=command,
        command_wall=command_wall,
        start_up=start_up,
        start_up_wall=start_up_wall,
    )


def in_own_process(run: Run) -> Measurement:
    """The measurement of a run by a fresh process, whose peak memory is that of the run. Raises where it fails."""
    command = [sys.executable, "-m", "tests.benchmarks.measure", run.name]
    answer = json.loads(subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True).stdout)
    return Measurement(**{**answer, "environment": Environment(**answer["environment"])})


def _arguments(run: Run) -> list[str]:
    """Of the command that runs a case; the folder of the results comes last."""
    settings = [part for setting in (*run.settings, *NO_FILES) for part in ("--set", setting)]
    return ["run", run.path, "--quiet", *settings, "--out"]


def _process(arguments: Sequence[str]) -> tuple[float, float]:
    """Median CPU and wall seconds of a process of Python with `arguments`. Raises RuntimeError where it fails."""
    seconds = []
    for _ in range(COMMANDS):
        with tempfile.TemporaryDirectory() as folder:
            whole = [sys.executable, *arguments, *([folder] if arguments[-1] == "--out" else [])]
            start = time.monotonic()
            process = subprocess.Popen(whole, cwd=ROOT)
            _, status, usage = os.wait4(process.pid, 0)
            wall = time.monotonic() - start
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise RuntimeError(f"{' '.join(whole)} ended with {process.returncode}")
        seconds.append((usage.ru_utime + usage.ru_stime, wall))
    cpu, wall = np.median(seconds, axis=0)
    return float(cpu), float(wall)


def main() -> None:
    """Measure the run whose name is given, and print."""
    (run,) = [run for run in all_runs() if run.name == sys.argv[1]]
    print(json.dumps(asdict(measured(run))))


if __name__ == "__main__":
    main()
