"""Effectivity of the estimated error: prints a table, the estimate beside the true error.

The true error is the energy norm of the difference to the same scene on a much finer lattice. An error that falls with
the root of the spacing is measured 13 % too small if that is a fourth of the spacing, 30 % if it is half of it.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution
from crackgrow.run.loop import grow
from crackgrow.run.report import estimated_error
from crackgrow.run.scene import make_scene
from crackgrow.study.energy_distance import energy_distance
from tests.solving import solve_step

CASES = Path(__file__).parents[2] / "cases"
SUPPORT_15, SUPPORT_2 = "numerics.support=1.5", "numerics.support=2"

TABLE = (  # scene, growth steps, spacing of the reference, spacings, what each of the rows of settings sets
    ("compression30", 0, 0.3, (3, 2, 1.5, 1, 0.75), ((), (SUPPORT_15,), ("numerics.quadrature=3",))),
    ("compression30", 0, 0.3, (3, 1.5), (("numerics.quadrature=6",),)),
    ("compression30", 4, 0.3, (3, 2, 1.5, 1, 0.75), ((),)),
    ("compression30", 22, 0.3, (3, 2, 1.5, 1, 0.75), ((), (SUPPORT_15,))),
    ("edge_tension", 0, 0.3, (3, 2, 1.5, 1, 0.75), ((), (SUPPORT_15,))),
    ("slant_tension", 0, 0.5, (3, 2, 1.5, 1), ((), (SUPPORT_15,))),
    ("junction_static", 0, 0.5, (3, 2, 1.5, 1), ((), (SUPPORT_15,))),
    ("brazilian_disk", 0, 0.5, (3, 2, 1.5, 1), ((), (SUPPORT_15,))),
    ("en_echelon", 0, 0.4, (3, 2, 1.5), ((),)),
    ("flaw_and_hole", 0, 0.4, (3, 2, 1.5), ((),)),
    ("interface_friction04", 0, 0.00625, (0.1, 0.05, 0.04, 0.025), ((), (SUPPORT_15,))),
    ("block_foundation", 0, 0.025, (0.4, 0.2, 0.1, 0.05), ((), (SUPPORT_2,))),
)


def grown(case: Case, n_steps: int) -> tuple[GrowingCrack, ...]:
    """The cracks of a case after growth by its own settings."""
    cracks = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    if n_steps == 0:
        return cracks
    for result in grow(case):
        paths = result.cracks
    return tuple(
        replace(g, crack=replace(g.crack, points=path.points), steps=path.steps)
        for g, path in zip(cracks, paths, strict=True)
    )


def solved(name: str, spacing: float, settings: tuple[str, ...], cracks: tuple[GrowingCrack, ...]) -> StepSolution:
    case = load_case(CASES / f"{name}.yaml", (f"numerics.spacing={spacing}", *settings))
    return solve_step(make_scene(case), cracks, 1.0)


def main() -> None:
    """Print the table in Markdown, and how many rows are between a half and two."""
    print("| scene | growth steps | settings | spacing | unknowns | error | estimate | effectivity | cost |")
    print("|" + "---|" * 9)
    effectivities = []
    for name, n_steps, finest, spacings, settings in TABLE:
        quiet = (f"growth.steps={n_steps}", "output.frames=none", "output.figures=false") if n_steps else ()
        cracks = grown(load_case(CASES / f"{name}.yaml", quiet), n_steps)
        reference = solved(name, finest, (), cracks)
        for some in settings:
            for spacing in spacings:
                start = time.process_time()
                coarse = solved(name, spacing, some, cracks)
                middle = time.process_time()
                estimate = estimated_error(coarse).relative
                cost = (time.process_time() - middle) / (middle - start)
                error = energy_distance(coarse, reference).relative
                effectivities.append(estimate / error)
                print(
                    f"| {name} | {n_steps} | {', '.join(some)} | {spacing:g} | {coarse.cover.n_dofs} | {error:.3g} % | "
                    f"{estimate:.3g} % | {estimate / error:.2f} | {100 * cost:.0f} % |",
                    flush=True,
                )
    good = sum(0.5 <= effectivity <= 2.0 for effectivity in effectivities)
    print(f"\n{good} of {len(effectivities)} between 0.5 and 2, median {np.median(effectivities):.2f}")


if __name__ == "__main__":
    main()
