"""Blocks that topple: they turn about their lower corners when their weight passes over these, at any spacing."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from crackgrow.case import Case, load_case
from crackgrow.errors import SolveError
from tests.verification.solutions import solve_case

HEIGHT = 3  # blocks of 1 m: toppling at a tilt of 1/3


def stack(tilt: float, spacing: float) -> str:
    """Blocks on a rough foundation under gravity with a part `tilt` of it sideways."""
    material = "material: {young: 10 GPa, poisson: 0.2, density: 2500 kg/m^3}"
    bodies = "\n".join(
        f"  b{k}: {{shape: {{rectangle: {{center: [0, {k + 0.5}], width: 1, height: 1}}}}, {material}}}"
        for k in range(HEIGHT)
    )
    rough = "contact: {friction: 2, cohesion: 0}"
    joints = "\n".join(f"  - {{between: [b{k}, b{k + 1}], {rough}}}" for k in range(HEIGHT - 1))
    weights = "\n".join(f"  - {{body: b{k}, gravity: [{9.81 * tilt}, -9.81]}}" for k in range(HEIGHT))
    return f"""
title: stack of blocks
units: {{length: m, stress: Pa}}
plane: strain
bodies:
{bodies}
interfaces:
{joints}
supports:
  - {{on: {{body: b0, edge: bottom}}, {rough}}}
loads:
{weights}
numerics: {{spacing: {spacing}}}
"""


@pytest.mark.parametrize("spacing", [0.2, 0.1])
def test_a_stack_topples_when_its_weight_passes_over_its_edge(tmp_path, spacing: float) -> None:
    """With hats at the edge the lever arm ended 0.4 spacings short: 17 and 8 % early."""
    path = tmp_path / "stack.yaml"
    path.write_text(stack(0.995 / HEIGHT, spacing), encoding="utf-8")
    solve_case(load_case(path))
    path.write_text(stack(1.005 / HEIGHT, spacing), encoding="utf-8")
    with pytest.raises(SolveError, match=r"free to move|contact does not hold"):
        solve_case(load_case(path))


PAIR = (1, 4)
"""Heights of columns, 1 wide: the high one turns about its foot, pushes the top of the low one, and turns it."""


def limit_tilt(heights: tuple[int, ...]) -> float:
    """Tangent at which the first of such columns topples under the push of those behind it, all faces smooth.

    A column of height h and weight h w that is pushed by P' at the height a' passes on the push P at the height a, both
    at the top of the lower of two: P a = P' a' + h w (h sin - cos) / 2 (Goodman, Bray 1976, "Toppling of rock slopes").
    """

    def turning(tilt: float) -> float:
        moment, above = 0.0, 0
        for height, next_height in pairwise((*heights[::-1], 0)):
            moment = max(moment, 0.0) * above + 0.5 * height * (height * tilt - 1.0)
            above = min(height, next_height)
            moment = moment / above if above else moment
        return moment

    return float(brentq(turning, 0.05, 1.0))


def columns(
    tilt: float, spacing: float, side: float = 1.0, turn: float = 0.0, cracked: bool = False, heights: Any = PAIR
) -> dict[str, Any]:
    """Columns on a base, tilted towards the first, which is on a side, 1 or -1; all is turned by degrees.

    They are bodies, or cracks have cut them out of one body.
    """
    n = len(heights)
    c, s = np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))

    def placed(*points: tuple[float, float]) -> list[list[float]]:
        found = np.array([(side * x, y) for x, y in points]) @ np.array([[c, s], [-s, c]])
        return (found if side > 0.0 else found[::-1]).tolist()

    def body(points: list[list[float]]) -> dict[str, Any]:
        return {"shape": {"polygon": points}, "material": {"young": 1e10, "poisson": 0.2, "density": 2500}}

    def upright(x: float, height: float) -> list[list[float]]:
        return placed((x, 0), (x + 1, 0), (x + 1, height), (x, height))

    def joint(first: str, second: str, friction: float) -> dict[str, Any]:
        return {"between": [first, second], "contact": {"friction": friction, "cohesion": 0}}

    def crack(points: list[list[float]], friction: float) -> dict[str, Any]:
        return {"path": {"points": points}, "tips": "none", "contact": {"friction": friction, "cohesion": 0}}

    base, corners = placed((-4, -2), (n + 4, -2), (n + 4, 0), (-4, 0)), placed((-4, -2), (n + 4, -2))
    steps = [(x, heights[k]) for k in reversed(range(n)) for x in (k + 1, k)]
    whole = placed((-4, -2), (n + 4, -2), (n + 4, 0), (n, 0), *steps, (0, 0), (-4, 0))
    weight = (9.81 * np.array(placed((-tilt, -1)))[0] / np.hypot(tilt, 1.0)).tolist()
    names = [f"c{k}" for k in range(n)]
    scene = {
        "title": "columns that lean on each other",
        "plane": "strain",
        "bodies": {"base": body(base), **{name: body(upright(k, heights[k])) for k, name in enumerate(names)}},
        "interfaces": [*(joint("base", name, 3) for name in names), *(joint(*two, 0) for two in pairwise(names))],
        "supports": [{"at": corner, "displacement": {"x": 0, "y": 0}} for corner in corners],
        "loads": [{"body": name, "gravity": weight} for name in names],
        "numerics": {"spacing": spacing},
    }
    if cracked:
        del scene["interfaces"]
        joints = {f"j{k}": crack(placed((k, 0), (k, min(heights[k - 1 : k + 1]))), 0) for k in range(1, n)}
        scene["bodies"] = {"rock": body(whole)}
        scene["cracks"] = {"foot": crack(placed((0, 0), (n, 0)), 3), **joints}
        scene["loads"] = [{"body": "rock", "gravity": weight}]
    return scene


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize(
    ("spacing", "side", "turn"),
    [(0.5, 1.0, 0.0), (0.25, 1.0, 0.0), (0.125, 1.0, 0.0), (0.0625, 1.0, 0.0), (0.25, -1.0, 0.0), (0.2, 1.0, 25.0)],
)
def test_columns_side_by_side_topple_about_the_corner_where_three_pieces_meet(
    spacing: float, side: float, turn: float, cracked: bool
) -> None:
    """With a constant end piece there, whose force lies inside, they fell at 0.47 to 0.93 of this tilt."""
    tilt = limit_tilt(PAIR)
    assert tilt == pytest.approx(2.5 / 8.5)
    solve_case(Case.from_dict(columns(0.998 * tilt, spacing, side, turn, cracked)))
    with pytest.raises(SolveError, match=r"'\w+'.* \(and with it .* '\w+'.*\) is free to move"):
        solve_case(Case.from_dict(columns(1.002 * tilt, spacing, side, turn, cracked)))


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize(("heights", "spacing"), [((1, 1, 1, 4), 0.5), ((2, 4, 3), 0.25), ((2, 3, 4, 3), 0.3)])
def test_a_row_of_columns_topples_as_each_hands_on_the_push(
    heights: tuple[int, ...], spacing: float, cracked: bool
) -> None:
    """Where the last one would stand by itself it pushes nothing: those in front of it topple without it."""
    tilt = limit_tilt(heights)
    solve_case(Case.from_dict(columns(0.998 * tilt, spacing, cracked=cracked, heights=heights)))
    with pytest.raises(SolveError, match="is free to move"):
        solve_case(Case.from_dict(columns(1.002 * tilt, spacing, cracked=cracked, heights=heights)))
