"""K after growth against its cost: cells of one size, cells for an accuracy, and graded finite elements.

    python -m tests.benchmarks.graded       graded.csv and graded.svg beside this file

CPU seconds of one thread, the least of some solves, as multiples of the uniform solve at 1.5 mm of the same scene.
Finite elements were measured beside that solve by an earlier commit, which is run again: so they keep their scale.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from crackgrow.blas import single_threaded
from crackgrow.run import grow
from tests.benchmarks.beside import AGAINST, Scene, beside, program_of
from tests.benchmarks.tables import HERE, ROOT, number, write_csv
from tests.benchmarks.target_scenes import wings
from tests.verification.solutions import case_of, rows

SCENES = ("young30", "grown30")
UNIFORM = ("3 mm", "1.5 mm", "0.75 mm", "0.375 mm")
TARGETS = ("draft", "standard", "fine")
BESIDE = "1.5 mm"
REPETITIONS = 5
COSTS, ERRORS = (0.5, 1, 2, 4, 8), (0.03, 0.1, 0.3, 1, 3, 10)  # where axes have ticks
FINITE_ELEMENTS = ("quadratic triangles graded to the tips", "quadratic triangles graded to tips and kinks")


@dataclass(frozen=True, slots=True)
class Point:
    """One solve."""

    scene: str
    cells: str
    unknowns: int
    cost: float  # seconds, then over those of the uniform solve at 1.5 mm
    error: float  # percent of K_I, the larger of both components


def measured(scene: str, cells: str) -> Point:
    """A solve of the specimen with wings, its least time, and what it misses; its error is not measured by the way."""
    known, numerics = wings(scene), {"accuracy": cells} if cells in TARGETS else {"spacing": cells}
    case = case_of({**known.case, "numerics": numerics})
    case = replace(case, numerics=replace(case.numerics, auto_rule=None))
    seconds = []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        step = next(grow(case))
        seconds.append(time.process_time() - begin)
    off = []
    for tip in step.tips:
        K_I, K_II = (known.truth or {})[tip.crack, tip.tip]
        off.append(max(abs(tip.K_I - K_I), abs(tip.K_II - K_II)) / K_I)
    return Point(scene, cells, step.n_dofs, min(seconds), 100.0 * max(off))


def of_finite_elements(scene: str, then: float) -> Iterator[Point]:
    """The solves of another program, in seconds; `then`: of the uniform one by the commit, as it is measured now."""
    found = rows("fe_cost.csv")
    (beside_them,) = (row for row in found if row["scene"] == f"{scene} at {BESIDE} uniform, by commit {AGAINST}")
    for row in found:
        if row["scene"] == scene:
            cost = float(row["cpu_seconds"]) / float(beside_them["cpu_seconds"]) * then
            yield Point(scene, row["elements"], int(row["unknowns"]), cost, float(row["error_K_percent"]))


def all_points() -> list[Point]:
    """Every solve, the costs over those of the uniform one at 1.5 mm."""
    found: list[Point] = []
    with program_of(AGAINST) as program:
        for scene in SCENES:
            points = [[float(row["x_mm"]), float(row["y_mm"])] for row in rows(f"{scene}_path.csv")]
            path = f"cracks.flaw.path={{points: {points}}}"
            uniform = Scene(scene, "compression30", (path, f"numerics.spacing={BESIDE}", "growth.steps=0"))
            then, now = (timed.first for timed in beside(uniform, (program, ROOT), REPETITIONS))
            own = [measured(scene, cells) for cells in (*UNIFORM, *TARGETS)]
            (least,) = (point.cost for point in own if point.cells == BESIDE)
            own += of_finite_elements(scene, then / now * least)
            found += [replace(point, cost=point.cost / least) for point in own]
    return found


def draw(points: Sequence[Point], path: Path) -> None:
    """Error over cost, a panel for each scene."""
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    kinds = [("one size", UNIFORM, "o-"), ("halved", TARGETS, "s-")]
    kinds += [(name, (name,), style) for name, style in zip(FINITE_ELEMENTS, ("^--", "v--"), strict=True)]
    for scene, axes in zip(SCENES, figure.subplots(1, len(SCENES), sharey=True), strict=True):
        for label, names, style in kinds:
            own = [p for p in points if p.scene == scene and p.cells in names]
            cost, error = np.array(sorted((p.cost, p.error) for p in own)).T
            axes.loglog(cost, error, style, label=label)
            if label not in FINITE_ELEMENTS:
                for p in own:
                    axes.annotate(p.cells, (p.cost, p.error), (4, 4), textcoords="offset points", fontsize=7)
        axes.set(title=scene, xlabel=f"CPU over the uniform solve at {BESIDE}")
        axes.set_xticks(COSTS, [f"{cost:g}" for cost in COSTS])
        axes.set_yticks(ERRORS, [f"{error:g}" for error in ERRORS])
        axes.minorticks_off()
        axes.grid(visible=True, alpha=0.3)
    figure.axes[0].set_ylabel("error of K, %")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=7)
    figure.savefig(path, metadata={"Date": None})


def main() -> None:
    """Measure, write, draw."""
    with single_threaded():
        points = all_points()
    lines = sorted([p.scene, p.cells, f"{p.unknowns:,}", number(p.cost), number(p.error)] for p in points)
    write_csv(HERE / "graded.csv", ("scene", "cells", "unknowns", f"CPU over {BESIDE}", "error of K, %"), lines)
    draw(points, HERE / "graded.svg")


if __name__ == "__main__":
    main()
