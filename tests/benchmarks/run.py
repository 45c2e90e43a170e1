"""The benchmark: `make bench` runs the program as it is beside an earlier commit, and writes bench.csv.

It needs the history of the repository; a few minutes with `ARGS=--quick`, half an hour without.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
from pathlib import Path

import numpy as np

from tests.benchmarks.beside import AGAINST, PHASES, Scene, Timed, beside, program_of
from tests.benchmarks.tables import HERE, ROOT, number, table, write_csv

BESIDE = (
    Scene("compression30 3 mm", "compression30", ("numerics.spacing=3",)),
    Scene("compression30 1.5 mm", "compression30", ("numerics.spacing=1.5",), quick=True),
    Scene("compression30 0.75 mm", "compression30", ("numerics.spacing=0.75",)),
    Scene("compression30 20,000", "compression30", ("numerics.spacing=0.43380",), steps=4),
    Scene("compression30 80,000", "compression30", ("numerics.spacing=0.21120",), steps=4),
    Scene("flaw_and_hole 2 mm", "flaw_and_hole", ("numerics.spacing=2",), quick=True),
    Scene("en_echelon 1 mm", "en_echelon", ("numerics.spacing=1",), steps=6),
    Scene("two_flaws 1 mm", "two_flaws", ("numerics.spacing=1",), steps=5),
    Scene("interface_friction04 0.04", "interface_friction04", ("numerics.spacing=0.04",), quick=True),
    Scene("random_flaws 3 mm", "random_flaws", ("numerics.spacing=3",), steps=4),
)
"""Shipped cases on cells of one size, that both programs know."""

SLOWER = 1.05
"""Ratios of a step beyond this are marked: the least of three rounds differ by less, run to run."""

NEGLIGIBLE = 0.02
"""Phases that take less than this part of a step have no ratio."""

HEADER = ("scene", "unknowns", "first step, ms", "then", "ratio", "a later step, ms", "then", "ratio", *PHASES,
          "the run, s", "peak, MB")  # fmt: skip


def row_of(name: str, then: Timed, now: Timed) -> tuple[str, ...]:
    """A row of the table: milliseconds, and ratios of the program as it is over the other one, phase by phase too."""
    later, step = now.later / then.later, now.first if np.isnan(now.later) else now.later
    return (
        name, f"{now.unknowns:,}", number(1e3 * now.first), number(1e3 * then.first), number(now.first / then.first),
        number(1e3 * now.later), number(1e3 * then.later), number(later) + (" slower" if later > SLOWER else ""),
        *(number(now.phases[p] / then.phases[p]) if now.phases[p] > NEGLIGIBLE * step else "" for p in PHASES),
        number(now.whole), f"{now.peak:.0f}",
    )  # fmt: skip


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="make bench ARGS=...", description=__doc__)
    parser.add_argument("--only", metavar="TEXT", default="", help="the scenes whose name contains this")
    parser.add_argument("--quick", action="store_true", help="the scenes that take a few seconds; nothing is written")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="runs of each program (default: 3)")
    options = parser.parse_args()
    chosen = [scene for scene in BESIDE if options.only in scene.name and (scene.quick or not options.quick)]
    rows = []
    with program_of(AGAINST) as then:
        for scene in chosen:
            rows.append(row_of(scene.name, *beside(scene, (then, ROOT), options.rounds)))
            print(*rows[-1], flush=True)
    print(f"{table(HEADER, rows)}\n{_made_with()}")
    if len(chosen) == len(BESIDE):
        write_csv(HERE / "bench.csv", HEADER, rows, _made_with())


def _made_with() -> str:
    """The program and the machine."""
    command = ["git", "-C", str(ROOT), "log", "-1", "--format=%h", "--", "crackgrow"]
    commit = subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.exists() else []
    processor = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    python = f"Python {platform.python_version()}, NumPy {np.__version__}"
    return f"Commit {commit} beside {AGAINST}; {python}; {processor or platform.machine()}, {os.cpu_count()} cores."


if __name__ == "__main__":
    main()
