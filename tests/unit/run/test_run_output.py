"""The output mesh and its fields; the course of named points; what faces and tips do on the way."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from crackgrow.case.load import read_case
from crackgrow.contact.jump import gap_and_slip
from crackgrow.fracture.opening import kinked_release
from crackgrow.run.checkpoint import beginning
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.frame import OutputMesh, make_frame, output_mesh
from crackgrow.run.layout import cover_of
from crackgrow.run.loading import LoadsInTurn
from crackgrow.run.loop import grow
from crackgrow.run.result import Frame, StepResult
from crackgrow.run.scene import make_scene
from crackgrow.run.state_values import history_of
from crackgrow.solid.elasticity import plane_elasticity
from crackgrow.solid.recovery import stress_at
from tests.scenes import shipped_case
from tests.solving import face_vertices, seen, solve_case, steps_of, whole_run
from tests.verification.solutions import QUIET

NEAR = 1e-9
"""m: vertices lie on a grid of 1e-12 m; no two of them are nearer than 1e-6 m here."""

AT_TIP = 1e-4
"""Relative jump at a tip: vertices lie off it by the grid of 1e-9 spacings, and the jump grows as the square root."""

WING = "cracks.flaw.path={points: [[-4.33, -2.5], [4.33, 2.5], [3.98, 4.47]]}"
KINKED = "cracks.flaw.path={points: [[-4.33, -2.5], [4.33, 2.5], [3.98, 4.47], [4.33, 6.44]]}"
SCENES = {
    "closed": ("compression30",),
    "open": ("tension0",),
    "kinked": ("compression30", KINKED),
    "finer tiles": ("compression30", WING, "numerics.support=1.75", "numerics.spacing=1.5"),
}
"""Scenes and settings."""


CUT = ("flaw_and_hole", "interface_friction04", "junction_static", "en_echelon")
"""Scenes with curved outlines, several bodies, cracks that meet."""


@cache
def solved(file: str, *settings: str) -> tuple[StepSolution, Frame]:
    solution = solve_case(shipped_case(file, settings))
    return solution, make_frame(solution.cover, solution.scene.materials, solution.outcome.u)


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


@pytest.mark.parametrize("name", [*SCENES, *CUT])
def test_cells_fill_the_specimen_once_and_no_corner_lies_in_a_side_of_another(name: str) -> None:
    """Sides of one cell alone are those of the elements on outlines, and of both faces of cracks and interfaces."""
    file, *settings = SCENES.get(name, (name,))
    case = shipped_case(file, settings)
    cover = cover_of(make_scene(case), beginning(case).cracks)
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
    solution, frame = solved(*SCENES[name])
    mesh = output_mesh(solution.cover.elements, solution.cover.tips)
    node, element = mesh.place_node, mesh.place_element
    stress = stress_at(solution.cover, solution.materials, solution.outcome.u, mesh.points[node], element)
    places = solution.cover.lattice.to_lattice(frame.points[node])
    off_tips = np.min([np.hypot(*(places - tip.point).T) for tip in solution.cover.tips], axis=0) > 1e-6  # spacings
    size = np.abs(stress[off_tips]).max()
    np.testing.assert_allclose(frame.point_stress[node[off_tips]], stress[off_tips], rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(frame.point_stress_zz, 0.25 * frame.point_stress[:, :2].sum(axis=1), atol=1e-9 * size)


@pytest.mark.parametrize("name", SCENES)
def test_the_displacement_jumps_by_gap_and_slip_from_node_to_node(name: str) -> None:
    """Of each pair, the node on the plus face is the one in a cell on the left of the crack."""
    solution, frame = solved(*SCENES[name])
    cover, u = solution.cover, solution.outcome.u
    vertices = face_vertices(cover, 0)
    gap, slip = gap_and_slip(cover, vertices, u)
    jump = gap[:, None] * vertices.normal + slip[:, None] * np.stack([vertices.normal[:, 1], -vertices.normal[:, 0]], 1)
    tolerance = AT_TIP * np.abs(jump).max()
    n_pairs = 0
    for k, place in enumerate(cover.lattice.to_metres(vertices.points)):
        nodes = np.flatnonzero(np.hypot(*(frame.points - place).T) < NEAR)
        found = frame.displacement[nodes[-1]] - frame.displacement[nodes[0]]  # zero at a tip
        assert min(np.abs(found - jump[k]).max(), np.abs(found + jump[k]).max()) < tolerance
        n_pairs += len(nodes) == 2
    assert n_pairs > 10


def test_the_errors_of_cells_add_up_to_the_estimate() -> None:
    case = shipped_case("compression30", ["numerics.spacing=3", "growth.steps=1", "output.fields=[energy_error]"])
    results, end = whole_run(case)
    for result, expected in zip(results, (results[0].norm_error, end.norm_error), strict=True):
        assert result.frame is not None
        assert result.frame.error_density is not None
        share = areas(result.frame) @ result.frame.error_density**2 / areas(result.frame).sum()
        np.testing.assert_allclose(100.0 * np.sqrt(share), expected, rtol=1e-9)


YOUNG, STRESS = 1e9, 1e6  # Pa

BAR = """
title: a bar
plane: stress
bodies:
  rock:
    shape: {rectangle: {center: [0, 0], width: 0.02, height: 0.04}}
    material: {young: 1e9, poisson: 0.25}
