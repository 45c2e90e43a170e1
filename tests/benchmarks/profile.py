"""Where the time of a growth step goes: `python -m tests.benchmarks.profile` writes the tables of profile.md.

Phases in CPU seconds without the profiler; functions under cProfile, which makes functions that call many others look
slower than they are. Private functions count for the public ones that call them. A class stands for its construction.
"""

from __future__ import annotations

import ast
import cProfile
import os
import pstats
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from crackgrow.run import grow
from tests.benchmarks.measure import timed_steps
from tests.benchmarks.paths import HERE, ROOT
from tests.benchmarks.record import PHASES
from tests.benchmarks.scenes import Run, spacing_for
from tests.benchmarks.tables import milliseconds, number, table, write_part

PACKAGE = ROOT / "crackgrow"
SHOWN = 30
SIZES = (3_000, 80_000)


@dataclass(frozen=True, slots=True)
class Function:
    """A public function of the package in a profile, per step."""

    name: str  # module.function, module.Class.method or module.Class
    n_calls: float
    cumulative: float  # s, with all that it calls
    own: float  # s, without


def functions(profile: cProfile.Profile, n_steps: int) -> list[Function]:
    """The public functions of the package, the longest first."""
    found = []
    for (file, line, name), (_, n_calls, own, cumulative, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        path = Path(file)
        if not path.is_relative_to(PACKAGE):
            continue
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        qualified = _qualified(path, line, name)
        if not any(part.startswith(("_", "<")) for part in qualified.split(".")):
            found.append(Function(f"{module}.{qualified}", n_calls / n_steps, cumulative / n_steps, own / n_steps))
    return sorted(found, key=lambda function: -function.cumulative)


def _qualified(path: Path, line: int, name: str) -> str:
    """`name` with the class that it is a method of; the class alone for its construction."""
    for start, end, owner in _classes(path):
        if start <= line <= end:
            return owner if name == "__init__" else f"{owner}.{name}"
    return name


@cache
def _classes(path: Path) -> list[tuple[int, int, str]]:
    """First line, last line and name of the classes in a file."""
    nodes = ast.walk(ast.parse(path.read_text()))
    return [
        (node.lineno, node.end_lineno or node.lineno, node.name) for node in nodes if isinstance(node, ast.ClassDef)
    ]


def profiled(run: Run) -> tuple[list[Function], int]:
    """The functions of the growth steps of a run, the first one left out, and how many steps those are."""
    steps = grow(run.load())
    next(steps)
    profile = cProfile.Profile(time.process_time)
    profile.enable()
    n = sum(1 for _ in steps)
    profile.disable()
    return functions(profile, n), n


def _texts(run: Run) -> Iterator[str]:
    later = timed_steps(run.load())[1:]
    total = sum(step.seconds for step in later)
    n_dofs = later[-1].result.n_dofs
    yield f"{n_dofs} unknowns, {len(later)} growth steps after the first, {milliseconds(total / len(later))} ms each:\n"
    phases = {phase: sum(step.result.seconds[phase] for step in later) for phase in PHASES}
    phases["all else"] = total - sum(phases.values())
    yield table(
        ("phase", "ms a step", "%"),
        [(phase, milliseconds(s / len(later)), number(100.0 * s / total)) for phase, s in phases.items()],
    )
    found, n = profiled(run)
    yield f"Functions, under the profiler, of {n} steps:\n"
    yield table(
        ("function", "calls a step", "cumulative (ms a step)", "own (ms a step)"),
        [(f"`{f.name}`", number(f.n_calls), milliseconds(f.cumulative), milliseconds(f.own)) for f in found[:SHOWN]],
    )


def main() -> None:
    """Profile both sizes and write."""
    for n, steps in zip(SIZES, (8, 2), strict=True):
        settings = (f"numerics.spacing={spacing_for(n):.5g}", f"growth.steps={steps}")
        text = "\n".join(_texts(Run(f"profile {n}", "compression30", settings)))
        write_part(HERE / "profile.md", str(n), text)
        print(text)


if __name__ == "__main__":
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    main()
