"""One step: cover, assembly, factorization, contact and criterion for one configuration of the cracks.

A pure function of the scene and the cracks: every step starts from the unloaded state.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, vstack

from crackgrow.contact.coulomb import OPEN, STICK
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.contact.faces import ContactFaces, gauss_faces, mortar_faces
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.solve import (
    ContactLaw,
    ContactOutcome,
    ContactSystem,
    solve_contact,
    solve_contact_held_loosely,
)
from crackgrow.contact.tractions import between_contact_points, elastic_tractions
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.criteria import CRITERIA, TipLoading, Verdict
from crackgrow.fracture.interaction_integral import StressIntensity, interaction_integral
from crackgrow.fracture.stress_intensity import from_face_displacement
from crackgrow.fracture.tip_stress import tip_field
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.run.scene import Scene
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.linear_solver import ConstrainedSystem, displacement_size
from crackgrow.solid.loads import load_vector
from crackgrow.solid.rigid_modes import check_held, free_pieces, loose_springs, named
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import Constraints, constraints, tied

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ON_OUTLINE = 1e-9
"""A crack end closer to an outline than this fraction of its length lies on it."""

UNSTRESSED = 1e-6
"""Forces below this fraction of the terms that they are the sum of are no forces."""

WORST_RESIDUAL = 1e-5
"""Relative equilibrium residual beyond which a solution is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class TipState:
    """Fracture quantities of one tip of the cover."""

    intensity: StressIntensity
    K_faces: tuple[float, float]  # Pa sqrt(m): K_I and K_II from the displacement of the faces, as a check
    verdict: Verdict | None  # None without growth

    @property
    def K(self) -> tuple[float, float]:
        """K_I and K_II (Pa sqrt(m)) to go by: the integral's, or the faces' where the integral finds no room."""
        found = (self.intensity.K_I, self.intensity.K_II)
        return found if np.isfinite(found).all() else self.K_faces


@dataclass(frozen=True, slots=True, eq=False)
class StepSolution:
    """Everything that is known of a solved configuration."""

    cover: Cover
    materials: tuple[PlaneElasticity, ...]  # body by body, in-situ stress included
    held: Constraints
    contact: ContactSystem
    loads: Floats  # (n_dofs,) N/m
    faces: ContactFaces
    outcome: ContactOutcome
    tips: tuple[TipState, ...]
    displacement_size: float  # m
    residual: float  # relative equilibrium residual
    seconds: dict[str, float]
    factorizations: int = 1  # solves that it took, those of rejected directions included
    notes: tuple[str, ...] = ()  # what the user should know of how it was found


def solve_step(scene: Scene, growing: tuple[GrowingCrack, ...], load_factor: float) -> StepSolution:
    """Solve one configuration. Raises GeometryError or SolveError where that can't be done to a small residual."""
    case = scene.case
    seconds: dict[str, float] = {}
    materials = scene.materials_at(load_factor)
    with _timed(seconds, "cover"):
        cracks = [_geometry(scene, g, body) for g, body in zip(growing, scene.crack_bodies, strict=True)]
        cover = build_cover(scene.lattice, scene.bodies, cracks, scene.interfaces, scene.foundations)
    with _timed(seconds, "assembly"):
        matrix = stiffness(cover, materials, case.numerics.quadrature)
        faces = _faces(scene, cover)
        operators = contact_operators(cover, faces)
        held = tied(constraints(cover, case.bodies, case.supports), *_bonds(scene, cover))
        given = load_factor * held.given
        loads = load_vector(cover, case.bodies, case.loads, case.numerics.quadrature)
        loads = load_factor * (loads + face_load_vector(cover, [g.crack.body for g in growing], case.loads))
        free = free_pieces(cover, held.matrix)
        check_held(free, _patches_at(cover, faces))
    with _timed(seconds, "factorize"):
        springs = loose_springs(cover, matrix, free) if free else None
        system = ConstrainedSystem(matrix if springs is None else springs.added_to(matrix), held.matrix)
    with _timed(seconds, "contact"):
        weights = faces.weights * scene.lattice.spacing
        law = _law(scene, faces, growing)
        contact = ContactSystem(system, *operators, weights, law, case.numerics.contact.solver, loose=bool(free))
        if springs is None:
            outcome = solve_contact(contact, loads, given)
        else:
            outcome = solve_contact_held_loosely(contact, springs, free, loads, given)
            notes = (*outcome.notes, *_unheld(cover, contact, outcome))
            outcome = replace(outcome, notes=notes)
        residual = _residual(matrix, contact, loads, outcome)
        if not residual <= WORST_RESIDUAL:
            raise SolveError(
                f"the equilibrium residual is {residual:.2g}, more than {WORST_RESIDUAL:g}: the system is too ill "
                "conditioned" + ("; a tip may lie too close to another one or to an outline" if cover.tips else "")
            )
    with _timed(seconds, "criterion"):
        tips = tuple(
            _tip_state(scene, cover, materials, faces, outcome, load_factor, tip) for tip in range(len(cover.tips))
        )
    size = displacement_size(loads, outcome.u, given)
    return StepSolution(cover, materials, held, contact, loads, faces, outcome, tips, size, residual, seconds)


