"""Stated errors against truths: scenes x accuracies -> error, expected, bound, unknowns, CPU, of every quantity.

    python -m tests.benchmarks.errors [--accuracy standard ...] [--wings SEED ...] [--write] [SCENE ...]

With --write tests/benchmarks/errors.md is made anew, else all is printed.

Scenes are those of `target_scenes`, whose K is exact or from references, shipped cases, and cracks with random wings.
Other truths are of cells three levels finer at features and one in theta, for the cracks and the load of the step, and
good to what they differ by from two levels. The first and the last step of a run count, the tenth at most.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from crackgrow.accuracy.companion import BOUND, EXPECTED, Errors, Quantities, errors_of
from crackgrow.case import Case
from crackgrow.case.accuracy import target_of
from crackgrow.case.model import CriticalLoad
from crackgrow.errors import CrackgrowError
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.layout import cover_of
from crackgrow.run.loading import LoadsInTurn, NextStepSolver
from crackgrow.run.loop import solved_steps
from crackgrow.run.target import quantities
from tests.benchmarks.target_scenes import SCENES, Known, Truth
from tests.scenes import plate, shipped_case

HERE = Path(__file__).parent

MOST_STEPS = 10

ROUND_OFF = 1e-9
"""Of the largest value: reactions that equilibrium alone decides differ by no more on any mesh, and do not count."""

FINER = 2, 3
"""Levels; the larger one is the truth."""

MOST_UNKNOWNS = 150_000
"""Of a truth: there is none for a step that would need more."""

SHIPPED = (
    "brazilian_disk", "compression45", "confined30", "cyclic_friction", "edge_tension", "flaw_and_hole",
    "interface_friction04", "junction_static", "slant_tension", "tension0", "two_flaws",
    "two_flaws_overlapping",
)  # fmt: skip

HEAD = ("scene", "accuracy", "quantity", "error, %", "truth good to", "expected", "at most", "unknowns", "CPU s")


@dataclass(frozen=True, slots=True)
class Row:
    """A quantity of a step; shares of its largest value in the step, directions in rad."""

    scene: str
    quantity: str
    error: float
    within: float  # what the truth is good to
    D: float
    accuracy: str
    n_dofs: int
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether the error is within its bound, as far as the truth goes."""
        return self.error <= BOUND * self.D + self.within

    @property
    def cells(self) -> tuple[str, ...]:
        """The row as words, under HEAD."""
        parts = (f"{100 * part:.3f}" for part in (self.error, self.within, self.D / EXPECTED, BOUND * self.D))
        return (self.scene, self.accuracy, self.quantity, *parts, f"{self.n_dofs:,}", f"{self.seconds:.2f}")


