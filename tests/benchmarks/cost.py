"""What `crackgrow check` and `crackgrow run` tell of a run beside what it takes, or what it took an earlier program.

    python -m tests.benchmarks.cost [--against COMMIT] [SCENE ...]

Runs whole commands, each in a process of its own with one BLAS thread. Without names it refits the constants in
crackgrow/plan/cost.json to all scenes, a quarter of an hour, and writes tests/benchmarks/cost.csv. Against a commit of
the repository it makes the steps alone; a shared machine is now slow, now fast for both programs: ratios carry over.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from crackgrow.blas import THREAD_SETTINGS
from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.plan.cost import cost_of, sizes_of, terms_of

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ABOUT = "What runs are told to take and take, start, files and report included: python -m tests.benchmarks.cost"
COLUMNS = ("run", "unknowns", "told_s", "taken_s", "told_MiB", "taken_MiB")

Scene = tuple[str, tuple[str, ...]]

SHIPPED: tuple[Scene, ...] = tuple((path.stem, ()) for path in sorted((ROOT / "cases").glob("*.yaml")))

OTHERS: tuple[Scene, ...] = (
    ("compression30", ("numerics.spacing=0.2", "growth.steps=3")),
    ("compression30", ("numerics.spacing=0.1", "growth.steps=2")),
    ("compression30", ("numerics.spacing=0.8", "numerics.support=2.5", "growth.steps=6")),
    ("compression30", ("numerics.accuracy=draft",)),
    ("compression30", ("numerics.accuracy=fine",)),
    ("two_flaws", ("numerics.accuracy=1 %", "growth.steps=4")),
    ("random_flaws", ("numerics.accuracy=draft", "numerics.spacing=auto", "growth.steps=1")),
)

SPEED: tuple[Scene, ...] = (
    ("compression30", ("numerics.spacing=1.5",)),
    ("compression30", ("numerics.spacing=0.4338", "growth.steps=3")),
    ("compression30", ("numerics.spacing=0.2112", "growth.steps=3")),
    ("flaw_and_hole", ("numerics.spacing=2",)),
    ("en_echelon", ("numerics.spacing=1", "growth.steps=5")),
    ("two_flaws", ("numerics.spacing=1", "growth.steps=4")),
    ("interface_friction04", ("numerics.spacing=0.04",)),
    ("random_flaws", ("numerics.spacing=3", "growth.steps=3")),
)
"""On cells of one size, which earlier programs know."""

STEPS = "import sys, crackgrow; [*crackgrow.grow(crackgrow.load_case(sys.argv[1], sys.argv[2:]))]"
ROUNDS = 2  # the quicker one counts: the first of a program compiles its kernels


def case_of(scene: Scene) -> Case:
    name, settings = scene
    return load_case(ROOT / "cases" / f"{name}.yaml", settings)


def taken(words: Sequence[str], program: Path = ROOT) -> tuple[float, float]:
    """Seconds of CPU and MiB of memory that a process of Python takes with the program in a folder."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    environment |= dict.fromkeys(THREAD_SETTINGS, "1") | {"PYTHONPATH": str(program)}
    process = subprocess.Popen([sys.executable, *words], cwd=program, env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{words} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def taken_by_run(scene: Scene) -> tuple[float, float]:
    """The same of the command that runs a scene."""
    name, settings = scene
    more = [word for setting in settings for word in ("--set", setting)]
    with tempfile.TemporaryDirectory() as folder:
        return taken(["-m", "crackgrow", "run", f"cases/{name}.yaml", "--out", folder, "--quiet", *more])


def main(given: Sequence[str] | None = None) -> None:
    """Measure; print, or fit and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("only", nargs="*", metavar="SCENE", help="shipped cases that are told of alone")
    parser.add_argument("--against", metavar="COMMIT", help="an earlier program")
    asked = parser.parse_args(given)
    only = asked.only
    if unknown := set(only) - {name for name, _ in SHIPPED}:
        parser.error(f"no shipped case: {', '.join(sorted(unknown))}")
    if asked.against:
        compare(asked.against, [scene for scene in SPEED if not only or scene[0] in only])
        return
    scenes = tuple(scene for scene in (*SHIPPED, *OTHERS) if not only or scene[0] in only)
    cases, found = [case_of(scene) for scene in scenes], []
    for scene in scenes:
        found.append(taken_by_run(scene))
        print(*scene, *found[-1], flush=True)
    if not only:
        refit(cases, found)
    lines = []
    for (name, settings), case, (seconds, memory) in zip(scenes, cases, found, strict=True):
        told = cost_of(case)
        words = (f"{told.seconds:.3g}", f"{seconds:.3g}", f"{told.memory:.0f}", f"{memory:.0f}")
        lines.append((" ".join((name, *settings)), str(told.n_dofs), *words))
    if not only:
        with (HERE / "cost.csv").open("w", encoding="utf-8", newline="") as out:
            out.write(f"# {ABOUT}\n")
            csv.writer(out, lineterminator="\n").writerows([COLUMNS, *lines])
    print(*(" ".join(line) for line in (COLUMNS, *lines)), sep="\n")


def compare(commit: str, scenes: Sequence[Scene]) -> None:
    """Print what this program takes for all steps beside that of a commit."""
    command = ["git", "-C", str(ROOT), "archive", commit, "crackgrow", "cases"]
    packed = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout
    print("run", "taken_s", "then_s", "ratio", "taken_MiB", "then_MiB")
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(packed)) as files:
            files.extractall(folder, filter="data")
        for name, settings in scenes:
            words = ["-c", STEPS, f"cases/{name}.yaml", *settings, "output.figures=false", "output.frames=none"]
            (now, memory), (then, before) = (
                min(taken(words, program) for _ in range(ROUNDS)) for program in (ROOT, Path(folder))
            )
            told = f"{now:.3g} {then:.3g} {now / then:.2f} {memory:.0f} {before:.0f}"
            print(name, *settings, told, flush=True)


def refit(cases: Sequence[Case], found: Sequence[tuple[float, float]]) -> None:
    """Write constants that tell the seconds and MiB that were found, none negative, of least relative error."""
    terms = [terms_of(case, sizes_of(case)) for case in cases]
    file = ROOT / "crackgrow" / "plan" / "cost.json"
    table = json.loads(file.read_text(encoding="utf-8"))
    for k, value in enumerate(("seconds", "memory")):
        A, b = np.array([both[k] for both in terms]), np.array([both[k] for both in found])
        table[value] = [float(f"{constant:.3g}") for constant in nnls(A / b[:, None], np.ones(len(b)))[0]]
    file.write_text(f"{json.dumps(table, indent=1)}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
