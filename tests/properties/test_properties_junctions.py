"""Cracks that cross, touch and branch: a uniform stress passes through them, and symmetric scenes stay symmetric."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import shapely

from crackgrow.case.model import (
    Body,
    Case,
    ContactNumerics,
    CoulombContact,
    Crack,
    EdgeRegion,
    EdgeTraction,
    LoadHistory,
    Material,
    Numerics,
    Output,
    PointSupport,
    Ring,
)
from crackgrow.contact.coulomb import OPEN, SLIP, STICK
from crackgrow.contact.jump import gap_and_slip
from crackgrow.cover.elements import locate
from crackgrow.cover.refinement import Focus, refined
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.judging import StepSolution
from crackgrow.run.scene import Scene, make_scene
from crackgrow.solid.recovery import displacement_at
from tests.solving import face_vertices, solve_step

SIZE = np.array([31.0, 55.0])  # mm, round the origin
YOUNG, POISSON, LOAD = 1e10, 0.25, 1e8  # Pa
LOWER_EDGE = np.array([0.0, -0.5 * SIZE[1]])
WHOLE = np.array([[0.0, 1.0]])
HOLE = [(-3.0, 1.0), (-1.5, 4.0), (1.5, 4.5), (3.0, 1.5), (0.5, -1.0)]  # clockwise
BESIDE_HOLE = (2.25, 3.0)  # on its rim

Paths = tuple[tuple[tuple[float, float], ...], ...]


def plate(
    paths: Paths, friction: float, support: float, spacing: float, hole: bool, turned: bool, quadrature: int
) -> Case:
    """A plate pressed along y, with cracks (mm); or all of it turned by 90 degrees counter-clockwise.

    The hole's rim carries what the uniform stress would have it carry.
    """
    turn = np.array([[0.0, -1.0], [1.0, 0.0]]) if turned else np.eye(2)
    stress = turn @ np.diag([0.0, -LOAD]) @ turn.T

    def placed(points: Any) -> np.ndarray:
        return 1e-3 * np.array(points, dtype=float) @ turn.T

    x, y = 0.5 * SIZE
    rings, loads, first = [], [], 0
    for corners in ([(-x, -y), (x, -y), (x, y), (-x, y)], *([HOLE] if hole else [])):
        points = placed(corners)
        names = tuple(f"edge {first + k}" for k in range(len(points)))
        rings.append(Ring(points, names))
        for k, step in enumerate(np.roll(points, -1, axis=0) - points):
            traction = stress @ np.array([step[1], -step[0]]) / np.hypot(*step)
            loads.append(EdgeTraction(EdgeRegion("rock", names[k], np.array([first + k]), WHOLE), tuple(traction)))
        first += len(points)
    along, across = ((0.0, None), (None, 0.0)) if turned else ((None, 0.0), (0.0, None))
    supports = tuple(
        PointSupport("rock", placed(place), held)
        for place, held in (((-x, -y), along), ((x, -y), along), ((0.0, -y), across))
    )
    contact = CoulombContact(friction, 0.0, friction, False)
    return Case(
        name="junctions",
        title="cracks that meet",
        source="",
        plane="strain",
        bodies=(Body("rock", tuple(rings), Material(YOUNG, POISSON), None),),
        cracks=tuple(Crack(str(k), placed(path), True, True, contact, "rock") for k, path in enumerate(paths)),
        interfaces=(),
        supports=supports,
        loads=tuple(loads),
        loading=LoadHistory((1.0,)),
        growth=None,
        numerics=Numerics(
            spacing=spacing * 1e-3, support=support, quadrature=quadrature, contact=ContactNumerics(spacing=1.25)
        ),
        output=Output("none", (), False),
        resolved={},
    )


@cache
def solved(
    paths: Paths,
    friction: float,
    support: float = 2.0,
    spacing: float = 1.5,
    hole: bool = False,
    turned: bool = False,
    quadrature: int = 3,
    levels: int = 0,
) -> tuple[Scene, StepSolution]:
    """With `levels` cells are halved so often round all vertices of the cracks, and where these meet."""
    case = plate(paths, friction, support, spacing, hole, turned, quadrature)
    scene = make_scene(case)
    if levels:
        lines = [shapely.LineString(scene.lattice.to_lattice(crack.points)) for crack in case.cracks]
        meetings = [one.intersection(other) for one, other in combinations(lines, 2)]
        places = shapely.points(shapely.get_coordinates([*lines, *meetings]))
        scene = replace(scene, lattice=refined(scene.lattice, Focus(places, np.full(len(places), 0.5**levels), 2.0)))
    growing = tuple(map(GrowingCrack.given, case.cracks))
    return scene, solve_step(scene, growing, 1.0)


MAIN = ((-6.0, -2.0), (6.0, 2.0))
STEEP = ((-1.0, -7.0), (2.0, 8.0))
ACROSS = ((-15.5, -3.0), (15.5, 4.0))
LAYOUTS: dict[str, Paths] = {
    "from the outline": (((-15.5, -2.0), (3.0, 3.0)),),
    "T": (MAIN, ((0.0, 0.0), (1.0, 8.0))),
    "X": (MAIN, STEEP),
    "three through a point": (MAIN, ((-1.0, -7.0), (1.0, 7.0)), ((-5.0, 4.0), (5.0, -4.0))),
    "Y": (((-6.0, -2.0), (0.0, 0.0)), ((0.0, 0.0), (3.0, 7.0)), ((0.0, 0.0), (6.0, -4.0))),
    "V": (((-6.0, -2.0), (0.0, 0.0)), ((0.0, 0.0), (1.0, 8.0))),
    "branch near a tip": (MAIN, ((5.0, 5.0 / 3.0), (6.0, 5.0))),
    "oblique branch": (MAIN, ((0.0, 0.0), (5.0, 3.0))),
    "through": (ACROSS,),
    "through, and one across": (ACROSS, ((-1.0, -7.0), (1.0, 7.0))),
    "onto a hole": (((-12.0, -3.0), (-3.0, 1.0)), (BESIDE_HOLE, (9.0, 7.0))),
    "lattice lines": (((-6.0, 0.0), (6.0, 0.0)), ((0.0, -6.0), (0.0, 6.0))),
    "ring": (((-6.0, -2.0), (6.0, 2.0), (0.0, -7.0), (-6.0, -2.0)),),
    "triangle": (MAIN, ((-5.0, -6.0), (3.0, 7.0)), ((-3.0, 7.0), (5.0, -6.0))),
}
STICKY = 10.0


@pytest.mark.parametrize(
    ("support", "levels"),
    [
        (2.0, 0),
        (2.0, 2),
        pytest.param(1.5, 0, marks=pytest.mark.slow),
        pytest.param(2.5, 0, marks=pytest.mark.slow),
        pytest.param(1.5, 3, marks=pytest.mark.slow),
        pytest.param(2.0, 6, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("name", LAYOUTS)
def test_uniform_compression_passes_through_stuck_cracks(name: str, support: float, levels: int) -> None:
    """Vertices are rounded by 1e-9 spacings, which tips on patches that only just hold them see enlarged."""
    scene, solution = solved(LAYOUTS[name], STICKY, support, hole=name == "onto a hole", levels=levels)
    metres = 1e-3 * np.random.default_rng(90).uniform(-0.5 * SIZE, 0.5 * SIZE, (800, 2))
    points = scene.lattice.to_lattice(metres)
    elements = locate(scene.lattice, solution.cover.elements, points)
    metres, points, elements = (values[elements >= 0] for values in (metres, points, elements))
    found = displacement_at(solution.cover, solution.outcome.u, points, elements)
    strain = LOAD / YOUNG * (1 + POISSON) * np.array([POISSON, POISSON - 1])
    exact = strain * (metres - 1e-3 * LOWER_EDGE)
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()
    outcome, normal = solution.outcome, solution.faces.nodes.normal
    np.testing.assert_allclose(outcome.points.normal, -LOAD * normal[:, 1] ** 2, atol=1e-5 * LOAD)
    np.testing.assert_allclose(outcome.points.tangential, LOAD * normal[:, 0] * normal[:, 1], atol=1e-5 * LOAD)
    assert solution.outcome.residual < 1e-7


NODE = (-1.5, -1.5)
"""mm: a node of the plate's lattice at a spacing of 1.5 mm, where tile lines cross."""
PEEKING = [
    ((-1.693, -0.0416), (0.007, 0.1398), (-1.893, 1.3907)),
    ((-1.6917, 1.3946), (0.0083, 0.9371), (-1.8917, 1.6565)),
    ((-1.6843, 0.7169), (0.0157, 0.3363), (-1.8843, 0.9623)),
]
"""Spacings from there: cracks whose kink lies a few thousandths of a spacing over a tile line."""


