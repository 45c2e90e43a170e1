"""Blocks that slide, columns that topple, and the factor of safety on its way, against limit equilibrium."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from crackgrow.case import Case
from crackgrow.cli import main
from crackgrow.errors import FreePieceError, SolveError
from tests.solving import whole_run
from tests.verification.rows.test_limits import INCLINE, LIMIT, safety_of
from tests.verification.solutions import case_of, solve_case


@pytest.mark.parametrize("friction", [0.8, 0.4])
def test_block_on_an_incline(friction: float) -> None:
    """With less friction than the slope it does not hold as it is, and the last stable state is all there is."""
    steps, end = whole_run(case_of(INCLINE, LAW=f"friction: {friction}, cohesion: 0"))
    assert end.safety is not None
    assert end.safety.factor == pytest.approx(friction / np.tan(np.pi / 6.0), rel=2e-3)
    assert end.safety.factor < end.safety.fails_at < 1.001 * end.safety.factor
    assert end.safety.mechanism in end.reason
    assert "body 'block'" in end.safety.mechanism
    assert "it slides along 'wedge/block'" in end.safety.mechanism
    assert len(steps) == (2 if friction > 0.577 else 1)
    last = steps[-1].contact
    ratio = np.abs(last.tangential_traction).sum() / np.abs(last.normal_traction).sum()
    assert ratio == pytest.approx(np.tan(np.pi / 6.0), rel=1e-3)


def test_the_factor_of_safety_is_in_the_summary(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(INCLINE.replace("LAW", "friction: 0.8, cohesion: 0"), encoding="utf-8")
    assert main(["run", str(path), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "completed"
    assert summary["safety"]["factor"] == pytest.approx(0.8 / np.tan(np.pi / 6.0), rel=2e-3)
    assert summary["safety"]["mechanism"] in summary["stop_reason"]


FLAT = """
title: a block on a floor
plane: strain
bodies: {block: {shape: {rectangle: {center: [0, 0.5], width: 1, height: 1}}, material: {young: 1e9, poisson: 0.2}}}
supports: [{on: {body: block, edge: bottom}, contact: {friction: 0.5, cohesion: 0}}]
loads: [{on: {body: block, edge: top}, traction: [0, PULL]}]
loading: strength_reduction
numerics: {spacing: 0.25}
"""


def test_a_scene_that_needs_no_strength_does_not_fail_and_one_that_no_strength_holds_is_told_as_such() -> None:
    _, end = whole_run(case_of(FLAT, PULL=-1e5))
    assert end.safety is not None
    assert np.isinf(end.safety.factor)
    assert "does not fail" in end.reason
    with pytest.raises(FreePieceError, match="body 'block'"):
        whole_run(case_of(FLAT, PULL=1e5))


BRITTLE = {"LAW": "friction: 0.4, cohesion: 1e4"}
"""A block whose weight presses and shears the incline unevenly: cohesion is lost where it is loaded most first."""


def test_brittle_cohesion_fails_below_limit_equilibrium_and_says_why() -> None:
    """It is not less than friction alone has, and the end names the body, the joint and the factor of the whole."""
    safety = safety_of(INCLINE, **BRITTLE)
    assert 0.4 / np.tan(np.pi / 6.0) < safety.factor < 0.95 * LIMIT
    assert "body 'block' is free to move" in safety.mechanism
    assert "it slides along 'wedge/block'" in safety.mechanism
    assert "contact has lost strength on 'wedge/block'" in safety.mechanism
    told = re.search(r"it would hold up to ([\d.]+):", safety.mechanism)
    assert told is not None
    assert float(told[1]) == pytest.approx(LIMIT, rel=2e-3)


@pytest.mark.slow
def test_with_a_weakening_length_cells_do_not_matter() -> None:
    """Where bonds break at once the factor falls with every finer lattice, as at a crack without toughness."""
    texts = [INCLINE.replace("spacing: 0.5", f"spacing: {h}") for h in (0.5, 0.25)]
    coarse, fine = (safety_of(text, LAW=f"{BRITTLE['LAW']}, weakening_length: 1e-5").factor for text in texts)
    assert fine == pytest.approx(coarse, rel=1e-2)


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
    tilt: float,
    spacing: float,
    side: float = 1.0,
    turn: float = 0.0,
    cracked: bool = False,
    heights: tuple[int, ...] = PAIR,
    friction: tuple[float, float] = (3, 0),
) -> dict[str, Any]:
    """Columns on a base, tilted towards the first, which is on a side, 1 or -1; all is turned by degrees.

    They are bodies, or cracks have cut them out of one body; friction is that at their feet, and between them.
    """
    n, (foot, between) = len(heights), friction
    c, s = np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))

    def placed(*points: tuple[float, float]) -> list[list[float]]:
        found = np.array([(side * x, y) for x, y in points]) @ np.array([[c, s], [-s, c]])
        return (found if side > 0.0 else found[::-1]).tolist()

    def body(points: list[list[float]]) -> dict[str, Any]:
        return {"shape": {"polygon": points}, "material": {"young": 1e10, "poisson": 0.2, "density": 2500}}

    def law(friction: float) -> dict[str, float]:
        return {"friction": friction, "cohesion": 0}

    def crack(points: list[list[float]], friction: float) -> dict[str, Any]:
        return {"path": {"points": points}, "tips": "none", "contact": law(friction)}

    base, corners = placed((-4, -2), (n + 4, -2), (n + 4, 0), (-4, 0)), placed((-4, -2), (n + 4, -2))
    weight = (9.81 * np.array(placed((-tilt, -1)))[0] / np.hypot(tilt, 1.0)).tolist()
    bodies = {f"c{k}": body(placed((k, 0), (k + 1, 0), (k + 1, h), (k, h))) for k, h in enumerate(heights)}
    scene = {
        "title": "columns that lean on each other",
        "plane": "strain",
        "bodies": {"base": body(base), **bodies},
        "interfaces": [
            *({"between": ["base", name], "contact": law(foot)} for name in bodies),
            *({"between": list(two), "contact": law(between)} for two in pairwise(bodies)),
        ],
        "supports": [{"at": corner, "displacement": {"x": 0, "y": 0}} for corner in corners],
        "loads": [{"body": name, "gravity": weight} for name in bodies],
        "numerics": {"spacing": spacing},
    }
    if cracked:
        del scene["interfaces"]
        steps = [(x, heights[k]) for k in reversed(range(n)) for x in (k + 1, k)]
        scene["bodies"] = {"rock": body(placed((-4, -2), (n + 4, -2), (n + 4, 0), (n, 0), *steps, (0, 0), (-4, 0)))}
        joints = {f"j{k}": crack(placed((k, 0), (k, min(heights[k - 1 : k + 1]))), between) for k in range(1, n)}
        scene["cracks"] = {"foot": crack(placed((0, 0), (n, 0)), foot), **joints}
        scene["loads"] = [{"body": "rock", "gravity": weight}]
    return scene


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize(
    ("heights", "spacing", "side", "turn"),
    [
        *((PAIR, spacing, 1.0, 0.0) for spacing in (0.5, 0.125)),
        (PAIR, 0.2, -1.0, 25.0),
        ((1, 1, 1, 4), 0.5, 1.0, 0.0),
        ((2, 3, 4, 3), 0.3, 1.0, 0.0),
    ],
)
def test_columns_topple_as_each_hands_on_the_push(
    heights: tuple[int, ...], spacing: float, side: float, turn: float, cracked: bool
) -> None:
    """About the corner where three pieces meet. Where the last one would stand by itself it pushes nothing."""
    tilt = limit_tilt(heights)
    assert heights != PAIR or tilt == pytest.approx(2.5 / 8.5)
    solve_case(Case.from_dict(columns(0.998 * tilt, spacing, side, turn, cracked, heights)))
    together = r"'\w+'.* \(and with it .* '\w+'.*\) " if heights == PAIR else ""
    with pytest.raises(SolveError, match=rf"{together}is free to move"):
        solve_case(Case.from_dict(columns(1.002 * tilt, spacing, side, turn, cracked, heights)))
