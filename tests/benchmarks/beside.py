"""Runs of the program as it is beside those of an earlier commit, alternately and in one go, each in its own process.

All seconds are CPU seconds of one thread, the least of some rounds: the program times its phases by the wall clock, in
whose place the CPU clock is put. A shared machine is now slow and now fast, for both of them; ratios carry over.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from tests.benchmarks.tables import ROOT

AGAINST: Final = "473cd78"
"""The commit that speed is held against: the last one before steps became slower on the same cells."""

PHASES: Final = ("cover", "assembly", "factorize", "contact", "criterion", "output")

CHILD: Final = """
import json, resource, sys, time
time.perf_counter = time.process_time
import crackgrow
case, n = crackgrow.load_case(sys.argv[2], sys.argv[3:]), int(sys.argv[1])
run, steps = crackgrow.grow(case), []
while len(steps) < n:
    begin = time.process_time()
    step = next(run, None)
    if step is None:
        break
    steps.append((step.n_dofs, time.process_time() - begin, step.seconds))
print(json.dumps((steps, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)))
"""
"""In words that both programs know: unknowns, seconds and those of phases, step by step; then peak memory, MB."""


@dataclass(frozen=True, slots=True)
class Scene:
    """What is run."""

    name: str
    case: str  # of the folder `cases`, which each program has of its own
    settings: tuple[str, ...]
    quick: bool = False
    steps: int = 1000  # that are made at most


@dataclass(frozen=True, slots=True)
class Timed:
    """The steps of a scene by one of the programs."""

    unknowns: int  # of the first step
    first: float  # s
    later: float  # s, mean of the later steps; nan where there are none
    whole: float  # s, all steps
    phases: dict[str, float]  # s, means of the later steps, or those of the only one
    peak: float  # MB


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


def beside(scene: Scene, programs: Sequence[Path], rounds: int) -> list[Timed]:
    """A scene by each of some programs. Raises ValueError where their cells differ."""
    told = [[_run(scene, program) for program in programs] for _ in range(rounds)]
    found = [_least(each) for each in zip(*told, strict=True)]
    if len({timed.unknowns for timed in found}) > 1:
        raise ValueError(f"{scene.name}: {' and '.join(str(timed.unknowns) for timed in found)} unknowns")
    return found


def _run(scene: Scene, program: Path) -> tuple[list[tuple[int, float, dict[str, float]]], float]:
    """What `CHILD` tells."""
    none = ("output.frames=none", "output.figures=false")
    command = [sys.executable, "-c", CHILD, str(scene.steps), f"cases/{scene.case}.yaml", *scene.settings, *none]
    alone = {**os.environ, "PYTHONPATH": str(program), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    steps, peak = json.loads(subprocess.run(command, cwd=program, env=alone, check=True, capture_output=True).stdout)
    return steps, peak


def _least(told: Sequence[tuple[list[tuple[int, float, dict[str, float]]], float]]) -> Timed:
    """The least of each step, and of each of its phases, of all rounds."""
    seconds = np.array([[step[1] for step in steps] for steps, _ in told]).min(axis=0)
    phases = np.array([[[step[2][phase] for phase in PHASES] for step in steps] for steps, _ in told]).min(axis=0)
    later = slice(1, None) if len(seconds) > 1 else slice(None)
    return Timed(
        unknowns=told[0][0][0][0],
        first=float(seconds[0]),
        later=float(seconds[1:].mean()) if len(seconds) > 1 else float("nan"),
        whole=float(seconds.sum()),
        phases=dict(zip(PHASES, phases[later].mean(axis=0).tolist(), strict=True)),
        peak=min(peak for _, peak in told),
    )