@pytest.mark.parametrize("kink", PEEKING)
def test_a_kink_just_over_a_tile_line_leaves_contact_reciprocal(kink: tuple[tuple[float, float], ...]) -> None:
    """The gap at one contact point by a force at another is the gap there by the same force here (Betti)."""
    path = tuple((NODE[0] + 1.5 * x, NODE[1] + 1.5 * y) for x, y in kink)
    contact = solved((path,), STICKY)[1].contact
    S = contact.rock / np.tile(contact.weights, 2)
    assert np.linalg.eigvalsh(0.5 * (S + S.T)).min() > 0.0
    np.testing.assert_allclose(S, S.T, atol=3e-6 * np.abs(S).max())


def counterparts(solution: StepSolution, other: StepSolution, matrix: np.ndarray) -> np.ndarray:
    """Contact point of `other` (n,) at the place, turned or mirrored by `matrix` (2, 2), of each of `solution`."""
    here = solution.cover.lattice.to_metres(solution.faces.nodes.points) @ matrix.T
    there = other.cover.lattice.to_metres(other.faces.nodes.points)
    distance = np.hypot(*(here[:, None] - there[None]).transpose(2, 0, 1))
    assert distance.min(axis=1).max() < 1e-9
    return distance.argmin(axis=1)


def stress_vectors(solution: StepSolution) -> np.ndarray:
    """Normal traction and the shear stress vector turned into a number: along x times the sign of the normal's y."""
    normal = solution.faces.nodes.normal
    outcome = solution.outcome
    tangent = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    return outcome.points.normal[:, None] * normal + outcome.points.tangential[:, None] * tangent


