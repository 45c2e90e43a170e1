"""Blocks that topple: they turn about their lower corners when their weight passes over these, at any spacing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

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


COLUMN_TILT = 2.5 / 8.5
"""Tangent at which the high column, 1 x 4, turns about its foot, pushes the top of the low one, 1 x 1, and turns it.

With the push F at the height h, the weights 4 w and w, and smooth faces between them (Goodman, Bray 1976, "Toppling of
rock slopes"): F h = 4 w (2 sin - cos / 2) of the high one, F h = w (cos - sin) / 2 of the low one.
"""


def columns(tilt: float, spacing: float, side: float, turn: float, cracked: bool) -> dict[str, Any]:
    """Two columns on a base, tilted towards the low one, which is on a side, 1 or -1; all is turned by degrees.

    They are bodies, or cracks have cut them out of one body.
    """
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

    base, corners = placed((-4, -2), (6, -2), (6, 0), (-4, 0)), placed((-4, -2), (6, -2))
    whole = placed((-4, -2), (6, -2), (6, 0), (2, 0), (2, 4), (1, 4), (1, 1), (0, 1), (0, 0), (-4, 0))
    weight = (9.81 * np.array(placed((-tilt, -1)))[0] / np.hypot(tilt, 1.0)).tolist()
    scene = {
        "title": "a high column that leans on a low one",
        "plane": "strain",
        "bodies": {"base": body(base), "low": body(upright(0, 1)), "high": body(upright(1, 4))},
        "interfaces": [joint("base", "low", 3), joint("base", "high", 3), joint("low", "high", 0)],
        "supports": [{"at": corner, "displacement": {"x": 0, "y": 0}} for corner in corners],
        "loads": [{"body": name, "gravity": weight} for name in ("low", "high")],
        "numerics": {"spacing": spacing},
    }
    if cracked:
        del scene["interfaces"]
        scene["bodies"] = {"rock": body(whole)}
        scene["cracks"] = {"foot": crack(placed((0, 0), (2, 0)), 3), "joint": crack(placed((1, 0), (1, 1)), 0)}
        scene["loads"] = [{"body": "rock", "gravity": weight}]
    return scene


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize(
    ("spacing", "side", "turn"),
    [(0.5, 1.0, 0.0), (0.25, 1.0, 0.0), (0.125, 1.0, 0.0), (0.25, -1.0, 0.0), (0.2, 1.0, 25.0)],
)
def test_columns_side_by_side_topple_about_the_corner_where_three_pieces_meet(
    spacing: float, side: float, turn: float, cracked: bool
) -> None:
    """With a constant end piece there, whose force lies inside, they fell at 0.47 to 0.93 of this tilt."""
    solve_case(Case.from_dict(columns(0.998 * COLUMN_TILT, spacing, side, turn, cracked)))
    with pytest.raises(SolveError, match=r"'\w+'.* \(and with it .* '\w+'.*\) is free to move"):
        solve_case(Case.from_dict(columns(1.002 * COLUMN_TILT, spacing, side, turn, cracked)))


def offset_joints(offset: float, cracked: bool) -> dict[str, Any]:
    """Four blocks under a load; the joints between the upper and the lower ones are `offset` apart, cells of 0.25 m."""
    x = 2.0 + 0.25 * offset
    blocks = {
        "a": [[0, 0], [2, 0], [2, 1], [0, 1]],
        "b": [[2, 0], [4, 0], [4, 1], [2, 1]],
        "c": [[0, 1], [x, 1], [x, 2], [0, 2]],
        "d": [[x, 1], [4, 1], [4, 2], [x, 2]],
    }
    rough, material = {"friction": 3, "cohesion": 0}, {"young": 1e10, "poisson": 0.2}
    top, ends = [1e5, -1e6], {"left": [5e5, 0], "right": [-5e5, 0]}
    scene: dict[str, Any] = {"title": "joints on both sides of another one", "plane": "strain"}
    if cracked:
        paths = {"host": [[0, 1], [4, 1]], "lower": [[2, 0], [2, 1]], "upper": [[x, 1], [x, 2]]}
        scene["bodies"] = {"rock": {"shape": {"polygon": [[0, 0], [4, 0], [4, 2], [0, 2]]}, "material": material}}
        scene["cracks"] = {
            name: {"path": {"points": path}, "tips": "none", "contact": rough} for name, path in paths.items()
        }
        on = {"bottom": [("rock", 0)], "top": [("rock", 2)], "left": [("rock", 3)], "right": [("rock", 1)]}
    else:
        scene["bodies"] = {name: {"shape": {"polygon": block}, "material": material} for name, block in blocks.items()}
        scene["interfaces"] = [{"between": list(pair), "contact": rough} for pair in ("ab", "cd", "ac", "bd", "bc")]
        on = {
            "bottom": [("a", 0), ("b", 0)], "top": [("c", 2), ("d", 2)],
            "left": [("a", 3), ("c", 3)], "right": [("b", 1), ("d", 1)],
        }  # fmt: skip
    place = {side: [{"body": body, "edge": edge} for body, edge in edges] for side, edges in on.items()}
    scene["supports"] = [{"on": region, "displacement": {"y": 0}} for region in place["bottom"]]
    scene["supports"].append({"at": [0, 0], "displacement": {"x": 0}})
    loads = {"top": top, **ends}
    scene["loads"] = [{"on": region, "traction": load} for side, load in loads.items() for region in place[side]]
    return scene | {"numerics": {"spacing": 0.25}}


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize("offset", [0.01, 0.02, 0.08, 0.2, 0.4, 0.8, 1.6])
def test_the_pressure_is_smooth_between_joints_that_end_on_both_sides_of_another_one(
    offset: float, cracked: bool
) -> None:
    """With nodes on both corners and between them it was up to 3.9 times as large on the short stretch, or zero."""
    solution = solve_case(Case.from_dict(offset_joints(offset, cracked))).solution
    points, normal = solution.faces.nodes.points, solution.outcome.points.normal
    lattice, level = solution.cover.lattice, np.abs(solution.faces.nodes.normal[:, 1]) > 0.5
    there = level & (np.abs(lattice.to_metres(points)[:, 0] - 2.0) < 0.6)
    assert np.count_nonzero(there) > 2
    assert normal[there] == pytest.approx(-1e6, rel=0.2)
