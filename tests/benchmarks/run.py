"""The benchmark: `make bench` runs the program as it is beside an earlier commit, and writes bench.csv.

It needs the history of the repository; a few minutes with `ARGS=--quick`, half an hour without. All seconds are CPU
seconds of one thread, the least of some rounds, each in its own process. A shared machine is now slow, now fast for
both: ratios carry over.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import platform
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from tests.benchmarks.tables import HERE, ROOT, number, table, write_csv

AGAINST: Final = "473cd78"
"""The commit that speed is held against: the last one before steps became slower on the same cells."""


CHILD: Final = """
import json, resource, sys, time
import crackgrow
case, n = crackgrow.load_case(sys.argv[2], sys.argv[3:]), int(sys.argv[1])
run, steps = crackgrow.grow(case), []
while len(steps) < n:
    begin = time.process_time()
    step = next(run, None)
    if step is None:
        break
    steps.append((step.n_dofs, time.process_time() - begin))
print(json.dumps((steps, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)))
"""
"""In words that both programs know: unknowns and seconds, step by step; then peak memory, MB."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A shipped case on cells of one size, that both programs know."""

    name: str
    case: str  # of the folder `cases`, which each program has of its own
    settings: tuple[str, ...]
    quick: bool = False
    steps: int = 1000  # that are made at most


SCENES: Final = (
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

SLOWER: Final = 1.05
"""Ratios of a step beyond this are marked: the least of three rounds differ by less, run to run."""


HEADER = ("scene", "unknowns", "first step, ms", "then", "ratio", "a later step, ms", "then", "ratio",
          "the run, s", "peak, MB")  # fmt: skip


@contextlib.contextmanager
def program_of(commit: str) -> Iterator[Path]:
    """A folder with the program of a commit and its cases. Ends the process where there is no such commit."""
    command = ["git", "-C", str(ROOT), "archive", commit, "crackgrow", "cases"]
    packed = subprocess.run(command, capture_output=True, check=False)
    if packed.returncode:
        sys.exit(f"commit {commit} is held against, and is not there: {packed.stderr.decode().strip()}")
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as files:
            files.extractall(folder, filter="data")
        yield Path(folder)


def timed(scene: Scene, program: Path) -> tuple[Floats, float]:
    """Unknowns and seconds, step by step (n, 2), of a scene by a program; and peak memory, MB."""
    none = ("output.frames=none", "output.figures=false")
    command = [sys.executable, "-c", CHILD, str(scene.steps), f"cases/{scene.case}.yaml", *scene.settings, *none]
    alone = {**os.environ, "PYTHONPATH": str(program), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    steps, peak = json.loads(subprocess.run(command, cwd=program, env=alone, check=True, capture_output=True).stdout)
    return np.array(steps), peak


def row_of(scene: Scene, then: Path, rounds: int) -> tuple[str, ...]:
    """A row of the table: milliseconds, and ratios of this program over that of a folder.

    Raises ValueError where their cells differ.
    """
    told = [[timed(scene, program) for program in (then, ROOT)] for _ in range(rounds)]
    before, now = (np.min([steps for steps, _ in each], axis=0) for each in zip(*told, strict=True))
    if before[0, 0] != now[0, 0]:
        raise ValueError(f"{scene.name}: {before[0, 0]:.0f} and {now[0, 0]:.0f} unknowns")
    several = len(now) > 1
    (first, step), (first_then, step_then) = ((each[0], each[several:].mean(axis=0)) for each in (now, before))
    ratio = float(step[1] / step_then[1])
    later = (number(1e3 * step[1]), number(1e3 * step_then[1]), number(ratio) + " slower" * (ratio > SLOWER))
    return (
        scene.name, f"{now[0, 0]:,.0f}", number(1e3 * first[1]), number(1e3 * first_then[1]),
        number(first[1] / first_then[1]), *(later if several else ("", "", "")),
        number(float(now[:, 1].sum())), f"{min(peak for _, (_, peak) in told):.0f}",
    )  # fmt: skip


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="make bench ARGS=...", description=__doc__)
    parser.add_argument("--only", metavar="TEXT", default="", help="the scenes whose name contains this")
    parser.add_argument("--quick", action="store_true", help="the scenes that take a few seconds; nothing is written")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="runs of each program (default: 3)")
    options = parser.parse_args()
    chosen = [scene for scene in SCENES if options.only in scene.name and (scene.quick or not options.quick)]
    rows = []
    with program_of(AGAINST) as then:
        for scene in chosen:
            rows.append(row_of(scene, then, options.rounds))
            print(*rows[-1], flush=True)
    print(f"{table(HEADER, rows)}\n{_made_with()}")
    if len(chosen) == len(SCENES):
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
