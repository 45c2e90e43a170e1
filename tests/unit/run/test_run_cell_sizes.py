"""Contact and edges that are held where cells are smaller than the lattice's, or of several sizes."""

from __future__ import annotations

import pytest

import crackgrow
from crackgrow.case.load import read_case
from crackgrow.cover.cover import build_cover
from crackgrow.run import grow, layout
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.unit.cell_sizes import with_sizes


def test_the_stiffness_of_contact_goes_by_the_cells_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """k = kappa E/h: half the h is twice the kappa. Gauss points lie where they do whatever the cells."""

    def first_step(stiffness: int, *more: str) -> StepResult:
        contact = f"numerics.contact={{discretization: gauss, stiffness: {stiffness}}}"
        settings = [contact, "numerics.spacing=1.5", "output.frames=none", "output.figures=false", *more]
        return next(grow(shipped_case("compression30", settings)))

    stiff, large = first_step(2), first_step(1)
    assert [tip.cell_size for tip in first_step(1, "numerics.refine.tips=2").tips] == pytest.approx([0.25 * 1.5e-3] * 2)
    monkeypatch.setattr(layout, "build_cover", lambda *of: with_sizes(build_cover(*of), 0.5))
    small = first_step(1)
    for one, other in zip(small.tips, stiff.tips, strict=True):
        assert pytest.approx(other.K_II, rel=1e-12) == one.K_II
    assert small.energy.strain == pytest.approx(stiff.energy.strain, rel=1e-12)
    assert small.overlap == pytest.approx(stiff.overlap, rel=1e-9)
    assert abs(large.tips[0].K_II / small.tips[0].K_II - 1.0) > 1e-3


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
