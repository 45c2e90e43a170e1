"""The target of the error of K, asked of scenes whose K is known: what came of it, and what the bound was worth.

python -m tests.benchmarks.targets              all pairs of a scene and a target: targets.csv and targets.md
python -m tests.benchmarks.targets --missing    those that targets.csv does not have
python -m tests.benchmarks.targets --only grown those of scenes whose name has the word
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import yaml

from crackgrow.blas import THREAD_SETTINGS, single_threaded
from crackgrow.case import Case, load_case
from crackgrow.run.caution import Cause
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from tests.benchmarks.paths import HERE, ROOT
from tests.benchmarks.tables import number, table
from tests.benchmarks.target_scenes import SCENES, Truth

QUIET = ("output.frames=none", "output.figures=false", "output.report=false")
TABLE, TEXT = HERE / "targets.csv", HERE / "targets.md"
LONGEST = 300.0  # s, of a pair
FINEST = 0.001  # target whose K is the truth of scenes without any
WORDS = """# The target of the error of K

Written by `python -m tests.benchmarks.targets`: `numerics.accuracy` in percent, asked of scenes whose K is known.
Error: the worst tip, K_I and K_II together, over the largest K; bound: the same of what the run states; told: the run
warned that it does not meet the target. Truth: exact solutions, tables in tests/verification/references, or, where
there is none, K of the same scene for 0.1 %. CPU is that of all rounds. Bound over error is given where the error is
three times what the truth is good to.