supports:
  - {on: {body: rock, edge: bottom}, displacement: {y: 0}}
  - {at: [0, -0.02], displacement: {x: 0}}
loads: [{on: {body: rock, edge: top}, traction: [0, 1e6]}]
loading: {history: [0.5, -1]}
numerics: {spacing: 0.004}
output: {frames: none, figures: false, points: {corner: {at: [0.01, 0.02]}, gauge: {between: [[0, -0.01], [0, 0.01]]}}}
"""


def test_points_of_a_bar_in_tension_have_its_exact_fields() -> None:
    steps, stress = steps_of(BAR), STRESS * np.array([0.5, -1.0])
    strain = stress / YOUNG
    exact = {"corner.u_x": -0.25 * 0.01 * strain, "corner.u_y": 0.04 * strain, "corner.stress_yy": stress}
    exact |= {"supports.0.force_y": -0.02 * stress}
    for column, values in exact.items():
        np.testing.assert_allclose(seen(steps, column), values, rtol=1e-9, err_msg=column)
    np.testing.assert_allclose(seen(steps, "gauge.convergence"), -0.02 * strain, rtol=1e-8)
    assert np.abs(seen(steps, "corner.stress_xy")).max() < 1e-3


def test_loads_that_are_gone_through_again_are_not_in_the_history_of_the_next() -> None:
    """On other cells the second load is asked for at once; its history begins behind the first."""
    scene = make_scene(read_case(BAR, "scene", "scene"))
    solution = LoadsInTurn(scene, ()).solution(1)
    assert [state.factor for state in (*solution.passed, *history_of(solution))] == [-1.0]


def test_the_way_to_a_critical_load_is_that_of_the_load_itself() -> None:
    """A flaw that sticks up to its cohesion and slips: slip lies on the line of one increment to the same load."""
    law = "cracks.flaw.contact={friction: 0.3, cohesion: 2, cohesion_after_slip: kept}"
    cells = ("growth.steps=0", "numerics.spacing=1.5", "output.points={mouth: {crack: flaw, at: [0, 0]}}")
    strong = "bodies.rock.strength={tension: 60, cohesion: 100, friction_angle: 40}"
    settings = (*cells, law, strong, "growth.criterion=max_hoop_stress")

    def under(loading: str) -> tuple[np.ndarray, np.ndarray]:
        """Load factors and slip, state by state."""
        step = next(grow(shipped_case("compression30", [*settings, f"loading={loading}"])))
        assert step.history is not None
        return step.history.load_factor, seen([step], "mouth.slip")

    factors, slip = under("critical")
    known = under(f"{{history: [{float(factors[-1])!r}]}}")
    assert len(factors) > len(known[0]) > 1  # it makes for other loads first
    assert np.all(np.diff(factors) > 0.0)
    np.testing.assert_allclose(slip, np.interp(factors, *known), rtol=0, atol=1e-7 * np.abs(slip).max())


FLAW = "cracks.flaw.contact"
DRAFT = ("numerics.accuracy=draft", *QUIET)


def energy(step: StepResult, kind: str) -> float:
    """Of all emissions of a kind, J/m."""
    return sum(event.energy for event in step.emissions if event.kind == kind)


@pytest.mark.parametrize(
    ("scene", "settings"),
    [
        ("cyclic_friction", ("numerics.spacing=5",)),  # slips to and fro
        ("vein_in_tension", ()),  # breaks
        ("09_wear", ()),  # wears by slip
        ("interface_friction04", ()),
        (
            "confined30",
            (f"{FLAW}.cohesion=5", "growth.steps=1", "numerics.spacing=3"),
        ),  # slips, breaks and opens from rest, then grows
    ],
)
def test_emissions_of_a_step_add_up_to_its_energies(scene: str, settings: tuple[str, ...]) -> None:
    case = shipped_case(scene, (*DRAFT, *settings))
    steps, _ = whole_run(case)
    energies = np.array([(step.energy.dissipated, step.energy.released) for step in steps])
    if case.growth is None:
        energies = np.diff(energies, axis=0, prepend=np.zeros((1, 2)))
    told = [(energy(step, "slip"), energy(step, "break")) for step in steps]
    assert np.abs(energies).max() > 0.0
    np.testing.assert_allclose(told, energies, rtol=0, atol=1e-12 * np.abs(energies).max())


def flaw(y: float, angle: float) -> str:
    """With cohesion and friction, at a height and an angle to x."""
    return f"{{path: {{center: [0, {y}], length: 8, angle: {angle}}}, contact: {{friction: 0.2, cohesion: 3}}}}"


def test_faces_slip_at_the_load_at_which_the_plane_through_them_would_and_the_first_is_told_first() -> None:
    """Stress in the plate under 100 MPa is uniform until one slips: p sin cos = c + mu p cos^2."""
    cracks = f"cracks={{flat: {flaw(14, 30)}, steep: {flaw(-14, 50)}}}"
    (step,), _ = whole_run(shipped_case("compression30", (*DRAFT, cracks, "growth.steps=0")))
    assert [event.kind for event in step.emissions if event.crack == "steep"][:2] == ["break", "slip"]
    slips = {event.crack: event.load_factor for event in step.emissions if event.kind == "slip"}
    assert list(slips) == ["steep", "flat"]
    s, c = np.sin(np.deg2rad(50.0)), np.cos(np.deg2rad(50.0))
    assert slips["steep"] == pytest.approx(3.0 / (s * c - 0.2 * c**2) / 100.0, rel=1e-7)


def test_faces_open_where_they_were_pressed_and_the_load_takes_that_back() -> None:
    """A plate is pressed by 6 MPa and pulled by as much as 10: its crack opens at 0.6 of that, and told it is once."""
    loads = "loads=[{far_field: [0, -6, 0], held: true}, {far_field: [0, 10, 0]}]"
    case = shipped_case("tension0", (*DRAFT, loads, f"{FLAW}={{friction: 0.3, cohesion: 0}}", "growth.steps=0"))
    (step,), _ = whole_run(case)
    (opening,) = (event for event in step.emissions if event.kind == "opening")
    assert opening.load_factor == pytest.approx(0.6, rel=1e-6)


def test_growth_under_load_releases_what_its_events_say() -> None:
    """G rises by some percent along an increment of a fiftieth of the crack, and is told of its beginning."""
    settings = ("growth.steps=2", "growth.increment=0.2", "growth.unload_between_steps=false", "loading={history: [1]}")
    first, second, third = whole_run(shipped_case("tension0", (*DRAFT, *settings, "numerics.accuracy=fine")))[0]
    for before, after in ((first, second), (second, third)):
        released = after.energy.released - before.energy.released
        assert 0.97 * released < energy(before, "growth") < released


def test_a_tip_releases_what_Irwin_says_and_beside_it_what_a_kink_does() -> None:
    """By the series of Amestoy and Leblond 1992 at 20 degrees, where the first order is 2 % low."""
    rock = plane_elasticity(1.0, 0.3, "stress")
    assert kinked_release((3.0, 4.0), 0.0, rock) == pytest.approx(25.0, rel=1e-15)
    assert kinked_release((-3.0, 0.0), 0.0, rock) == 0.0  # faces that overlap
    m = 1.0 / 9.0
    k_1 = 1.5 * np.pi * m - (10.0 * np.pi / 3.0 + np.pi**3 / 16.0) * m**3
    k_2 = 1.0 - (4.0 + 3.0 * np.pi**2 / 8.0) * m**2 + (8 / 3 + 29 * np.pi**2 / 18 - 5 * np.pi**4 / 128) * m**4
    assert kinked_release((0.0, 1.0), -m * np.pi, rock) == pytest.approx(k_1**2 + k_2**2, rel=0.025)
