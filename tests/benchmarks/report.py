"""bench.md: tables of the latest measurement of every run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.benchmarks.fits import exponents, same_program
from tests.benchmarks.record import PHASES, Measurement
from tests.benchmarks.tables import milliseconds, number, table, write_part

Column = tuple[str, Callable[[Measurement], str]]

NAME: Column = ("run", lambda m: m.run)
DOFS: Column = ("unknowns", lambda m: str(m.n_dofs))
POINTS: Column = ("contact points", lambda m: str(m.n_contact))
MEMORY: Column = ("peak memory (MB)", lambda m: f"{m.peak_MB:.0f}")
COMMIT: Column = ("commit", lambda m: m.environment.commit)
STEP: Column = ("a step (ms)", lambda m: milliseconds(m.step))
FLOOR: Column = ("floor (ms)", lambda m: milliseconds(m.floor))

RATIOS: tuple[Column, ...] = (
    NAME, DOFS, POINTS,
    ("first step (ms)", lambda m: milliseconds(m.first)),
    STEP, FLOOR,
    ("step / floor", lambda m: number(m.step / m.floor)),
    ("first / later step", lambda m: number(m.first / m.step) if m.steps > 1 else ""),
    ("assembly / step", lambda m: number(m.assembly / m.step)),
    ("contact condensation / factorization", lambda m: number(m.condensation / m.floor_factorize)),
    MEMORY, COMMIT,
)  # fmt: skip

PHASE_COLUMNS: tuple[Column, ...] = (
    NAME, STEP,
    *((f"{phase} (ms)", lambda m, phase=phase: milliseconds(getattr(m, phase))) for phase in PHASES),
    ("bare factorization (ms)", lambda m: milliseconds(m.floor_factorize)),
    ("one solve (ms)", lambda m: milliseconds(m.floor_solve)),
    ("yardstick (ms)", lambda m: milliseconds(m.yardstick)),
    COMMIT,
)  # fmt: skip

COMMANDS: tuple[Column, ...] = (
    NAME, DOFS,
    ("steps", lambda m: str(m.steps)),
    ("command, wall (s)", lambda m: number(m.command_wall)),
    ("command, CPU (s)", lambda m: number(m.command)),
    ("start-up, wall (s)", lambda m: number(m.start_up_wall)),
    ("start-up, CPU (s)", lambda m: number(m.start_up)),
    ("a step, wall (ms)", lambda m: milliseconds(m.step_wall)),
    ("K_II error (%)", lambda m: number(100.0 * m.K_II_error)),
    ("path deviation (mm)", lambda m: number(m.path_deviation_mm)),
    COMMIT,
)  # fmt: skip

SIZES: tuple[Column, ...] = (
    DOFS, STEP,
    *((f"{phase} (ms)", lambda m, phase=phase: milliseconds(getattr(m, phase))) for phase in PHASES),
    ("first step (ms)", lambda m: milliseconds(m.first)),
    FLOOR, MEMORY, COMMIT,
)  # fmt: skip


def write_report(path: Path, measurements: Sequence[Measurement]) -> None:
    """Write the tables of the `measurements`, one of each run."""
    steps = [m for m in measurements if m.part != "sizes"]
    write_part(path, "ratios", _rows(RATIOS, steps))
    write_part(path, "phases", _rows(PHASE_COLUMNS, steps))
    write_part(path, "commands", _rows(COMMANDS, [m for m in steps if not math.isnan(m.command)]))
    sizes = same_program(measurements)
    write_part(path, "sizes", _rows(SIZES, sizes) + "\n" + _exponents(sizes))
    made = sorted({_environment(measured) for measured in measurements})
    write_part(path, "environment", "\n".join(made) + "\n")


def _rows(columns: Sequence[Column], measurements: Sequence[Measurement]) -> str:
    return table([name for name, _ in columns], [[cell(m) for _, cell in columns] for m in measurements])


def _exponents(sizes: Sequence[Measurement]) -> str:
    """The exponents as a table."""
    found = exponents(sizes)
    return table(("grows with the unknowns to the power of", ""), [(name, f"{p:.2f}") for name, p in found.items()])


def _environment(measured: Measurement) -> str:
    e = measured.environment
    return f"- {e.commit}: version {e.version}, Python {e.python}, NumPy {e.numpy}, SciPy {e.scipy}; {e.machine}"