Beyond the target is the closed kink alone, and the run says so: its cells reach the least side at the pressed corner,
where K does not get better. Bounds far above the error are those of straight cracks, whose field the tip functions
have: there what was fitted, half a percent of K at least, counts too much.
"""
JUDGED = 3.0  # times what the truth is good to: smaller errors say nothing of the bound


@dataclass(frozen=True, slots=True)
class Pair:
    """A scene and a target, solved. Errors are shares of the largest K."""

    scene: str
    target: float
    error: float  # largest of a tip, K_I and K_II together; nan where there was no solution in time
    bound: float  # largest of a tip
    told: int  # whether the run warned that it does not meet the target
    unknowns: int
    seconds: float  # CPU
    share: float  # of the CPU time that the last solve has cost

    @property
    def truth_within(self) -> float:
        """What the truth is good to."""
        return WITHIN[self.scene]

    @property
    def effectivity(self) -> float:
        """Bound over error; nan where the truth is not good enough to say."""
        return self.bound / self.error if self.error > JUDGED * self.truth_within else float("nan")


WITHIN = {name: entry.make().within for name, entry in SCENES.items()}


def case_of(scene: str, target: float) -> Case:
    """The scene as a case."""
    known = {**SCENES[scene].make().case, "numerics": {"accuracy": target}}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(yaml.safe_dump(known))
        return load_case(file, QUIET)


def solved(scene: str, target: float) -> tuple[StepResult, float, float]:
    """The first step, the CPU seconds that it took, and the share of them of the last solve."""
    case, begin = case_of(scene, target), time.process_time()
    with single_threaded():
        step, solution = next(solved_steps(case))
    spent = time.process_time() - begin
    last = {**solution.configuration.seconds, "contact": solution.state.seconds}
    return step, spent, sum(last.values()) / spent


def measured(scene: str, target: float, truth: Truth) -> Pair:
    """The pair, whose K should be `truth`."""
    step, seconds, share = solved(scene, target)
    largest = max(float(np.hypot(*K)) for K in truth.values())
    off, bounds = [], []
    for tip in step.tips:
        K_I, K_II = truth[tip.crack, tip.tip]
        off.append(float(np.hypot(tip.K_I - K_I, abs(tip.K_II) - abs(K_II))))
        bounds.append(max(tip.K_I_error, tip.K_II_error))
    told = any(caution.cause is Cause.TARGET for caution in step.cautions)
    error, bound = max(off) / largest, max(bounds) / largest
    return Pair(scene, target, error, bound, int(told), step.n_dofs, seconds, share)


def truth_of(scene: str) -> Truth:
    """K of a scene."""
    known = SCENES[scene].make().truth
    return K_of(solved(scene, FINEST)[0]) if known is None else known


def K_of(step: StepResult) -> Truth:
    """K of all tips."""
    return {(tip.crack, tip.tip): (tip.K_I, tip.K_II) for tip in step.tips}


def in_a_process(scene: str, targets: Sequence[float]) -> Iterator[Pair]:
    """The pairs of a scene, each given up after some time; the truth is solved with the first."""
    environment = {**os.environ, **dict.fromkeys(THREAD_SETTINGS, "1")}
    for target in targets:
        command = [sys.executable, "-m", "tests.benchmarks.targets", "--pair", scene, str(target)]
        try:
            done = subprocess.run(
                command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=LONGEST
            )
            yield Pair(**json.loads(done.stdout))
        except (subprocess.TimeoutExpired, json.JSONDecodeError):
            nan = float("nan")
            yield Pair(scene, target, nan, nan, 0, 0, nan, nan)


def read() -> list[Pair]:
    """What was measured before."""
    if not TABLE.is_file():
        return []
    with TABLE.open(newline="") as file:
        found = list(csv.DictReader(file))
    kinds = {field.name: {"str": str, "int": int, "float": float}[str(field.type)] for field in fields(Pair)}
    return [Pair(**{name: kinds[name](value) for name, value in row.items()}) for row in found]


def write(pairs: Sequence[Pair]) -> None:
    """The table as numbers."""
    order = list(SCENES)
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Pair)], lineterminator="\n")
        writer.writeheader()
        for pair in sorted(pairs, key=lambda pair: (order.index(pair.scene), -pair.target)):
            row = asdict(pair)
            writer.writerow(
                {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()}
            )


def text_of(pairs: Sequence[Pair]) -> str:
    """The table, and what it comes to."""
    solved = [pair for pair in pairs if pair.unknowns]
    lines = [
        [
            pair.scene,
            SCENES[pair.scene].kind,
            f"{100.0 * pair.target:g}",
            f"{pair.unknowns:,}",
            f"{pair.seconds:.1f}",
            number(100.0 * pair.error),
            number(100.0 * pair.bound),
            number(pair.effectivity),
            "yes" if pair.told else "",
        ]
        for pair in solved
    ]
    header = ("scene", "kind", "target, %", "unknowns", "CPU s", "error, %", "bound, %", "bound over error", "told")
    return f"{WORDS}\n{summary_of(solved)}\n{table(header, lines)}"


def summary_of(pairs: Sequence[Pair]) -> str:
    """How often targets are met and bounds hold, in lines."""
    n, judged = len(pairs), np.array([pair.effectivity for pair in pairs if not np.isnan(pair.effectivity)])
    met = sum(pair.error <= pair.target for pair in pairs)
    silent = sum(pair.error > pair.target and not pair.told for pair in pairs)
    held = sum(pair.bound >= pair.error for pair in pairs)
    third = float(np.mean((judged >= 1.5) & (judged <= 6.0)))
    rows = [
        ["pairs", str(n)],
        ["true error within the target", f"{met}"],
        ["beyond the target without a warning", f"{silent}"],
        ["bound at least the true error", f"{held}"],
        ["pairs whose truth is good enough to judge the bound", str(len(judged))],
        ["of them bound over error in the median", f"{np.median(judged):.2g}"],
        ["of them bound within a half and twice the error", f"{100 * np.mean((judged >= 0.5) & (judged <= 2)):.0f} %"],
        ["of them a third of the bound within a half and twice the error", f"{100 * third:.0f} %"],
    ]
    return table(("what", "number"), rows)


def main() -> None:
    """Measure what is asked for, and write it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--missing", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--pair", nargs=2)
    arguments = parser.parse_args()
    if arguments.pair:
        scene, target = arguments.pair
        print(json.dumps(asdict(measured(scene, float(target), truth_of(scene)))))
        return
    if arguments.write:
        TEXT.write_text(text_of(read()))
        return
    before = read()
    kept = before if arguments.missing else [pair for pair in before if arguments.only not in pair.scene]
    known = {(pair.scene, pair.target) for pair in kept}
    for scene, entry in SCENES.items():
        wanted = [target for target in entry.targets if arguments.only in scene and (scene, target) not in known]
        for pair in in_a_process(scene, wanted):
            kept.append(pair)
            write(kept)
            print(pair, flush=True)
    TEXT.write_text(text_of(read()))


if __name__ == "__main__":
    main()
