"""Edges that are held where cells of several sizes meet."""

from __future__ import annotations

import pytest

import crackgrow
from crackgrow.case.load import read_case

HELD_IN_PART = """
units: {length: mm, stress: MPa}
title: a block that a part of its bottom holds, with a crack close to it
plane: strain
bodies:
  rock: {shape: {rectangle: {center: [0, 0], width: 60, height: 60}}, material: {young: 10000, poisson: 0.25}}
cracks:
  c: {path: {center: [-2, -27], length: 5, angle: 20}, contact: {friction: 0.3, cohesion: 0}}
supports: [{on: {body: rock, edge: bottom, from: -10, to: 3.3}, displacement: {x: 0, y: 0}}]
loads: [{on: {body: rock, edge: top}, traction: [3, 10]}]
"""


def swing(cells: str) -> float:
    """Displacement (m) of the middle of the top along it."""
    solution = crackgrow.solve(read_case(HELD_IN_PART, "held", "held", [f"numerics.{cells}"]))
    return float(solution.displacement_at([0.0, 0.0299])[0])


@pytest.mark.parametrize("accuracy", ["draft", "standard", "fine"])
def test_a_part_of_an_edge_holds_small_cells_no_tighter_than_it_does(accuracy: str) -> None:
    """Cells outside of the rock are large: fewer functions reach the edge than there are small cells along it.

    Where each of them is held, the rock round both ends is held with them: the block leans by 11 % too little.
    """
    swings = [swing(cells) for cells in ("spacing=1.5", f"accuracy={accuracy}")]
    assert swings[1] == pytest.approx(swings[0], rel=0.05)
