"""Blocks that topple: a stack turns about its lower corner when its weight passes over it, at any spacing."""

from __future__ import annotations

import pytest

from crackgrow.case import load_case
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
