"""What is kept of a measurement, the ratios that follow from it, and the history of all measurements as a CSV file."""

from __future__ import annotations

import csv
import math
import os
import platform
import subprocess
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np
import scipy

from crackgrow import __version__
from tests.benchmarks.paths import ROOT

PHASES = ("cover", "assembly", "factorize", "contact", "criterion", "output")

NEGLIGIBLE = 0.02
"""Phases that take less than this fraction of a step have no ratio."""


@dataclass(frozen=True, slots=True)
class Environment:
    """What a measurement was made with."""

    version: str
    commit: str  # of git, the last one that touched the program; a plus: the program differed from it
    python: str
    numpy: str
    scipy: str
    machine: str  # processor and cores


@dataclass(frozen=True, slots=True)
class Measurement:
    """One run. Seconds are CPU seconds where the name does not say wall; nan where there is nothing to measure."""

    part: str
    run: str
    n_dofs: int
    n_contact: int  # contact points at the start
    steps: int  # that were solved
    first: float  # s, step 0
    step: float  # s, median of the later steps; step 0 where there are none
    step_wall: float
    cover: float  # s, phases of the same steps: medians
    assembly: float
    factorize: float
    contact: float
    criterion: float
    output: float
    floor_factorize: float
    floor_solve: float
    condensation: float  # s, of all contact points
    yardstick: float
    peak_MB: float  # of the process after the run, before anything else is measured
    K_II_error: float = math.nan  # of step 0, relative to the reference
    path_deviation_mm: float = math.nan  # from the reference path
    command: float = math.nan  # s, the whole command without frames and figures
    command_wall: float = math.nan
    start_up: float = math.nan  # s, of the command up to its first step
    start_up_wall: float = math.nan
    environment: Environment = field(default_factory=lambda: environment())

    @property
    def floor(self) -> float:
        """Seconds of the bare factorization and one solve."""
        return self.floor_factorize + self.floor_solve


def ratios(measured: Measurement) -> dict[str, float]:
    """What carries over from one machine to another: the larger the worse, all of them."""
    found = {
        "step/floor": measured.step / measured.floor,
        "first step/floor": measured.first / measured.floor,
        **{
            f"{phase}/floor": getattr(measured, phase) / measured.floor
            for phase in PHASES
            if getattr(measured, phase) > NEGLIGIBLE * measured.step
        },
        "later/first step": measured.step / measured.first if measured.steps > 1 else math.nan,
        "condensation/factorization": measured.condensation / measured.floor_factorize,
        "floor/yardstick": measured.floor / measured.yardstick,
        "command/yardstick": measured.command / measured.yardstick,
        "start-up/yardstick": measured.start_up / measured.yardstick,
        "memory, kB/dof": 1e3 * measured.peak_MB / measured.n_dofs,
    }
    return {name: value for name, value in found.items() if math.isfinite(value)}


def environment() -> Environment:
    """Of this process."""
    return Environment(
        version=__version__,
        commit=_commit(),
        python=platform.python_version(),
        numpy=np.__version__,
        scipy=scipy.__version__,
        machine=f"{_processor()}, {os.cpu_count()} cores",
    )


def _commit() -> str:
    """The last commit of the program, with a plus where it has been changed since; empty outside of a repository."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(ROOT), *arguments, "--", "crackgrow", "cases"]
        return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()

    return git("log", "-1", "--format=%h") + ("+" if git("status", "--porcelain") else "")


def _processor() -> str:
    """The model of the processor."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


_OWN = [item.name for item in fields(Measurement) if item.name != "environment"]
_TEXT = ("part", "run")
_COUNTS = ("n_dofs", "n_contact", "steps")


def append(history: Path, measured: Measurement) -> None:
    """Add a row to the history. Raises ValueError where its columns are others."""
    row = {**asdict(measured.environment), **{name: _written(getattr(measured, name)) for name in _OWN}}
    if history.exists():
        with history.open(newline="") as file:
            header = next(csv.reader(file))
        if header != list(row):
            raise ValueError(f"{history} has other columns: move it away; its columns {header}, now {list(row)}")
    else:
        history.write_text(",".join(row) + "\n")
    with history.open("a", newline="") as file:
        csv.DictWriter(file, list(row), lineterminator="\n").writerow(row)


def read(history: Path) -> list[Measurement]:
    """All rows, oldest first."""
    with history.open(newline="") as file:
        return [_from_row(row) for row in csv.DictReader(file)]


def latest(measurements: list[Measurement]) -> list[Measurement]:
    """The last one of every run."""
    return list({measured.run: measured for measured in measurements}.values())


def _written(value: object) -> object:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.5g}"
    return value


def _from_row(row: dict[str, str]) -> Measurement:
    values: dict[str, object] = {}
    for name in _OWN:
        text = row[name]
        values[name] = text if name in _TEXT else int(text) if name in _COUNTS else float(text or "nan")
    values["environment"] = Environment(**{item.name: row[item.name] for item in fields(Environment)})
    return Measurement(**values)  # type: ignore[arg-type]
