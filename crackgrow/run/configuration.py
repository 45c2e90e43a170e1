"""A configuration of the cracks made ready for its loads: cover, assembly and factorization, each done once."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array, vstack

from crackgrow.contact.coulomb import OPEN, STICK
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.contact.faces import ContactFaces, gauss_faces, mortar_faces
from crackgrow.contact.hold import solve_contact_of_pieces
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.law import ContactLaw, ContactMemory
from crackgrow.contact.solve import ContactOutcome, solve_contact
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.scene import Scene
from crackgrow.solid.dissection import places_of_unknowns
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.loads import load_vector
from crackgrow.solid.magnitude import LARGEST, LARGEST_STRAIN, check_magnitude
from crackgrow.solid.matrix import SymmetricMatrix
from crackgrow.solid.rigid_modes import FreePiece, Springs, check_held, free_pieces, loose_springs
from crackgrow.solid.stiffness import Stiffness, stiffness_after
from crackgrow.solid.supports import Constraints, constraints, tied

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ON_OUTLINE = 1e-9
"""A crack end closer to an outline than this fraction of its length lies on it."""

ON_GIVEN_FACES = 1e-6
"""Spacings: contact points closer than this to the faces that were given lie on them. The cover rounds its vertices."""

UNSTRESSED = 1e-6
"""Forces below this fraction of the terms that they are the sum of are no forces."""

WORST_RESIDUAL = 1e-5
"""Relative equilibrium residual beyond which a solution is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class Equilibrium:
    """Displacements and tractions under some loads, and what the products with the stiffness tell of them."""

    outcome: ContactOutcome
    residual: float  # relative
    strain: float  # J/m, strain energy u K u / 2 of the rock
    strain_terms: float  # J/m, the same of absolute values: the terms that it is the sum of


@dataclass(frozen=True, slots=True, eq=False)
class Configuration:
    """Everything that depends on where the cracks lie, and not on how much they are loaded."""

    scene: Scene
    cover: Cover
    stiffness: Stiffness
    held: Constraints  # with given displacements at load factor 1
    contact: ContactSystem
    faces: ContactFaces
    free: tuple[FreePiece, ...]  # pieces that contact alone holds
    springs: Springs | None
    scaled: Floats  # (n_dofs,) N/m, loads at load factor 1
    constant: Floats  # (n_dofs,) N/m, loads that are held
    seconds: dict[str, float]
    solved: dict[int, tuple[Floats, Floats]] = field(default_factory=dict, repr=False)  # without contact, per unit

    @property
    def matrix(self) -> SymmetricMatrix:
        """Stiffness (n_dofs, n_dofs) Pa."""
        return self.stiffness.matrix

    def loads(self, factor: float, holding: float = 1.0) -> Floats:
        """Loads (n_dofs,) N/m at a load factor, with a share of the held ones."""
        return holding * self.constant + factor * self.scaled

    def equilibrium(self, factor: float, memory: ContactMemory | None, holding: float = 1.0) -> Equilibrium:
        """Displacements and tractions at a load factor after an increment from `memory` on.

        `holding` is the share of the held loads. Raises SolveError where they can't be found to a small residual.
        """
        loads, given = self.loads(factor, holding), factor * self.held.given
        farthest = LARGEST_STRAIN * self.scene.lattice.spacing
        check_magnitude("loads", loads, LARGEST, "N/m")
        check_magnitude("prescribed displacements", given, farthest, "m")
        if self.springs is None:
            outcome = solve_contact(self.contact, loads, given, memory, self._without_contact(factor, holding))
        else:
            outcome = solve_contact_of_pieces(self.contact, self.cover, self.springs, self.free, loads, given, memory)
            outcome = replace(outcome, notes=(*outcome.notes, *_unheld(self.cover, self.contact, outcome)))
        check_magnitude("displacements", outcome.u, farthest, "m")
        check_magnitude("contact tractions", outcome.normal_traction, LARGEST, "Pa")
        check_magnitude("contact tractions", outcome.tangential_traction, LARGEST, "Pa")
        internal, terms = self.matrix @ outcome.u, self.matrix.sizes(outcome.u)
        residual = _residual(self.contact, loads, outcome, internal, terms)
        if not residual <= WORST_RESIDUAL:
            raise SolveError(
                f"the equilibrium residual is {residual:.2g}, more than {WORST_RESIDUAL:g}: the system is too ill "
                "conditioned" + ("; a tip may lie too close to another one or to an outline" if self.cover.tips else "")
            )
        strain, strain_terms = 0.5 * float(outcome.u @ internal), 0.5 * float(np.abs(outcome.u) @ terms)
        return Equilibrium(outcome, residual, strain, strain_terms)

    def solve_loads(self) -> None:
        """Solve for the loads without contact before anything else is: what comes later then finds the same bits."""
        if self.springs is None:
            self._without_contact(1.0, 1.0)

    def _without_contact(self, factor: float, holding: float) -> tuple[Floats, Floats]:
        """Displacements (n_dofs,) m and multipliers (m,) where faces carry nothing; each load is solved once."""
        system, given = self.contact.system, self.held.given
        u, multipliers = np.zeros(len(self.scaled)), np.zeros(len(given))
        parts = ((factor, self.scaled, given), (holding, self.constant, np.zeros(len(given))))
        for kind, (share, loads, displacements) in enumerate(parts):
            if share == 0.0 or not (loads.any() or displacements.any()):
                continue
            if kind not in self.solved:
                self.solved[kind] = system.solve(loads, displacements)
            u += share * self.solved[kind][0]
            multipliers += share * self.solved[kind][1]
        return u, multipliers


