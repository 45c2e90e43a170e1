"""Whether the presets lie on the front of CPU over the error of K after growth, and what cells of one size cost.

    python -m tests.benchmarks.presets      presets.md beside this file

Round each preset its cells at tips and at kinks are halved once more and once less. CPU is the least of some solves,
without what a name takes to measure its error.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crackgrow.blas import single_threaded
from crackgrow.case import Case, load_case
from crackgrow.run.loop import solved_steps
from tests.benchmarks.paths import HERE
from tests.benchmarks.scenes import solved_once
from tests.benchmarks.tables import number, table
from tests.benchmarks.target_scenes import SCENES, Known

PRESETS = ("draft", "standard", "fine")
UNIFORM: Mapping[str, tuple[float, ...]] = {
    "young wings": (3.0, 1.5, 0.75, 0.375),
    "grown wings": (3.0, 1.5, 0.75, 0.375),
    "closed kink of 30": (4.0, 2.0, 1.0),
    "wings, friction 0.3, 30": (1.6, 0.8),
    "wings, hoop, 45": (1.6, 0.8),
    "wings, friction 0.3, 60": (1.6, 0.8),
}
"""Scenes, and sides of cells of one size in mm: those of wide plates are as small as 150,000 unknowns let them be."""

AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1))  # halvings more at tips, at kinks
REPETITIONS = 2
QUIET = ("output.frames=none", "output.figures=false", "output.report=false")
NEAR = 1.2  # times the cost of the cheapest that is as good: on the front
MOST = 30.0  # times that costs are extrapolated
TEXT = HERE / "presets.md"


@dataclass(frozen=True, slots=True)
class Point:
    """A setting, solved."""

    scene: str
    cells: str
    unknowns: int
    seconds: float
    error: float  # of the largest K
    tips: int = 0  # halvings of the largest cells at tips
    kinks: int = 0  # the same of the smallest cells
    spacing: float = 0.0  # m


def measured(scene: str, known: Known, cells: str, numerics: Mapping[str, Any]) -> Point:
    """What a setting costs and misses."""
    assert known.truth is not None
    case, seconds = solved_once(case_of(known, numerics)), []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        with single_threaded():
            step, solution = next(solved_steps(case))
        seconds.append(time.process_time() - begin)
    largest = max(float(np.hypot(*K)) for K in known.truth.values())
    off = max(
        float(
            np.hypot(
                tip.K_I - known.truth[tip.crack, tip.tip][0], abs(tip.K_II) - abs(known.truth[tip.crack, tip.tip][1])
            )
        )
        for tip in step.tips
    )
    tips, kinks = (round(-math.log2(size)) for size in (solution.cover.tips[0].size, solution.cover.sizes.min()))
    return Point(scene, cells, step.n_dofs, min(seconds), off / largest, tips, kinks, case.numerics.spacing)


def case_of(known: Known, numerics: Mapping[str, Any]) -> Case:
    """A scene under some settings."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(yaml.safe_dump({**known.case, "numerics": dict(numerics)}))
        return load_case(file, QUIET)


def points_of(scene: str) -> Iterator[Point]:
    """All settings of a scene."""
    known = SCENES[scene].make()
    for preset in PRESETS:
        own = measured(scene, known, preset, {"accuracy": preset})
        yield own
        for tips, kinks in AROUND:
            if own.tips + tips < 0:
                continue
            refine = {"tips": own.tips + tips, "kinks": own.kinks + kinks, "corners": "auto"}
            cells = {"accuracy": preset, "spacing": f"{own.spacing!r} m", "refine": refine}
            yield measured(scene, known, f"{preset} {tips:+d} {kinks:+d}", cells)
    for side in UNIFORM[scene]:
        yield measured(scene, known, f"{side:g} mm", {"spacing": side, "refine": {"tips": 0, "kinks": 0, "corners": 0}})


def beyond_front(point: Point, points: Sequence[Point]) -> float:
    """Its cost over that of the cheapest setting that is as good."""
    return point.seconds / min(other.seconds for other in points if other.error <= point.error)


def uniform_cost(error: float, points: Sequence[Point]) -> tuple[float, bool]:
    """Seconds that cells of one size take for an error, and whether they are extrapolated, as none reached it."""
    uniform = [point for point in points if point.cells.endswith("mm")]
    enough = [point.seconds for point in uniform if point.error <= error]
    if enough:
        return min(enough), False
    fine = sorted(uniform, key=lambda point: point.seconds)[-2:]
    (x0, x1), (y0, y1) = (
        [math.log(v) for v in pair] for pair in zip(*((p.error, p.seconds) for p in fine), strict=True)
    )
    if x1 >= x0:  # not converging yet
        return math.nan, True
    return math.exp(y1 + (y1 - y0) / (x1 - x0) * (math.log(error) - x1)), True


def times(ratio: float, extrapolated: bool) -> str:
    """A ratio of costs; far from what was measured no number is worth anything."""
    if extrapolated and ratio > MOST:
        return f"more than {MOST:g}"
    return f"{'about ' if extrapolated and ratio > 0.0 else ''}{number(ratio)}"


def text_of(points: Sequence[Point]) -> str:
    """The table of the presets."""
    lines, on_front, cheaper, n = [], 0, 0, 0
    for scene in UNIFORM:
        mine = [point for point in points if point.scene == scene]
        for point in (p for p in mine if p.cells in PRESETS):
            over, (uniform, more) = beyond_front(point, mine), uniform_cost(point.error, mine)
            n, on_front, cheaper = n + 1, on_front + (over <= NEAR), cheaper + (uniform >= 5.0 * point.seconds)
            lines.append([
                scene, point.cells, f"{point.unknowns:,}", f"{point.seconds:.2f}", number(100.0 * point.error),
                f"{over:.2f}", times(uniform / point.seconds, more),
            ])  # fmt: skip
    header = ("scene", "preset", "unknowns", "CPU s", "error of K, %", "over the front", "cells of one size, times")
    words = (
        "# The presets and the front\n\n"
        "Written by `python -m tests.benchmarks.presets`: scenes of tests/benchmarks/target_scenes.py whose cracks\n"
        "have grown, or have a kink. Error: the worst tip, K_I and K_II together, over the largest K. Over the front:\n"
        "CPU over that of the cheapest setting that is as good, of the presets, the same with cells at tips and kinks\n"
        "halved once more or less, and cells of one size. The last column: what cells of one size cost for that\n"
        "error, over the preset; about: extrapolated from the two finest, where none that was solved is as good.\n\n"
        f"Within {100 * (NEAR - 1):.0f} % of the front are {on_front} of {n}; cells of one size cost at least 5 times\n"
        f"as much as {cheaper} of {n}.\n\n"
    )
    return words + table(header, lines)


def main() -> None:
    """Measure and write."""
    points = []
    for scene in UNIFORM:
        for point in points_of(scene):
            points.append(point)
            print(point, flush=True)
    TEXT.write_text(text_of(points))


if __name__ == "__main__":
    main()
