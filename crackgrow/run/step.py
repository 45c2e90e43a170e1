"""One step: cover, assembly, factorization, contact and criterion for one configuration of the cracks.

A pure function of the scene and the cracks: every step starts from the unloaded state.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.faces import ContactFaces, gauss_faces, mortar_faces
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.solve import ContactLaw, ContactOutcome, solve_contact
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.elements import CrackGeometry
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import CRITERIA, Verdict
from crackgrow.fracture.stress_intensity import from_face_displacement
from crackgrow.fracture.tip_stress import tip_field
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.scene import Scene
from crackgrow.solid.linear_solver import ConstrainedSystem, displacement_size
from crackgrow.solid.loads import load_vector
from crackgrow.solid.rigid_modes import check_held
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import constraints

Floats = NDArray[np.float64]

ON_OUTLINE = 1e-9
"""A crack end closer to an outline than this fraction of its length lies on it."""

WORST_RESIDUAL = 1e-5
"""Relative equilibrium residual beyond which a solution is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class TipState:
    """Fracture quantities of one tip of the cover."""

    K_I: float  # Pa sqrt(m)
    K_II: float  # Pa sqrt(m)
    verdict: Verdict | None  # None without growth


@dataclass(frozen=True, slots=True, eq=False)
class StepSolution:
    """Everything that is known of a solved configuration."""

    cover: Cover
    faces: ContactFaces
    outcome: ContactOutcome
    tips: tuple[TipState, ...]
    displacement_size: float  # m
    residual: float  # relative equilibrium residual
    seconds: dict[str, float]


def solve_step(scene: Scene, growing: tuple[GrowingCrack, ...], load_factor: float) -> StepSolution:
    """Solve one configuration. Raises GeometryError or SolveError where that can't be done to a small residual."""
    case = scene.case
    seconds: dict[str, float] = {}
    with _timed(seconds, "cover"):
        outlines = [scene.lattice.to_lattice(body.outline) for body in case.bodies]
        cover = build_cover(scene.lattice, outlines, [_geometry(scene, g) for g in growing])
    with _timed(seconds, "assembly"):
        matrix = stiffness(cover, scene.materials, case.numerics.quadrature)
        rows, given = constraints(cover, case.bodies, case.supports)
        check_held(cover, rows)
        loads = load_factor * load_vector(cover, case.bodies, case.loads)
    with _timed(seconds, "factorize"):
        system = ConstrainedSystem(matrix, rows, max(material.c33 for material in scene.materials))
    with _timed(seconds, "contact"):
        faces = _faces(scene, cover, growing)
        operators = contact_operators(cover, faces)
        weights = faces.weights * scene.lattice.spacing
        law = _law(scene, faces, growing)
        outcome = solve_contact(
            system, loads, load_factor * given, operators, weights, law, case.numerics.contact.solver
        )
        residual = _residual(system, loads, operators, weights, outcome)
        if not residual <= WORST_RESIDUAL:
            raise SolveError(
                f"the equilibrium residual is {residual:.2g}, more than {WORST_RESIDUAL:g}: the system is too ill "
                "conditioned; a tip may lie too close to another one or to an outline for this spacing"
            )
    with _timed(seconds, "criterion"):
        tips = tuple(_tip_state(scene, cover, outcome.u, tip) for tip in range(len(cover.tips)))
    size = displacement_size(loads, outcome.u, load_factor * given)
    return StepSolution(cover, faces, outcome, tips, size, residual, seconds)


def _geometry(scene: Scene, growing: GrowingCrack) -> CrackGeometry:
    """The crack in lattice coordinates. An end is a tip unless it lies on an outline, whether it can grow or not."""
    points = growing.crack.points.copy()
    inside = [True, True]
    for index, end in enumerate((0, -1)):
        for region in scene.regions:
            place = shapely.Point(points[end])
            if shapely.dwithin(region.boundary, place, ON_OUTLINE * region.length):
                points[end] = region.boundary.interpolate(region.boundary.project(place)).coords[0]
                inside[index] = False
    return CrackGeometry(growing.crack.name, scene.lattice.to_lattice(points), *inside)


def _faces(scene: Scene, cover: Cover, growing: tuple[GrowingCrack, ...]) -> ContactFaces:
    touching = [index for index, g in enumerate(growing) if g.crack.contact is not None]
    settings = scene.case.numerics.contact
    if settings.discretization == "gauss":
        return gauss_faces(cover, touching)
    return mortar_faces(cover, touching, settings.spacing)


def _law(scene: Scene, faces: ContactFaces, growing: tuple[GrowingCrack, ...]) -> ContactLaw:
    """Friction and cohesion point by point. Faces that growth has made are broken: they have no cohesion."""
    friction, cohesion = np.zeros(faces.n), np.zeros(faces.n)
    for index, g in enumerate(growing):
        if g.crack.contact is None:
            continue
        mine = faces.crack == index
        friction[mine] = g.crack.contact.friction
        given = arc_lengths(scene.lattice.to_lattice(g.crack.points))[g.steps == 0]
        bonded = (faces.s >= given[0]) & (faces.s <= given[-1])
        cohesion[mine & bonded] = g.crack.contact.cohesion
    return ContactLaw(friction, cohesion, np.full(faces.n, scene.contact_compliance))


def _residual(
    system: ConstrainedSystem,
    loads: Floats,
    operators: tuple[csr_array, csr_array],
    weights: Floats,
    outcome: ContactOutcome,
) -> float:
    """Equilibrium residual K u + C' m + G' W p - f, relative to the largest of its parts."""
    internal = system.stiffness @ outcome.u
    reactions = system.constraints.T @ outcome.multipliers
    contact = operators[0].T @ (weights * outcome.normal_traction)
    contact = contact + operators[1].T @ (weights * outcome.tangential_traction)
    parts = (internal, reactions, contact, loads)
    size = max(np.abs(part).max(initial=0.0) for part in parts)
    residual = np.abs(internal + reactions + contact - loads).max(initial=0.0)
    return float(residual / size) if size > 0.0 else 0.0


def _tip_state(scene: Scene, cover: Cover, u: Floats, tip: int) -> TipState:
    case = scene.case
    k_1, k_2 = from_face_displacement(cover, scene.materials[0].young_prime, u, tip)
    strength = case.bodies[0].strength
    if case.growth is None or strength is None:
        return TipState(k_1, k_2, None)
    field = tip_field(cover, scene.materials, u, tip, case.growth.tip_radius)
    return TipState(k_1, k_2, CRITERIA[case.growth.criterion](field, strength))


@contextmanager
def _timed(seconds: dict[str, float], phase: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[phase] = time.perf_counter() - start