def wings(seed: int, count: int = 40) -> Iterator[tuple[str, dict[str, Any]]]:
    """Random kinked cracks with one to three segments to a wing; closed, open or partly open."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        angle, friction = math.radians(rng.uniform(20, 70)), float(rng.choice([0, 0.1, 0.3, 0.6]))
        lateral, size = float(rng.choice([0, 0, 0.05, 0.15, 0.3])), float(rng.choice([4, 6, 10, 20]))
        length, parts = float(np.exp(rng.uniform(math.log(0.15), math.log(1.5)))), int(rng.integers(1, 4))
        end = np.array([math.cos(angle), math.sin(angle)])
        wing, turn = [end.copy()], math.pi / 2 + rng.uniform(-0.35, 0.35)
        for _ in range(parts):
            end = end + length / parts * np.array([math.cos(turn), math.sin(turn)])
            wing.append(end.copy())
            turn += rng.uniform(-0.25, 0.25)
        points = 10.0 * np.vstack([-np.array(wing)[::-1], wing])
        case = plate(np.round(points, 6).tolist(), 10.0 * size, 100.0, 100.0 * lateral, friction)
        yield f"wings {seed}.{number}: friction {friction:g}, lateral {lateral:g}", case


def all_scenes(seeds: Sequence[int]) -> Iterator[tuple[str, Callable[[], Known]]]:
    yield from SCENES.items()
    yield from ((name, partial(Known, name)) for name in SHIPPED)
    yield from ((name, partial(Known, scene)) for seed in seeds for name, scene in wings(seed))


def case_of(scene: str | dict[str, Any], accuracy: str) -> Case:
    """The case of a document, or a shipped one of few steps."""
    if not isinstance(scene, str):
        return Case.from_dict({**scene, "numerics": {"accuracy": accuracy}})
    case = shipped_case(scene, [f"numerics.accuracy={accuracy}", "numerics.spacing=auto"])
    if case.growth is None:
        return case
    return replace(case, growth=replace(case.growth, steps=min(case.growth.steps, MOST_STEPS)))


def rows_of(name: str, known: Known, accuracy: str) -> Iterator[Row]:
    """The quantities of a scene in its first step and in its last one."""
    begun, steps = time.process_time(), []
    for result, solution in solved_steps(case_of(known.case, accuracy)):
        make = partial(Row, accuracy=accuracy, n_dofs=result.n_dofs, seconds=time.process_time() - begun)
        if known.truth is not None:
            truth = replace(quantities(solution, 1.0), K=_in_turn(solution, known.truth))
            yield from _rows(partial(make, name), solution, _off(solution, truth), known.within)
            return
        steps.append((make, solution))
        begun = time.process_time()
    for number in dict.fromkeys((0, len(steps) - 1)):
        make, solution = steps[number]
        before = steps[number - 1][1] if number else None
        yield from _against_finer(partial(make, f"{name}, step {number}"), solution, before, number)


def _in_turn(solution: StepSolution, K: Truth) -> np.ndarray:
    """Known K (n, 2) tip by tip, nan where it is not known; of K_II the size alone is known."""
    found = []
    for (number, at_end), tip in zip(solution.cover.tip_ends, solution.tips, strict=True):
        known = K.get((str(solution.cover.cracks[number].name), "end" if at_end else "start"), (math.nan, math.nan))
        found.append((known[0], math.copysign(known[1], tip.K[1])))
    return np.array(found)


def _off(solution: StepSolution, truth: Quantities, here: Quantities | None = None) -> Errors:
    """What a solution, or the quantities of another one, are off by, over the largest values of the truth."""
    here = here or quantities(solution, solution.factor)
    nothing = np.zeros(len(here.ends))
    off = errors_of(solution.scene.grading, replace(here, spread=nothing, unresolved=nothing), truth)
    return replace(off, largest=max(float(np.nanmax(np.hypot(*truth.K.T), initial=0.0)), here.small["K"]))


def _against_finer(
    make: Callable[..., Row], solution: StepSolution, before: StepSolution | None, number: int
) -> Iterator[Row]:
    """The quantities of a step against those on finer cells; none where there is no solution on such cells."""
    if solution.errors is None:
        return
    try:
        near, truth = (_on_finer(solution, before, number, levels) for levels in FINER)
    except (CrackgrowError, MemoryError) as error:
        print(f"no truth: {error}", flush=True)
        return
    if list(solution.cover.tip_ends) == list(near.ends) == list(truth.ends):
        yield from _rows(make, solution, _off(solution, truth), _off(solution, truth, near))


def _on_finer(solution: StepSolution, before: StepSolution | None, number: int, levels: int) -> Quantities:
    """The quantities of a step on cells some levels finer. Raises as solutions do, MemoryError beyond the limit."""
    scene, cracks = solution.scene, solution.cracks
    deeper = tuple(scene.grading.level(crack) + levels for crack in range(len(cracks)))
    finer = scene.with_grading(replace(scene.grading, cracks=deeper, rest=scene.grading.rest + 1))
    if (n := cover_of(finer, cracks).n_dofs) > MOST_UNKNOWNS:
        raise MemoryError(f"{n} unknowns")
    if scene.case.growth is not None:
        return quantities(*NextStepSolver(cracks, before).companion(finer, solution))
    there = LoadsInTurn(finer, cracks).solution(number)
    return quantities(there, there.factor)


def _rows(make: Callable[..., Row], solution: StepSolution, off: Errors, apart: Errors | float) -> Iterator[Row]:
    """A row for each crack's K and direction, and for each other quantity that is known.

    They are off the truth by `off`; truths are `apart`, or K is within so much of the largest.
    """
    stated, names = solution.errors, [str(crack.name) for crack in solution.cover.cracks]
    assert stated is not None
    exact, near = (apart, None) if isinstance(apart, float) else (0.0, apart)
    for crack, tip in {crack: tip for tip, (crack, _) in enumerate(off.ends)}.items():
        within = exact if near is None else near.K[tip] / off.largest
        yield make(f"K of {names[crack]}", off.K[tip] / off.largest, within, stated.K[tip] / off.largest)
        if near is not None:
            yield make(f"direction of {names[crack]}", off.kinks[tip], near.kinks[tip], stated.kinks[tip])
    if near is None:
        return
    for goal in off.shares:
        if goal != "load_factor" or isinstance(solution.scene.case.loading, CriticalLoad):
            yield make(goal, off.shares[goal], near.shares[goal], stated.shares[goal])


def told(rows: Sequence[Row]) -> Iterator[str]:
    """What the rows say of an accuracy, by quantity and together."""
    for accuracy in dict.fromkeys(row.accuracy for row in rows):
        mine = [row for row in rows if row.accuracy == accuracy]
        n_scenes, dofs = len({row.scene.split(", step")[0] for row in mine}), [row.n_dofs for row in mine]
        yield f"`{accuracy}`: {n_scenes} scenes; {np.median(dofs):,.0f} unknowns in the median, {max(dofs):,} at most"
        met = [row.error <= target_of(accuracy) + row.within for row in mine if row.quantity.startswith("K of")]
        yield f"  - K is within {100 * target_of(accuracy):g} %, the target, of {sum(met)} of {len(met)} cracks"
        for kind in (*dict.fromkeys(row.quantity.split(" of ")[0] for row in mine), ""):
            some = [row for row in mine if row.quantity.startswith(kind)]
            ratio = np.quantile([row.D / max(row.error, ROUND_OFF) for row in some], [0.05, 0.5, 0.95])
            yield (
                f"  - {kind or 'all'}: {len(some)}; the bound holds for {np.mean([row.holds for row in some]):.1%}; "
                f"error {100 * np.median([row.error for row in some]):.3f} % in the median; D / error {ratio[1]:.2g} "
                f"in the median, {ratio[0]:.2g} to {ratio[2]:.2g} for nine of ten"
            )


def main(given: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("only", nargs="*", metavar="SCENE", help="scenes whose names contain one of these")
    parser.add_argument("--accuracy", nargs="+", default=["standard"])
    parser.add_argument("--wings", nargs="*", type=int, default=[], metavar="SEED", help="of cracks with random wings")
    parser.add_argument("--write", action="store_true", help="write errors.md")
    asked: Any = parser.parse_args(given)
    found: list[Row] = []
    for name, make in all_scenes(asked.wings):
        if asked.only and not any(part in name for part in asked.only):
            continue
        for accuracy in asked.accuracy:
            try:
                mine = [row for row in rows_of(name, make(), accuracy) if ROUND_OFF < row.error + row.D < math.inf]
                found += mine
            except CrackgrowError as error:
                print(f"{name}, {accuracy}: {error}", flush=True)
                continue
            for row in mine:
                print(*row.cells, "" if row.holds else "BEYOND", sep=" | ", flush=True)
    print("\n".join(told(found)))
    if asked.write:
        (HERE / "errors.md").write_text(page(found), encoding="utf-8")


def page(rows: Sequence[Row]) -> str:
    """errors.md: what the rows say together, and what is beyond its bound."""
    beyond = [row for row in rows if not row.holds]
    return (
        "# Stated errors, held against truths\n\n"
        "Written by `python -m tests.benchmarks.errors --write`, whose head says what scenes and truths these are.\n"
        "K_I and K_II together, slip, reactions and load factors are over their largest value in the step, directions\n"
        "in percent of a radian; of a crack the worse tip counts. Expected is D / 1.6, at most 3 D.\n\n"
        + "".join(f"{'' if line.startswith('  ') else '- '}{line}\n" for line in told(rows))
        + f"\n## Beyond their bound: {len(beyond)}\n\n"
        + "".join(f"| {' | '.join(line)} |\n" for line in (HEAD, ["---"] * len(HEAD), *(row.cells for row in beyond)))
    )


if __name__ == "__main__":
    main()