def assemble(scene: Scene, growing: tuple[GrowingCrack, ...], before: Configuration | None = None) -> Configuration:
    """Make a configuration ready. Raises GeometryError or SolveError where the cover or its system can't be made.

    What has not changed since the configuration `before` is neither integrated nor factorized again; the result is the
    same without it.
    """
    case = scene.case
    seconds: dict[str, float] = {}
    with timed(seconds, "cover"):
        cover = _cover(scene, growing, None if before is None else before.cover)
    with timed(seconds, "assembly"):
        stiff_before = None if before is None else before.stiffness
        stiffness = stiffness_after(cover, scene.materials, case.numerics.quadrature, stiff_before)
        matrix = stiffness.matrix
        check_magnitude("stiffness", np.array([matrix.largest()]), LARGEST, "Pa")
        faces = _faces(scene, cover)
        operators = contact_operators(cover, faces)
        held = _tied_by_bonds(scene, cover, constraints(cover, case.bodies, case.supports))
        check_magnitude("prescribed displacements", held.given, LARGEST, "m")
        bodies = [g.crack.body for g in growing]
        scaled, constant = (
            load_vector(cover, case.bodies, loads, case.numerics.quadrature) + face_load_vector(cover, bodies, loads)
            for loads in ([x for x in case.loads if not x.held], [x for x in case.loads if x.held])
        )
        free = free_pieces(cover, held.matrix)
        check_held(free, _patches_at(cover, faces))
    with timed(seconds, "factorize"):
        springs = loose_springs(cover, matrix, free) if free else None
        stiff = matrix if springs is None else springs.added_to(matrix)
        factors = None if before is None else before.contact.system.factors
        system = ConstrainedSystem(stiff, held.matrix, places_of_unknowns(cover), factors, loose=springs is not None)
    weights = faces.weights * scene.lattice.spacing
    law = _law(scene, faces, growing)
    contact = ContactSystem(system, *operators, weights, law, case.numerics.contact.solver, loose=bool(free))
    return Configuration(scene, cover, stiffness, held, contact, faces, free, springs, scaled, constant, seconds)


def lay_out(scene: Scene, growing: tuple[GrowingCrack, ...]) -> tuple[Cover, ContactFaces, Constraints]:
    """Cover, contact points and constraints of a configuration, as `assemble` makes them; nothing is integrated.

    Raises GeometryError where the cover can't be made.
    """
    cover = _cover(scene, growing)
    held = constraints(cover, scene.case.bodies, scene.case.supports)
    return cover, _faces(scene, cover), _tied_by_bonds(scene, cover, held)


def _cover(scene: Scene, growing: tuple[GrowingCrack, ...], before: Cover | None = None) -> Cover:
    cracks = [_geometry(scene, g, body) for g, body in zip(growing, scene.crack_bodies, strict=True)]
    return build_cover(scene.lattice, scene.bodies, cracks, scene.interfaces, scene.foundations, before)


@contextmanager
def timed(seconds: dict[str, float], phase: str) -> Iterator[None]:
    """Add the wall time of a block to a phase."""
    start = time.perf_counter()
    yield
    seconds[phase] = seconds.get(phase, 0.0) + time.perf_counter() - start