def differences(solution: StepSolution, other: StepSolution, matrix: np.ndarray) -> float:
    """Largest difference of the tractions at counterparts over the load."""
    pair = counterparts(solution, other, matrix)
    expected, found = stress_vectors(solution) @ matrix.T, stress_vectors(other)[pair]
    same = np.sum(solution.faces.nodes.normal @ matrix.T * other.faces.nodes.normal[pair], axis=1)
    assert np.abs(np.abs(same) - 1.0).max() < 1e-6
    return float(np.abs(expected - np.sign(same)[:, None] * found).max() / LOAD)


CROSS: Paths = (((-6.0, -4.0), (6.0, 4.0)), ((-6.0, 4.0), (6.0, -4.0)))
ARROW: Paths = (((0.0, -7.0), (0.0, 0.0)), ((0.0, 0.0), (6.0, 4.0)), ((-6.0, 4.0), (0.0, 0.0)))
ORIENTATION = 1e-9


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(
    ("paths", "mirror"), [(CROSS, (-1.0, 1.0)), (CROSS, (1.0, -1.0)), (ARROW, (-1.0, 1.0))], ids=["X x", "X y", "Y x"]
)
def test_mirrored_points_carry_the_same(paths: Paths, mirror: tuple[float, float], friction: float) -> None:
    _, solution = solved(paths, friction)
    assert SLIP in solution.outcome.points.state
    assert differences(solution, solution, np.diag(mirror)) < ORIENTATION
    K = np.array([tip.K for tip in solution.tips])
    ends = solution.cover.lattice.to_metres(np.array([tip.point for tip in solution.cover.tips]))
    pair = np.hypot(*(ends[:, None] * mirror - ends[None]).transpose(2, 0, 1)).argmin(axis=1)
    np.testing.assert_allclose(K[pair] * (1.0, -1.0), K, atol=2.0 * ORIENTATION * np.abs(K).max())


@pytest.mark.parametrize("name", ["T", "X", "three through a point", "Y", "V", "oblique branch"])
def test_slipping_branches_neither_overlap_nor_tear_the_rock(name: str) -> None:
    _, solution = solved(LAYOUTS[name], 0.0)
    cover, outcome = solution.cover, solution.outcome
    size = np.abs(outcome.points.slip).max()
    assert (outcome.points.state == SLIP).any()
    assert STICK not in outcome.points.state
    assert outcome.points.normal.max() <= 0.0
    assert outcome.points.opening[outcome.points.state != OPEN] == pytest.approx(0.0, abs=1e-9 * size)
    assert outcome.points.opening.min() > -1e-9 * size
    edges, elements = cover.elements.edges, cover.elements
    inner = np.flatnonzero((edges.right >= 0) & ~elements.is_crack)
    for share in (0.1, 0.5, 0.9):
        a, b = elements.vertices[edges.a[inner]], elements.vertices[edges.b[inner]]
        sides = [
            displacement_at(cover, outcome.u, a + share * (b - a), side[inner]) for side in (edges.left, edges.right)
        ]
        np.testing.assert_allclose(*sides, atol=1e-6 * size)
    slips = [gap_and_slip(cover, face_vertices(cover, k), outcome.u)[1] for k in range(len(cover.cracks))]
    assert min(np.abs(slip).max() for slip in slips) > 1e-3 * size
