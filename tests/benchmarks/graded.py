"""K after growth against its cost: cells of one size, cells for an accuracy, and graded finite elements.

    python -m tests.benchmarks.graded       graded.csv and graded.svg beside this file

CPU seconds of one thread, the least of some solves, as multiples of the uniform solve at 1.5 mm of the same scene.
Finite elements were measured beside that solve by an earlier commit, which is run again: so they keep their scale.
"""

from __future__ import annotations

import csv
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from crackgrow.blas import single_threaded
from crackgrow.case import Case, load_case
from crackgrow.run import grow
from tests.benchmarks.beside import AGAINST, Scene, beside, program_of
from tests.benchmarks.paths import HERE, REFERENCES, ROOT
from tests.benchmarks.scenes import solved_once
from tests.benchmarks.tables import number, write_csv
from tests.scenes import MPA, shipped
from tests.verification.solutions import rows

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


def case_of(folder: Path, scene: str, cells: str) -> Case:
    """The specimen with wings of `scene`, without friction and growth."""
    text = shipped("compression30")
    points = [[float(row["x_mm"]), float(row["y_mm"])] for row in rows(f"{scene}_path.csv")]
    text["cracks"]["flaw"]["path"] = {"points": points}
    text["numerics"] = {"accuracy": cells} if cells in TARGETS else {"spacing": cells}
    file = folder / "scene.yaml"
    file.write_text(yaml.safe_dump(text))
    return solved_once(load_case(file, ["output.frames=none", "output.figures=false", "output.report=false"]))


def measured(scene: str, cells: str) -> Point:
    """A solve, its least time, and what it misses."""
    with tempfile.TemporaryDirectory() as folder:
        case = case_of(Path(folder), scene, cells)
    seconds = []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        step = next(grow(case))
        seconds.append(time.process_time() - begin)
    truth = {row["tip"]: row for row in rows("grown_K.csv") if row["scene"] == scene}
    off = []
    for tip in step.tips:
        K_I, K_II = (MPA * float(truth[tip.tip][f"{K}_MPa_sqrtm"]) for K in ("K_I", "K_II"))
        off.append(max(abs(tip.K_I - K_I), abs(tip.K_II - K_II)) / K_I)
    return Point(scene, cells, step.n_dofs, min(seconds), 100.0 * max(off))


def of_finite_elements(scene: str, then: float) -> Iterator[Point]:
    """The solves of another program, in seconds; `then`: of the uniform one by the commit, as it is measured now."""
    with (REFERENCES / "fe_cost.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
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
