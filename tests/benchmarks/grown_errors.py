"""The errors of K that runs state after growth, on scenes at random.

python -m tests.benchmarks.grown_errors                       twelve scenes: grown_errors.md
python -m tests.benchmarks.grown_errors --seed 3 --scenes 5   these five, printed
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Final

from crackgrow.errors import CrackgrowError
from crackgrow.run.checkpoint import RunState, packed
from crackgrow.run.loop import solved_steps
from tests.benchmarks.paths import HERE
from tests.benchmarks.random_errors import TRUTH, Stated, case_of, of_K, text_of
from tests.stability.growing_scenes import KINDS, growing_scene

SETTINGS: Final = ("standard", "1 %")
STEPS: Final = 6
ASKED: Final = (3, 6)
FIRST, MANY = 420, 12
WORDS = f"""# The errors of K that runs state after growth

Written by `python -m tests.benchmarks.grown_errors`: {MANY} of the growing scenes of tests/stability at critical
loads, after {ASKED[0]} and {ASKED[1]} steps. Nothing was chosen by them. The truth is K of the cracks that the run has
come to, under its load, for {TRUTH}, with the error that it states of itself: within the bound is what is not beyond
both. What was measured of the error steps before counts as the run states it. Scenes are left out that have no growth,
no critical load, or a largest K that is practically nothing. Each tip, in percent of the largest K.
"""


def stated(seed: int, setting: str) -> Iterator[Stated]:
    """What a run states of its tips after growth, as far as it comes, and what these are off by."""
    name = f"{seed}, {KINDS[seed % len(KINDS)]}"
    try:
        for step, solution in solved_steps(case_of(seed, setting, steps=STEPS)):
            if step.step in ASKED and not any(solution.jumps):  # where bonds break they hold elsewhere at that load
                known = packed(RunState(0, solution.cracks))
                case = case_of(seed, TRUTH, {"history": [solution.state.factor]})
                truth, _ = next(solved_steps(case, known))
                yield from (Stated(name, setting, f"K, step {step.step}", *of) for of in of_K(step, truth))
    except CrackgrowError as error:
        print(f"{name}, {setting}: {error}", flush=True)


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=FIRST)
    parser.add_argument("--scenes", type=int, default=MANY)
    given = parser.parse_args()
    seeds = [seed for seed in range(given.seed, given.seed + given.scenes) if "growth" in growing_scene(seed)]
    found = []
    for seed in seeds:
        for setting in SETTINGS:
            mine = list(stated(seed, setting))
            print(seed, setting, len(mine), *(f"{one.what} {one.error:.3g} of {one.bound:.3g}" for one in mine
                                              if not one.holds), sep=", ", flush=True)  # fmt: skip
            found += mine
    text = text_of(WORDS, found)
    if (given.seed, given.scenes) == (FIRST, MANY):
        (HERE / "grown_errors.md").write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
