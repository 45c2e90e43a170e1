"""The estimated error of whole scenes beside that of a finer solution; edges held in part on small cells."""

from __future__ import annotations

import numpy as np
import pytest

import crackgrow
from crackgrow.case.load import read_case
from crackgrow.cover.elements import locate
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.quadrature.elements import element_points
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.report import estimate_maker
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.run.scene import make_scene
from crackgrow.solid.elasticity import energy_components
from crackgrow.solid.recovery import stress_at
from tests.scenes import shipped_case
from tests.solving import solve_step
from tests.whole_run import whole_run

COARSE = "numerics.spacing=3"


def solve(name: str, *settings: str, factor: float = 1.0) -> StepSolution:
    case = shipped_case(name, settings)
    cracks = tuple(map(GrowingCrack.given, case.cracks))
    return solve_step(make_scene(case), cracks, factor)


def run(*settings: str) -> tuple[list[StepResult], RunEnd]:
    case = shipped_case("compression30", (COARSE, "output.figures=false", *settings))
    return whole_run(case)


def distance(coarse: StepSolution, fine: StepSolution) -> float:
    """Energy norm of the difference of two solutions over that of the finer one, percent, by its quadrature.

    Every point is located anew in the coarse cover: each cover says on which side of its cracks it is.
    """
    cover, materials = fine.cover, fine.state.materials
    found = element_points(cover, fine.configuration.scene.case.numerics.quadrature + 1)
    body, metres = cover.elements.body[found.element], cover.lattice.to_metres(found.points)
    points = coarse.cover.lattice.to_lattice(metres)
    element = locate(coarse.cover.lattice, coarse.cover.elements, points, body)
    exact = stress_at(cover, materials, fine.outcome.u, found.points, found.element)
    off = stress_at(coarse.cover, coarse.state.materials, coarse.outcome.u, points, element) - exact
    energies = [(found.weights @ energy_components(materials, stress, body) ** 2).sum() for stress in (off, exact)]
    return 100.0 * float(np.sqrt(energies[0] / energies[1]))


@pytest.mark.parametrize(
    ("name", "spacing", "finer"),
    [("compression30", 3, 0.6), ("edge_tension", 3, 0.6), ("interface_friction04", 0.1, 0.02)],
)
def test_the_estimate_is_the_distance_to_a_finer_solution(name: str, spacing: float, finer: float) -> None:
    coarse = solve(name, f"numerics.spacing={spacing}")
    error = distance(coarse, solve(name, f"numerics.spacing={finer}"))
    assert 0.5 < estimate_maker(coarse)().relative / error < 2.0


def test_the_cells_of_a_frame_add_up_to_the_estimate() -> None:
    results, end = run("growth.steps=1", "output.fields=[energy_error]")
    for result, expected in zip(results, (results[0].norm_error, end.norm_error), strict=True):
        frame = result.frame
        assert frame is not None
        assert frame.error_density is not None
        area = np.concatenate([_areas(frame.points, cells) for cells in (frame.triangles, frame.quads)])
        share = np.sum(area * frame.error_density**2) / area.sum()
        np.testing.assert_allclose(100.0 * np.sqrt(share), expected, rtol=1e-9)


def _areas(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    x, y = points[cells].transpose(2, 0, 1)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


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
