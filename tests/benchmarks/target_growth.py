"""Targets of the error of K in growth: what measuring it costs, and whether the bounds that are carried over hold.

python -m tests.benchmarks.target_growth    shipped scenes that grow, at 1 %: target_growth.md
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final
from unittest import mock

import numpy as np

from crackgrow.case import Case, load_case
from crackgrow.case.model import CriticalLoad
from crackgrow.run import grow, loop
from crackgrow.run.checkpoint import RunState, packed
from crackgrow.run.halvings import Accuracy
from crackgrow.run.judging import StepSolution
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from crackgrow.run.scene import Scene, make_scene
from tests.benchmarks.paths import HERE, ROOT
from tests.benchmarks.random_errors import QUIET, TRUTH, Stated, of_directions, of_K, of_load
from tests.benchmarks.tables import number, table

SCENES: Final = {
    "compression30": 22, "brazilian_disk": 10, "flaw_and_hole": 12, "two_flaws": 12, "two_flaws_overlapping": 10,
    "en_echelon": 8,
}  # fmt: skip
"""Steps of growth."""

TARGET: Final = "1 %"
EVERY: Final = 3  # steps of which one is held against the truth
REPEATS: Final = 3

WORDS = f"""# Targets in growth

Written by `python -m tests.benchmarks.target_growth`: shipped scenes for {TARGET}. Measured: the steps at which K was
held against that on other cells; between them the bound is carried over, and widened. Cost: CPU of all steps but the
first over that of the same steps on the same cells with nothing measured, medians of {REPEATS}. Errors: each tip of one
step in {EVERY}, in percent of the largest K; the truth is K of the same cracks under the same load for {TRUTH}. Beyond:
errors beyond the bound and what the truth states of itself. Bound over error is of errors that the truth is good enough
to tell.

Directions: the same of the kinks, in degrees, where the criterion sees a tip grow. Loads: the same of every step's
critical load, in percent, where the case asks for it.

To hold K against that on other cells takes as long as some steps in growth, which make anew only what has changed: one
measuring, over one step. Young wings are measured at the first step and once they are five or six times as long; where
flaws come near each other, or cells are joined, sooner.

Directions beyond their bounds are at tips that something lies closer to than the averaging radius, or of some tenths of
a degree: far outside of the cells at a tip both kinds of cells are as large by their distance from the tip, so that the
difference tells too little of the stress there.
"""


@dataclass(frozen=True, slots=True)
class Grown:
    """A run."""

    seconds: float  # CPU, of all steps but the first
    steps: tuple[StepSolution, ...]
    results: tuple[StepResult, ...]

    @property
    def known(self) -> list[Accuracy]:
        """What is known of each step."""
        return [step.accuracy for step in self.steps if step.accuracy is not None]


def case_of(name: str, *settings: str) -> Case:
    """A shipped case."""
    return load_case(ROOT / "cases" / f"{name}.yaml", ("numerics.spacing=auto", *settings, *QUIET))


def grown(case: Case) -> Grown:
    """Run a case."""
    steps: list[tuple[StepResult, StepSolution]] = []
    for step in solved_steps(case):
        if not steps:
            begin = time.process_time()
        steps.append(step)
    seconds = time.process_time() - begin
    results, solutions = zip(*steps, strict=True)
    return Grown(seconds, solutions, results)


def on_known_cells(case: Case, known: Sequence[Accuracy]) -> Grown:
    """The same run on the cells of each step, nothing measured."""
    numbers = iter(range(len(known)))

    def aimed(solution: StepSolution, *_: Any) -> StepSolution:
        return replace(solution, accuracy=known[next(numbers)])

    def cells_after(solution: StepSolution) -> object:
        number = next(at for at, each in enumerate(known) if each is solution.accuracy)
        return known[min(number + 1, len(known) - 1)].halvings

    def begun(one: Case) -> Scene:
        return make_scene(one).with_halvings(known[0].halvings)

    with (
        mock.patch.object(loop, "aimed", aimed),
        mock.patch.object(loop, "cells_after", cells_after),
        mock.patch.object(loop, "make_scene", begun),
    ):
        return grown(case)


def true(name: str, step: StepSolution, *settings: str) -> StepResult:
    """The truth for the cracks of a step."""
    case = case_of(name, f"numerics.accuracy={TRUTH}", "growth.steps=0", *settings)
    return next(grow(case, packed(RunState(0, step.cracks))))


def beside_truth(name: str, run: Grown) -> Iterator[tuple[StepResult, StepResult]]:
    """Some steps, each with the truth."""
    for result, step in list(zip(run.results, run.steps, strict=True))[EVERY - 1 :: EVERY]:
        yield result, true(name, step, f"loading={{history: [{step.state.factor!r}]}}")


def of_loads(name: str, run: Grown) -> Iterator[Stated]:
    """The critical load of each step, if there is any."""
    for result, step in zip(run.results, run.steps, strict=True):
        if isinstance(step.scene.case.loading, CriticalLoad):
            yield from (Stated(name, TARGET, "load", *each) for each in of_load(result, true(name, step)))


def row_of(name: str, n_steps: int) -> list[str]:
    """A row of the table."""
    case = case_of(name, f"numerics.accuracy={TARGET}", f"growth.steps={n_steps}")
    run = grown(case)
    pairs = [(grown(case).seconds, on_known_cells(case, run.known).seconds) for _ in range(REPEATS)]
    whole, alone = np.median(pairs, axis=0).tolist()
    steps = list(beside_truth(name, run))
    of_tips = [Stated(name, TARGET, "K", *each) for step, truth in steps for each in of_K(step, truth)]
    turned = [Stated(name, TARGET, "direction", *each) for step, truth in steps for each in of_directions(step, truth)]
    loads = list(of_loads(name, run))
    told = [tip.bound / tip.error for tip in of_tips if tip.error > 3.0 * tip.own]
    n, measured = len(run.steps) - 1, [step for step, known in enumerate(run.known) if known.age == 0]
    return [
        name,
        str(n),
        ", ".join(map(str, measured)),
        number(whole / alone),
        number((whole / alone - 1.0) * n / max(sum(step > 0 for step in measured), 1)),
        str(len(of_tips)),
        str(sum(not tip.holds for tip in of_tips)),
        number(max(tip.error for tip in of_tips)),
        number(max(tip.bound for tip in of_tips)),
        number(float(np.median(told))) if told else "",
        str(len(turned)),
        str(sum(not tip.holds for tip in turned)),
        number(max((tip.error for tip in turned), default=np.nan)),
        str(len(loads)),
        str(sum(not load.holds for load in loads)),
        number(max((load.error for load in loads), default=np.nan)),
    ]


def main() -> None:
    """Measure and write."""
    rows = []
    for name, steps in SCENES.items():
        rows.append(row_of(name, steps))
        print(*rows[-1], sep=", ", flush=True)
    header = (
        "scene", "steps", "measured", "cost", "one measuring, over one step", "errors", "beyond", "largest error, %",
        "largest bound, %", "bound over error in the median", "directions", "beyond", "largest error, degrees",
        "loads", "beyond", "largest error, %",
    )  # fmt: skip
    (HERE / "target_growth.md").write_text(f"{WORDS}\n{table(header, rows)}")


if __name__ == "__main__":
    main()