def _geometry(scene: Scene, growing: GrowingCrack, body: int) -> CrackGeometry:
    """The crack in lattice coordinates. An end is a tip unless it lies on its body's rim, whether it can grow or not.

    `body` is the one that it lies in. Given vertices at which the crack does not turn are left out: a straight stretch
    is one whatever it was put together from, for the cover as for the disc of the integrals of K. Where growth began
    a vertex stays: faces remember up to there.
    """
    points = growing.crack.points.copy()
    inside = [True, True]
    boundary = scene.regions[body].boundary
    for index, end in enumerate((0, -1)):
        place = shapely.Point(points[end])
        if shapely.dwithin(boundary, place, ON_OUTLINE * boundary.length):
            points[end] = shapely.shortest_line(boundary, place).coords[0]
            inside[index] = False
    points = scene.lattice.to_lattice(points)
    first, last = np.flatnonzero(growing.steps == 0)[[0, -1]]
    given = shapely.get_coordinates(shapely.simplify(shapely.LineString(points[first : last + 1]), ON_LINE))
    points = np.concatenate([points[:first], given, points[last + 1 :]])
    return CrackGeometry(growing.crack.name, points, inside[0], inside[1])


def _faces(scene: Scene, cover: Cover) -> ContactFaces:
    touching = [index for index, law in enumerate(scene.laws) if law.contact is not None]
    settings = scene.case.numerics.contact
    if settings.discretization == "gauss":
        return gauss_faces(cover, touching)
    return mortar_faces(cover, touching, settings.spacing)


def _tied_by_bonds(scene: Scene, cover: Cover, held: Constraints) -> Constraints:
    """The constraints with those of bonded interfaces: no gap and no slip, averaged at mortar nodes."""
    bonded = [index for index, law in enumerate(scene.laws) if law.bonded]
    if not bonded:
        return held
    faces = mortar_faces(cover, bonded, scene.case.numerics.contact.spacing)
    return tied(held, csr_array(vstack(contact_operators(cover, faces), format="csr")), np.tile(faces.surface, 2))


def _unheld(cover: Cover, contact: ContactSystem, outcome: ContactOutcome) -> list[str]:
    """What to say of pieces that have rigid motions which neither supports nor pressed contact points see."""
    pressed, stuck = outcome.state != OPEN, outcome.state == STICK
    rows = [contact.system.constraints, contact.gap_of[pressed], contact.slip_of[stuck]]
    pieces = free_pieces(cover, csr_array(vstack(rows, format="csr")))
    return [f"{piece} may move without any resistance ({piece.motion}): where it lies is arbitrary" for piece in pieces]


def _patches_at(cover: Cover, faces: ContactFaces) -> Ints:
    """Physical patches next to the contact points."""
    elements = np.concatenate([faces.nodes.plus, faces.nodes.minus])
    return np.unique(cover.functions[elements[elements >= 0]])


def _law(scene: Scene, faces: ContactFaces, growing: tuple[GrowingCrack, ...]) -> ContactLaw:
    """The law point by point. Faces that growth has made are broken from the start: they do not cohere."""
    friction, cohesion, compliance, residual, dilation = np.zeros((5, faces.n))
    kept = np.zeros(faces.n, dtype=bool)
    for index, law in enumerate(scene.laws):
        if law.contact is None:
            continue
        mine = faces.surface == index
        friction[mine], cohesion[mine], compliance[mine] = law.contact.friction, law.contact.cohesion, law.compliance
        residual[mine], kept[mine] = law.contact.residual_friction, law.contact.cohesion_kept
        dilation[mine] = np.tan(np.deg2rad(law.contact.dilation_angle))
        if index < len(growing):
            crack = growing[index]
            given = arc_lengths(scene.lattice.to_lattice(crack.crack.points))[crack.steps == 0]
            new = mine & ((faces.s < given[0] - ON_GIVEN_FACES) | (faces.s > given[-1] + ON_GIVEN_FACES))
            cohesion[new], friction[new] = 0.0, law.contact.residual_friction
    return ContactLaw(friction, cohesion, compliance, residual, kept, dilation if dilation.any() else None)


def _residual(contact: ContactSystem, loads: Floats, outcome: ContactOutcome, internal: Floats, terms: Floats) -> float:
    """Equilibrium residual K u + C' m + G' W p - f, relative to the largest of its parts, of which K u is `internal`.

    Where nothing is stressed all parts are round-off of K u, whose `terms` (n_dofs,) N/m then give the size.
    """
    reactions = contact.system.constraints.T @ outcome.multipliers
    tractions = contact.gap_of.T @ (contact.weights * outcome.normal_traction)
    tractions = tractions + contact.slip_of.T @ (contact.weights * outcome.tangential_traction)
    parts = (internal, reactions, tractions, loads)
    size = max(np.abs(part).max(initial=0.0) for part in parts)
    size = max(size, UNSTRESSED * terms.max(initial=0.0))
    residual = np.abs(internal + reactions + tractions - loads).max(initial=0.0)
    return float(residual / size) if size > 0.0 else 0.0
