"""The errors that runs state on scenes at random: of K, of directions of growth, of critical loads.

python -m tests.benchmarks.random_errors                       twenty scenes: random_errors.md
python -m tests.benchmarks.random_errors --seed 3 --scenes 5   these five, printed
"""

from __future__ import annotations

import argparse
import math
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from crackgrow.blas import single_threaded
from crackgrow.case import Case, load_case
from crackgrow.errors import CrackgrowError
from crackgrow.run import grow
from crackgrow.run.caution import Cause
from crackgrow.run.result import StepResult, TipResult
from tests.benchmarks.paths import HERE
from tests.benchmarks.tables import number, table
from tests.stability.growing_scenes import KINDS, growing_scene
from tests.stability.random_scenes import text_of as document_of

SETTINGS: Final = ("draft", "standard", "fine", "1 %")
TRUTH: Final = "0.1 %"
GOOD: Final = 0.02
"""Of the largest K: where the truth's own bound is above, K is practically nothing and no scene to judge by."""
NEAR: Final = 0.7
"""Criticality over that of the tip that sets the load: directions of tips below are not asked for."""
FIRST, MANY = 300, 20
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")
WORDS = f"""# The errors that runs state, on scenes at random

Written by `python -m tests.benchmarks.random_errors`: {MANY} of the growing scenes of tests/stability, at the first
critical load, by name and for 1 %. Nothing was chosen by them but that of the first ten directions and loads are three
times off what other cells tell. The truth is the same scene for {TRUTH}, with the error that it states of itself:
within the bound is what is not beyond both. Scenes are left out that have no solution, no critical load, or a largest K
that is practically nothing. K and directions: each tip; K under the truth's load, in percent of the largest; directions
in degrees.
"""


@dataclass(frozen=True, slots=True)
class Stated:
    """An error and what a run and the truth state of it."""

    scene: str
    setting: str
    what: str
    error: float
    bound: float
    own: float  # of the truth

    @property
    def holds(self) -> bool:
        """Whether the bound does."""
        return self.error <= self.bound + self.own


def case_of(seed: int, accuracy: str, loading: Any = "critical", steps: int = 0) -> Case:
    """The scene with an accuracy, loading and number of steps; each of them starts unloaded."""
    scene = {**growing_scene(seed), "loading": loading, "numerics": {"accuracy": accuracy}}
    scene["growth"]["steps"] = steps
    scene["growth"].pop("unload_between_steps", None)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(document_of(scene))
        return load_case(file, QUIET)


def solved(seed: int, accuracy: str, loading: Any = "critical") -> StepResult:
    """The scene on the cells of an accuracy. Raises CrackgrowError where there is no such solution."""
    with single_threaded():
        return next(grow(case_of(seed, accuracy, loading)))


def stated(seed: int) -> Iterator[Stated]:
    """What a scene has to tell, nothing where it has no truth."""
    if "growth" not in growing_scene(seed):
        return
    try:
        truth = solved(seed, TRUTH)
        factor = {"history": [truth.load_factor]}
        others = {setting: (solved(seed, setting), solved(seed, setting, factor)) for setting in SETTINGS}
    except CrackgrowError:
        return
    name = f"{seed}, {KINDS[seed % len(KINDS)]}"
    for setting, (critical, step) in others.items():
        if not any(tip.criticality - 1.0 > Cause.JUMP.limit for tip in truth.tips):  # elsewhere bonds hold at that load
            yield from (Stated(name, setting, "K", *of) for of in of_K(step, truth))
        yield from (Stated(name, setting, "direction", *of) for of in of_directions(critical, truth))
        yield from (Stated(name, setting, "load", *of) for of in of_load(critical, truth))


Errors = Iterator[tuple[float, float, float]]
"""An error, its bound, and that of the truth."""


def of_K(step: StepResult, truth: StepResult) -> Errors:
    """Of each tip, percent of the largest K: under the same load."""
    largest = max((float(np.hypot(tip.K_I, tip.K_II)) for tip in truth.tips), default=math.nan)
    for tip, true in zip(step.tips, truth.tips, strict=True):
        error, bound, own = np.array([np.hypot(tip.K_I - true.K_I, tip.K_II - true.K_II), _bound(tip), _bound(true)])
        if own <= GOOD * largest:
            yield 100.0 * error / largest, 100.0 * bound / largest, 100.0 * own / largest


def of_directions(step: StepResult, truth: StepResult) -> Errors:
    """Of each tip that is near to growth by the same branch, degrees."""
    for tip, true in zip(step.tips, truth.tips, strict=True):
        if tip.criticality > NEAR and true.criterion == tip.criterion:
            yield abs(tip.kink_deg - true.kink_deg), tip.kink_error_deg, true.kink_error_deg


def of_load(step: StepResult, truth: StepResult) -> Errors:
    """Of the critical load, percent, where both state an error."""
    bounds = (step.load_factor_error, truth.load_factor_error)
    if np.isfinite(bounds).all():
        yield 100.0 * abs(step.load_factor / truth.load_factor - 1.0), *bounds


def _bound(tip: TipResult) -> float:
    return max(tip.K_I_error, tip.K_II_error)


def text_of(words: str, found: Sequence[Stated]) -> str:
    """What it comes to, and where bounds do not hold."""
    lines = []
    for what in dict.fromkeys(one.what for one in found):
        for setting in dict.fromkeys(one.setting for one in found):
            some = [one for one in found if (one.what, one.setting) == (what, setting)]
            seen = [one.bound / one.error for one in some if one.error > 3.0 * one.own]
            lines.append([
                what, setting, str(len(some)), str(sum(not one.holds for one in some)),
                number(100.0 * sum(one.holds for one in some) / max(len(some), 1)),
                number(statistics.median(one.error for one in some) if some else math.nan),
                number(statistics.median(seen) if seen else math.nan),
            ])  # fmt: skip
    header = ("what", "accuracy", "n", "beyond", "holds, %", "error in the median", "bound over error in the median")
    beyond = [
        [one.scene, one.setting, one.what, number(one.error), number(one.bound), number(one.own)]
        for one in found
        if not one.holds
    ]
    scenes = len({one.scene for one in found})
    return (
        f"{words}\n{scenes} scenes are left. Bound over error is of errors that the truth is good enough to tell.\n\n"
        f"{table(header, lines)}\nBeyond:\n\n"
        f"{table(('scene', 'accuracy', 'what', 'error', 'bound', 'of the truth'), beyond)}"
    )


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=FIRST)
    parser.add_argument("--scenes", type=int, default=MANY)
    given = parser.parse_args()
    found: list[Stated] = []
    for seed in range(given.seed, given.seed + given.scenes):
        mine = list(stated(seed))
        print(seed, len(mine), *(f"{one.setting} {one.what} {one.error:.3g} of {one.bound:.3g}" for one in mine
                                 if not one.holds), sep=", ", flush=True)  # fmt: skip
        found += mine
    if (given.seed, given.scenes) == (FIRST, MANY):
        (HERE / "random_errors.md").write_text(text_of(WORDS, found))
    else:
        print(text_of(WORDS, found))


if __name__ == "__main__":
    main()