def _geometry(scene: Scene, growing: GrowingCrack, body: int) -> CrackGeometry:
    """The crack in lattice coordinates. An end is a tip unless it lies on its body's rim, whether it can grow or not.

    `body` is the one that it lies in.
    """
    points = growing.crack.points.copy()
    inside = [True, True]
    boundary = scene.regions[body].boundary
    for index, end in enumerate((0, -1)):
        place = shapely.Point(points[end])
        if shapely.dwithin(boundary, place, ON_OUTLINE * boundary.length):
            points[end] = shapely.shortest_line(boundary, place).coords[0]
            inside[index] = False
    return CrackGeometry(growing.crack.name, scene.lattice.to_lattice(points), inside[0], inside[1])


def _faces(scene: Scene, cover: Cover) -> ContactFaces:
    touching = [index for index, law in enumerate(scene.laws) if law.contact is not None]
    settings = scene.case.numerics.contact
    if settings.discretization == "gauss":
        return gauss_faces(cover, touching)
    return mortar_faces(cover, touching, settings.spacing)


def _bonds(scene: Scene, cover: Cover) -> tuple[csr_array, Ints]:
    """Gap and slip (k, n_dofs) of bonded interfaces, averaged at mortar nodes, and the surface (k,) of each."""
    bonded = [index for index, law in enumerate(scene.laws) if law.bonded]
    faces = mortar_faces(cover, bonded, scene.case.numerics.contact.spacing)
    return csr_array(vstack(contact_operators(cover, faces), format="csr")), np.tile(faces.surface, 2)


def _unheld(cover: Cover, contact: ContactSystem, outcome: ContactOutcome) -> list[str]:
    """What to say of pieces that have rigid motions which neither supports nor pressed contact points see."""
    pressed, stuck = outcome.state != OPEN, outcome.state == STICK
    rows = [contact.system.constraints, contact.gap_of[pressed], contact.slip_of[stuck]]
    pieces = free_pieces(cover, csr_array(vstack(rows, format="csr")))
    return [
        f"{piece} may move without any resistance ({named(piece.motion)}): where it lies is arbitrary"
        for piece in pieces
    ]


def _patches_at(cover: Cover, faces: ContactFaces) -> Ints:
    """Physical patches next to the contact points."""
    elements = np.concatenate([faces.nodes.plus, faces.nodes.minus])
    return np.unique(cover.functions[elements[elements >= 0]])


def _law(scene: Scene, faces: ContactFaces, growing: tuple[GrowingCrack, ...]) -> ContactLaw:
    """Friction, cohesion and compliance point by point. Faces that growth has made are broken: they do not cohere."""
    friction, cohesion, compliance = np.zeros((3, faces.n))
    for index, law in enumerate(scene.laws):
        if law.contact is None:
            continue
        mine = faces.surface == index
        friction[mine], cohesion[mine], compliance[mine] = law.contact.friction, law.contact.cohesion, law.compliance
        if index < len(growing):
            crack = growing[index]
            given = arc_lengths(scene.lattice.to_lattice(crack.crack.points))[crack.steps == 0]
            cohesion[mine & ((faces.s < given[0]) | (faces.s > given[-1]))] = 0.0
    return ContactLaw(friction, cohesion, compliance)


def _residual(matrix: csc_array, contact: ContactSystem, loads: Floats, outcome: ContactOutcome) -> float:
    """Equilibrium residual K u + C' m + G' W p - f, relative to the largest of its parts.

    Where nothing is stressed all parts are round-off of K u, whose terms then give the size.
    """
    internal = matrix @ outcome.u
    reactions = contact.system.constraints.T @ outcome.multipliers
    tractions = contact.gap_of.T @ (contact.weights * outcome.normal_traction)
    tractions = tractions + contact.slip_of.T @ (contact.weights * outcome.tangential_traction)
    parts = (internal, reactions, tractions, loads)
    size = max(np.abs(part).max(initial=0.0) for part in parts)
    size = max(size, UNSTRESSED * (abs(matrix) @ np.abs(outcome.u)).max(initial=0.0))
    residual = np.abs(internal + reactions + tractions - loads).max(initial=0.0)
    return float(residual / size) if size > 0.0 else 0.0


def _tip_state(
    scene: Scene,
    cover: Cover,
    materials: tuple[PlaneElasticity, ...],
    faces: ContactFaces,
    outcome: ContactOutcome,
    load_factor: float,
    tip: int,
) -> TipState:
    case, crack = scene.case, cover.tip_ends[tip][0]
    body = scene.crack_bodies[crack]
    pressure = load_factor * scene.fluid_pressure(crack)

    compliance = scene.laws[crack].compliance
    pointwise = compliance > 0.0 and case.numerics.contact.discretization == "gauss"

    def traction(s: Floats) -> tuple[Floats, Floats]:
        normal = between_contact_points(cover, faces, crack, s, outcome.normal_traction)
        tangential = between_contact_points(cover, faces, crack, s, outcome.tangential_traction)
        if pointwise:
            normal, tangential = elastic_tractions(cover, crack, s, outcome.u, compliance, (normal, tangential))
        return normal - pressure, tangential

    weight = load_factor * scene.weight(body)
    intensity = interaction_integral(cover, materials, outcome.u, tip, traction, weight)
    K_faces = from_face_displacement(cover, materials[body].young_prime, outcome.u, tip)
    state = TipState(intensity, K_faces, None)
    strength = case.bodies[body].strength
    if case.growth is None or strength is None:
        return state
    radius = case.growth.tip_radius
    field = tip_field(cover, materials, outcome.u, tip, radius)
    verdict = CRITERIA[case.growth.criterion](TipLoading(field, *state.K, radius), strength)
    return replace(state, verdict=verdict)


@contextmanager
def _timed(seconds: dict[str, float], phase: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[phase] = time.perf_counter() - start
