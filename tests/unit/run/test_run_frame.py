"""The output mesh covers the specimen, is conforming, and is double along cracks and nowhere else; its fields."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from crackgrow.contact.jump import gap_and_slip
from crackgrow.fracture.advance import GrowingCrack, Segment, advanced
from crackgrow.run.configuration import assemble
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.frame import OutputMesh, make_frame, output_mesh
from crackgrow.run.result import Frame
from crackgrow.run.scene import make_scene
from crackgrow.solid.recovery import stress_at
from tests.scenes import shipped_case
from tests.solving import face_vertices, solve_step

NEAR = 1e-9
"""m: vertices lie on a grid of 1e-12 m; no two of them are nearer than 1e-6 m here."""

AT_TIP = 1e-4
"""Relative jump at a tip: vertices lie off it by the grid of 1e-9 spacings, and the jump grows as the square root."""

SCENES = {
    "closed": ("compression30", ()),
    "open": ("tension0", ()),
    "kinked": ("compression30", (70.0, -20.0)),
    "finer tiles": ("compression30", (70.0,), "numerics.support=1.75"),
}
"""Scene, kinks in degrees of 2 mm segments added at the end, settings."""

BY_HAND = ("numerics.spacing=1.5", "numerics.refine.tips=3", "numerics.refine.kinks=6")
STUCK = ("compression30", (70.0,), "cracks.flaw.contact.friction=20", *BY_HAND)

CUT = ("flaw_and_hole", "interface_friction04", "junction_static", "en_echelon")
"""Scenes with curved outlines, several bodies, cracks that meet."""


@cache
def solved(name: str) -> tuple[StepSolution, Frame]:
    file, *rest = (SCENES | {"stuck": STUCK})[name]
    kinks, settings = rest[0], rest[1:]
    case = shipped_case(file, settings)
    scene = make_scene(case)
    growing = GrowingCrack.given(case.cracks[0])
    for step, kink in enumerate(kinks, start=1):
        growing, _ = advanced(growing, True, Segment(np.deg2rad(kink), 2e-3), step, scene.regions[0])
    solution = solve_step(scene, (growing,), 1.0)
    return solution, make_frame(solution.cover, scene.materials, solution.outcome.u)


def areas(frame: Frame | OutputMesh) -> np.ndarray:
    """Signed areas of all cells, triangles first."""
    found = []
    for cells in (frame.triangles, frame.quads):
        x, y = frame.points[cells].transpose(2, 0, 1)
        found.append(0.5 * np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1))
    return np.concatenate(found)


def edges(frame: Frame | OutputMesh) -> tuple[np.ndarray, np.ndarray]:
    """Undirected edges (n, 2) of the mesh and how many cells have each."""
    both = [
        np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2) for cells in (frame.triangles, frame.quads)
    ]
    return np.unique(np.sort(np.concatenate(both), axis=1), axis=0, return_counts=True)


def nodes_at(frame: Frame, point: np.ndarray) -> np.ndarray:
    return np.flatnonzero(np.hypot(*(frame.points - point).T) < NEAR)


def from_tips(solution: StepSolution, points: np.ndarray) -> np.ndarray:
    """Distance (n,) in spacings of points (n, 2) m from the nearest tip."""
    local = solution.cover.lattice.to_lattice(points)
    return np.min([np.hypot(*(local - tip.point).T) for tip in solution.cover.tips], axis=0)


@pytest.mark.parametrize("name", [*SCENES, *CUT])
def test_cells_fill_the_specimen_once_and_no_corner_lies_in_a_side_of_another(name: str) -> None:
    """Sides of one cell alone are those of the elements on outlines, and of both faces of cracks and interfaces."""
    if name in SCENES:
        cover = solved(name)[0].cover
    else:
        scene = make_scene(shipped_case(name))
        cover = assemble(scene, tuple(map(GrowingCrack.given, scene.case.cracks))).cover
    elements, mesh = cover.elements, output_mesh(cover.elements, cover.tips)
    pairs, n_cells = edges(mesh)
    assert set(n_cells.tolist()) == {1, 2}
    alone = np.hypot(*np.diff(mesh.points[pairs[n_cells == 1]], axis=1)[:, 0].T).sum()
    faces = np.where(elements.edges.right < 0, 1, np.where(elements.passable, 0, 2))
    length = np.hypot(*(elements.vertices[elements.edges.b] - elements.vertices[elements.edges.a]).T)
    assert alone == pytest.approx(faces @ length, rel=1e-9)
    start, end = elements.vertices[elements.rings.start], elements.vertices[elements.rings.end]
    whole, size = 0.5 * np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]), areas(mesh)
    assert size.sum() == pytest.approx(whole, rel=1e-9)
    assert size.min() > -4e-10  # counter-clockwise; needles along a lattice line may have no area
    used = np.concatenate([mesh.triangles.ravel(), mesh.quads.ravel()])
    np.testing.assert_array_equal(np.unique(used), np.arange(len(mesh.points)))


@pytest.mark.parametrize("name", SCENES)
def test_the_stress_of_a_node_is_that_of_each_element_that_meets_there(name: str) -> None:
    solution, frame = solved(name)
    mesh = output_mesh(solution.cover.elements, solution.cover.tips)
    node, element = mesh.place_node, mesh.place_element
    stress = stress_at(solution.cover, solution.state.materials, solution.outcome.u, mesh.points[node], element)
    off_tips = from_tips(solution, frame.points[node]) > 1e-6
    size = np.abs(stress[off_tips]).max()
    np.testing.assert_allclose(frame.point_stress[node[off_tips]], stress[off_tips], rtol=0, atol=1e-9 * size)


def test_a_uniform_stress_is_that_of_all_nodes() -> None:
    """Cut tiles, a kink and tips in rock whose cracks stick."""
    _, frame = solved("stuck")
    np.testing.assert_allclose(frame.point_stress, np.tile([0.0, -100e6, 0.0], (len(frame.points), 1)), atol=100.0)
    np.testing.assert_allclose(frame.point_stress_zz, -25e6, atol=100.0)


@pytest.mark.parametrize("name", SCENES)
def test_the_displacement_jumps_by_gap_and_slip_from_node_to_node(name: str) -> None:
    """Of each pair, the node on the plus face is the one in a cell on the left of the crack."""
    solution, frame = solved(name)
    cover, u = solution.cover, solution.outcome.u
    vertices = face_vertices(cover, 0)
    gap, slip = gap_and_slip(cover, vertices, u)
    jump = gap[:, None] * vertices.normal + slip[:, None] * np.stack([vertices.normal[:, 1], -vertices.normal[:, 0]], 1)
    tolerance = AT_TIP * np.abs(jump).max()
    n_pairs = 0
    for k, place in enumerate(cover.lattice.to_metres(vertices.points)):
        nodes = nodes_at(frame, place)
        found = frame.displacement[nodes[-1]] - frame.displacement[nodes[0]]  # zero at a tip
        assert min(np.abs(found - jump[k]).max(), np.abs(found + jump[k]).max()) < tolerance
        n_pairs += len(nodes) == 2
    assert n_pairs > 10


def test_stress_integrates_to_the_load() -> None:
    """Mean of sigma_yy times the volume is the load times the height, whatever the crack does (divergence theorem)."""
    _, frame = solved("closed")
    size = areas(frame)
    mean = size @ frame.stress / size.sum()
    # one point a cell, singular stress at two tips
    np.testing.assert_allclose(mean, [0.0, -100e6, 0.0], atol=0.5e6)
