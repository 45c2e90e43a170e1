"""Bounds of the direction of growth and of critical load factors: they hold for 90 %.

The truth is the same cracks on cells halved for `fine`. Measured on the scenes below and one more, three criteria and
two sizes of cells: tips whose direction is within the bound, load factors within theirs, median of bound over error.

    directions    72    90 %    8
    load factors  36   100 %   11

Where a name chooses the cells the criterion is asked on other ones, too; the truth is on cells for 0.1 %.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import yaml

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.verification.solutions import rows
from tests.verification.test_intensity_error import plate, shipped, winged

QUIET = ["output.frames=none", "output.figures=false", "output.report=false"]
CRITERIA = ("strength", "directional_strength", "max_hoop_stress")


def specimen(name: str) -> dict[str, Any]:
    scene = shipped("compression30")
    points = [[float(row["x_mm"]), float(row["y_mm"])] for row in rows(f"{name}_path.csv")]
    scene["cracks"]["flaw"]["path"] = {"points": points}
    return scene


def wide(angle: float, wing: float, turn: float, friction: float, lateral: float) -> dict[str, Any]:
    return plate(winged(5.0, angle, wing, turn), 60.0, 20.0, lateral, friction)


SCENES = {
    "flaw": (lambda: shipped("compression30"), (3.0,)),
    "young": (lambda: specimen("young30"), (1.5,)),
    "grown": (lambda: specimen("grown30"), (1.5,)),
    "wings": (lambda: wide(45.0, 3.0, 60.0, 0.3, 0.0), (1.5,)),
    "open": (lambda: plate(winged(5.0, 20.0, 3.0, 30.0), 60.0, -5.0, 0.0, 0.0), (1.5,)),
}


def growing(
    scene: dict[str, Any], criterion: str, numerics: dict[str, Any], steps: int, direction: str
) -> dict[str, Any]:
    scene["bodies"]["rock"]["strength"] = {"tension": 1, "cohesion": 10, "friction_angle": 40}
    growth = {"steps": steps, "increment": 2, "advance": "all", "criterion": criterion, "tip_stress": {"radius": 1}}
    return {**scene, "loading": "critical", "growth": {**growth, "direction": direction}, "numerics": numerics}


@cache
def solved(name: str, criterion: str, cells: float | str) -> StepResult:
    """The first step on cells of one size (mm), or on those of an accuracy."""
    numerics = {"accuracy": cells} if isinstance(cells, str) else {"spacing": cells}
    return next(run(growing(SCENES[name][0](), criterion, numerics, 0, "explicit")))


def run(scene: dict[str, Any]) -> Iterator[StepResult]:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "scene.yaml"
        file.write_text(yaml.safe_dump(scene))
        case = load_case(file, QUIET)
    return grow(case)


def covered(pairs: list[tuple[float, float]]) -> tuple[float, float]:
    """Part of the errors that are within their bounds, and the median of bound over error."""
    error, bound = np.array(pairs).T
    return float(np.mean(error <= bound)), float(np.median(bound / np.maximum(error, 1e-12)))


def turn(a: float, b: float) -> float:
    """Degrees between two directions."""
    return abs((a - b + 180.0) % 360.0 - 180.0)


Pairs = list[tuple[StepResult, StepResult]]


def of_one_size() -> Pairs:
    """Steps on cells of one size, and the truth."""
    return [
        (solved(name, criterion, spacing), solved(name, criterion, "fine"))
        for name, (_, spacings) in SCENES.items()
        for criterion in CRITERIA
        for spacing in spacings
    ]


def by_name() -> Pairs:
    """Steps on the cells of names, and the truth."""
    return [
        (solved(name, criterion, accuracy), solved(name, criterion, "0.1 %"))
        for name in SCENES
        for criterion in CRITERIA
        for accuracy in ("draft", "standard")
    ]


def directions(pairs: Pairs) -> list[tuple[float, float]]:
    """What the direction of each tip is off by, and its bound, degrees."""
    return [
        (turn(tip.kink_deg, true.kink_deg), tip.kink_error_deg)
        for step, truth in pairs
        for tip, true in zip(step.tips, truth.tips, strict=True)
    ]


def loads(pairs: Pairs) -> list[tuple[float, float]]:
    """What each critical load factor is off by, and its bound, percent."""
    return [
        (100.0 * abs(step.load_factor / truth.load_factor - 1.0), step.load_factor_error)
        for step, truth in pairs
        if np.isfinite(step.load_factor_error)
    ]


def test_directions_are_within_their_bounds() -> None:
    part, ratio = covered(directions(of_one_size()))
    assert part >= 0.9
    assert ratio < 30.0


def test_critical_load_factors_are_within_their_bounds() -> None:
    found = loads(of_one_size())
    assert len(found) == 15
    part, ratio = covered(found)
    assert part >= 0.9
    assert ratio < 30.0


def test_both_are_where_the_error_of_K_is_measured() -> None:
    """That of K is smaller then, and not all that they are off by: the stress they go by has an error of its own."""
    for found in (directions(by_name()), loads(by_name())):
        part, ratio = covered(found)
        assert part >= 0.9, found
        assert ratio < 10.0


def test_the_direction_without_shear_is_within_its_bound() -> None:
    """What has grown at the first increment, against the same on small cells: the new tips tell what it is off by."""
    found = []
    for name in ("flaw", "open"):
        ways, bounds = [], []
        for numerics in ({"spacing": 1.5}, {"accuracy": "fine"}):
            *_, last = run(growing(SCENES[name][0](), "max_hoop_stress", dict(numerics), 1, "implicit"))
            ends = [last.cracks[0].points[[1, 0]], last.cracks[0].points[[-2, -1]]]
            ways.append([np.rad2deg(np.arctan2(*(end[1] - end[0])[::-1])) for end in ends])
            bounds = [tip.kink_error_deg for tip in last.tips] if "spacing" in numerics else bounds
        found += [(turn(a, b), bound) for a, b, bound in zip(*ways, bounds, strict=True)]
    part, ratio = covered(found)
    assert part >= 0.9
    assert ratio < 50.0
