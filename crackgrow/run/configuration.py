"""A configuration of the cracks made ready for its loads: cover, assembly and factorization, each done once."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Load
from crackgrow.contact.coulomb import OPEN, STICK, ContactLaw, ContactMemory
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.contact.faces import ContactFaces, gauss_faces
from crackgrow.contact.hold import check_can_hold
from crackgrow.contact.jump import contact_operators
from crackgrow.contact.mortar import mortar_faces
from crackgrow.contact.solve import OVERLAP, ContactOutcome, Increment, PointStates
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.refinement import divided
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.squares import Squares
from crackgrow.direct import NOTHING, SymmetricMatrix
from crackgrow.errors import NotSolvedError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.readings import Readings
from crackgrow.fracture.sites import Site
from crackgrow.fracture.stress_intensity import Integrals
from crackgrow.fracture.tip_stress import FieldReading, field_readings
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.foci import focus_of, lattice_of_cells
from crackgrow.run.scene import Scene
from crackgrow.run.starting import sites_of
from crackgrow.solid.dependent import with_dependent_held
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.loads import load_vector
from crackgrow.solid.magnitude import LARGEST, LARGEST_STRAIN, check_magnitude
from crackgrow.solid.places import places_of_unknowns
from crackgrow.solid.rigid_modes import check_held, free_motions
from crackgrow.solid.stiffness import Stiffness, stiffness_after
from crackgrow.solid.supports import Constraints, constraints, tied

ON_OUTLINE = 1e-9
"""A crack end closer to an outline than this fraction of its length lies on it."""

ON_GIVEN_FACES = 1e-6
"""Spacings: contact points closer than this to the faces that were given lie on them. The cover rounds its vertices."""

UNSTRESSED = 1e-6
"""Forces below this fraction of the terms that they are the sum of are no forces."""

WORST_RESIDUAL = 1e-5
"""Relative equilibrium residual beyond which a solution is refused."""

SIGNS = np.array([1.0, 1.0, -1.0])
"""Of works: loads do work on displacements; what supports are given does it on forces of theirs, which resist."""

LOST_DIGITS = 1e-9
"""Of the terms of a force: what round-off leaves of them at worst."""


@dataclass(frozen=True, slots=True, eq=False)
class Equilibrium:
    """Displacements and tractions under some loads."""

    outcome: ContactOutcome
    residual: float  # relative


@dataclass(frozen=True, slots=True, eq=False)
class _Units:
    """The rock without contact tractions, per unit of the scaled loads, of the held ones, of given displacements.

    Of reciprocal rock the displacements along a load that tractions make are the work of these on the jumps that the
    load makes.
    """

    u: Floats  # (n_dofs, 3) m
    multipliers: Floats  # (m, 3)
    jumps: Floats  # (2 n, 3) m: gaps, then slips
    conjugates: Floats  # (3, 3) m N/m: displacement along each of the loads, of each; the third: the force of supports
    pull: Floats  # (l, 3) N/m: what they do on each rigid motion that supports leave free


@dataclass(frozen=True, slots=True, eq=False)
class Gone:
    """A body that has been taken out, and by which forces it held the rest."""

    body: str
    forces: Floats  # (n_dofs,) N/m


@dataclass(frozen=True, eq=False)
class Configuration:
    """Everything that depends on where the cracks lie, and not on how much they are loaded."""

    scene: Scene
    cover: Cover
    stiffness: Stiffness
    held: Constraints  # with given displacements at load factor 1
    contact: ContactSystem
    faces: ContactFaces
    scaled: Floats  # (n_dofs,) N/m, loads at load factor 1
    constant: Floats  # (n_dofs,) N/m, loads that are held
    sites: tuple[Site, ...]  # the tips of the cover in their order, then places where cracks may start
    readings: Readings
    seconds: dict[str, float]

    @property
    def matrix(self) -> SymmetricMatrix:
        """Stiffness (n_dofs, n_dofs) Pa."""
        return self.stiffness.matrix

    def loads(self, factor: float, holding: float = 1.0) -> Floats:
        """Loads (n_dofs,) N/m at a load factor, with a share of the held ones."""
        return holding * self.constant + factor * self.scaled

    def given(self, factor: float) -> Floats:
        """Given displacements (m,) m at a load factor."""
        a, b = self.scene.given_parts
        return (a + b * factor) * self.held.given

    def shares(self, factor: float, holding: float = 1.0) -> Floats:
        """What the scaled loads, the constant ones and given displacements (3,) are multiplied by."""
        a, b = self.scene.given_parts
        return np.array([factor, holding, a + b * factor])

    @property
    def proportional(self) -> bool:
        """Whether states from rest on are in proportion to the load factor: nothing else has a size."""
        law, (a, _) = self.contact.law, self.scene.given_parts
        sized = law.cohesion.any() or law.breakable.any()  # what breaks is gone from the least slip on
        return not (sized or self.constant.any() or (a != 0.0 and self.held.given.any()))

    def with_gone(self, gone: Sequence[Gone]) -> Configuration:
        """The configuration with forces by which rock that is gone held it, as far as they are not released."""
        scaled, constant = self.scaled.copy(), self.constant.copy()
        for rock in gone:
            a, b = self.scene.parts_of_gone(rock.body)
            constant += a * rock.forces
            scaled += b * rock.forces
        return replace(self, scaled=scaled, constant=constant)

    def increment(self, factor: float, memory: ContactMemory, holding: float) -> tuple[Increment, Floats]:
        """An increment from `memory` on to a load factor, and the jumps (2 n,) m without tractions at its end.

        `holding` is the share of the held loads.
        """
        units, share = self._units, self.shares(factor, holding)
        along, size = units.conjugates[:2] @ share, float(np.abs(self.loads(factor, holding)).sum())
        length = abs(float(along @ share[:2])) / size if size > 0.0 else 0.0
        length = max(length, float(np.abs(self.given(factor)).max(initial=0.0)))
        return Increment(self.contact, memory, units.pull @ share, OVERLAP * length), units.jumps @ share

    def states(
        self, factor: float, memory: ContactMemory, holding: float, near: PointStates | None = None
    ) -> PointStates:
        """States of the contact points at a load factor after an increment. Raises SolveError where there are none.

        FreePieceError says which piece contact does not hold. `near` are states that may be close.
        """
        check_magnitude("loads", self.loads(factor, holding), LARGEST, "N/m")
        check_magnitude("prescribed displacements", self.given(factor), self._farthest, "m")
        increment, free = self.increment(factor, memory, holding)
        check_magnitude("displacements", free, self._farthest, "m")
        try:
            found = increment.solved(free, None if near is None else increment.begun(near))
        except NotSolvedError as error:
            if self.contact.loose is None:
                raise
            self.check_can_hold(factor, memory, holding)
            pieces = ", ".join(str(piece) for piece in self.contact.loose.pieces)
            raise NotSolvedError(f"contact alone holds {pieces}, perhaps only just: {error}") from error
        check_magnitude("contact tractions", found.tractions, LARGEST, "Pa")
        return found

    def under_laws(self, scene: Scene, growing: tuple[GrowingCrack, ...]) -> Configuration:
        """The same rock and loads with the laws of contact of another scene; what is known of the rock stays known."""
        contact = self.contact.with_law(_law(scene, self.cover, self.faces, growing))
        other = replace(self, scene=scene, contact=contact)
        other.__dict__["_units"] = self._units
        return other

    def check_can_hold(self, factor: float, memory: ContactMemory | None = None, holding: float = 1.0) -> None:
        """Raise FreePieceError where no tractions that contact can carry hold a piece at a load factor."""
        if self.contact.loose is not None:
            names = [self.cover.surfaces[surface].name for surface in self.faces.surface.tolist()]
            check_can_hold(self.contact, names, self.loads(factor, holding), memory)

    def conjugates(self, factor: float, holding: float, states: PointStates) -> Floats:
        """(3,): displacement under the loads per load factor, m N/m; under held loads; support force."""
        units, share = self._units, self.shares(factor, holding)
        forces = np.tile(self.contact.weights, 2) * states.tractions
        found = units.conjugates @ share - SIGNS * (units.jumps.T @ forces)
        motion = np.zeros(len(units.pull)) if states.solution is None else states.solution.motion
        return np.asarray(found + units.pull.T @ motion)

    def conjugate_terms(self, factor: float, holding: float, states: PointStates) -> Floats:
        """(3,): sizes of what `conjugates` sums up, which is nothing beside them where contact holds all in place."""
        units, share = self._units, self.shares(factor, holding)
        forces = np.tile(self.contact.weights, 2) * states.tractions
        return np.asarray(np.abs(units.conjugates @ share) + np.abs(units.jumps.T @ forces))

    def equilibrium(
        self, factor: float, memory: ContactMemory | None, holding: float = 1.0, states: PointStates | None = None
    ) -> Equilibrium:
        """Displacements and tractions at a load factor after an increment from `memory` on.

        `holding` is the share of the held loads; `states` are those at the end where they are known. Raises SolveError
        where they can't be found to a small residual.
        """
        memory = memory or ContactMemory.fresh(self.faces.n)
        states = states or self.states(factor, memory, holding)
        increment, free = self.increment(factor, memory, holding)
        loads, share = self.loads(factor, holding), self.shares(factor, holding)
        without = (self._units.u @ share, self._units.multipliers @ share)
        outcome = increment.formed(states, free, (loads, self.given(factor)), without)
        check_magnitude("displacements", outcome.u, self._farthest, "m")
        if self.contact.loose is not None:
            outcome = replace(outcome, notes=(*outcome.notes, *_unheld(self.cover, self.contact, outcome)))
        residual, place, part = _residual(self.matrix, self.contact, loads, outcome)
        if not residual <= WORST_RESIDUAL:
            raise NotSolvedError(self._not_balanced(residual, place, part))
        return Equilibrium(outcome, residual)

    def _not_balanced(self, residual: float, dof: int, terms: float) -> str:
        """What to say of a residual that is largest at an unknown, where forces are sums of `terms` their size."""
        x, y = self.cover.lattice.to_metres(_place_of(self.cover, dof // 2)[None])[0]
        what = f"the equilibrium residual is {residual:.2g}, more than {WORST_RESIDUAL:g}, near ({x:.4g}, {y:.4g}) m"
        if residual > LOST_DIGITS * terms:
            return f"{what}: no state was found in which forces balance there; use smaller load increments or a spacing"
        return (
            f"{what}: the system is too ill conditioned there, with terms {terms:.1g} times the forces; move what lies "
            "close together (a tip, a crack, an outline, a lattice line) a little, or change numerics.spacing"
        )

    @property
    def _farthest(self) -> float:
        """No displacement is larger than this, m."""
        return LARGEST_STRAIN * self.scene.lattice.spacing

    @cached_property
    def integrals(self) -> Integrals:
        """The integrals of K of all tips."""
        return Integrals(self.readings)

    @cached_property
    def fields(self) -> dict[int, FieldReading]:
        """What the stress fields read off, by the number of their site: those in bodies that have a strength."""
        scene = self.scene
        some = [number for number, site in enumerate(self.sites) if scene.case.bodies[site.body].strength is not None]
        strong = [self.sites[number] for number in some]
        found = field_readings(self.readings, strong, [scene.radius_at(site) for site in strong])
        radii = [scene.shear_radius_at(site) for site in strong]
        sheared = [n for n, radius in enumerate(radii) if radius is not None]
        over = field_readings(self.readings, [strong[n] for n in sheared], [radius for radius in radii if radius])
        for n, reading in zip(sheared, over, strict=True):
            found[n] = replace(found[n], shear=reading)
        return dict(zip(some, found, strict=True))

    @cached_property
    def _units(self) -> _Units:
        """What each of the loads does without contact tractions, all of them solved for together."""
        none, m, loose = np.zeros(len(self.scaled)), len(self.held.given), self.contact.loose
        loads = np.stack([self.scaled, self.constant, none], axis=1)
        given = np.stack([np.zeros(m), np.zeros(m), self.held.given], axis=1)
        u, multipliers = np.zeros(loads.shape), np.zeros(given.shape)
        some = loads.any(axis=0) | given.any(axis=0)
        if some.any():
            u[:, some], multipliers[:, some] = self.contact.system.solve(loads[:, some], given[:, some])
        conjugates = np.vstack([loads[:, :2].T @ u, -self.held.given @ multipliers])
        mirrored = np.outer(SIGNS, SIGNS) * conjugates.T  # the same of reciprocal rock, but for round-off
        conjugates = 0.5 * (conjugates + mirrored)
        pull = np.zeros((0, 3)) if loose is None else np.stack([loose.along(load) for load in loads.T], axis=1)
        return _Units(u, multipliers, self.contact.operator @ u, conjugates, pull)


def assemble(scene: Scene, growing: tuple[GrowingCrack, ...], before: Configuration | None = None) -> Configuration:
    """Make a configuration ready. Raises GeometryError or SolveError where the cover or its system can't be made.

    What has not changed since the configuration `before` is neither integrated nor factorized again; the result is the
    same without it.
    """
    scene = scene.with_cracks(growing)
    case = scene.case
    seconds: dict[str, float] = {}
    with timed(seconds, "cover"):
        cover = _cover(scene, growing, None if before is None else before.cover)
        sites = sites_of(scene, cover, growing)
    with timed(seconds, "assembly"):
        stiff_before = None if before is None else before.stiffness
        stiffness = stiffness_after(cover, scene.materials, case.numerics.quadrature, stiff_before)
        matrix = stiffness.matrix
        if cover.sizes.min(initial=1.0) < 1.0:
            matrix = with_dependent_held(matrix)
        check_magnitude("stiffness", np.array([matrix.largest()]), LARGEST, "Pa")
        faces = _faces(scene, cover)
        operators = contact_operators(cover, faces)
        held = _tied_by_bonds(scene, cover, constraints(cover, case.bodies, case.supports))
        check_magnitude("prescribed displacements", held.given, LARGEST, "m")
        bodies = [g.crack.body for g in growing]
        scaled, constant = _loads(scene, cover, bodies)
        free = free_motions(cover, held.matrix)
        check_held(free, _patches_at(cover, faces))
    with timed(seconds, "factorize"):
        loose = free.held_once(matrix) if free.pieces else None
        stiff = matrix if loose is None else loose.held_in(matrix)
        known = NOTHING if before is None else before.contact.system.kept
        system = ConstrainedSystem(stiff, held.matrix, places_of_unknowns(cover), known)
    weights = faces.weights * scene.lattice.spacing
    law = _law(scene, cover, faces, growing)
    solver = case.numerics.contact.solver
    contact = ContactSystem(system, *operators, weights, law, solver, loose)
    readings = Readings(cover, stiffness.named, None if before is None else before.readings)
    return Configuration(scene, cover, stiffness, held, contact, faces, scaled, constant, sites, readings, seconds)


def _loads(scene: Scene, cover: Cover, crack_bodies: Sequence[str]) -> tuple[Floats, Floats]:
    """What of the loads (n_dofs,) N/m a load factor multiplies, and what it does not."""
    alike: dict[tuple[float, float], list[Load]] = {(0.0, 1.0): [], (1.0, 0.0): []}
    for load in scene.case.loads:
        alike.setdefault(scene.parts(load), []).append(load)
    scaled, constant = np.zeros((2, cover.n_dofs))
    for (a, b), loads in alike.items():
        f = load_vector(cover, scene.case.bodies, loads, scene.case.numerics.quadrature)
        f += face_load_vector(cover, crack_bodies, loads)
        constant += a * f
        scaled += b * f
    return scaled, constant


def lay_out(scene: Scene, growing: tuple[GrowingCrack, ...]) -> tuple[Cover, ContactFaces, Constraints]:
    """Cover, contact points and constraints of a configuration, as `assemble` makes them; nothing is integrated.

    Raises GeometryError where the cover can't be made.
    """
    cover = _cover(scene, growing)
    held = constraints(cover, scene.case.bodies, scene.case.supports)
    return cover, _faces(scene, cover), _tied_by_bonds(scene, cover, held)


def _cover(scene: Scene, growing: tuple[GrowingCrack, ...], before: Cover | None = None) -> Cover:
    cracks = [crack_geometry(scene, g, body) for g, body in zip(growing, scene.crack_bodies, strict=True)]
    lattice = lattice_of_cells(scene.at_start, cracks, None if before is None else before.lattice)
    return build_cover(lattice, scene.bodies, cracks, scene.interfaces, scene.foundations, before)


def first_cells(scene: Scene) -> Squares:
    """The cells of a scene before anything grows, without the lattice that is made of them."""
    given = zip(map(GrowingCrack.given, scene.case.cracks), scene.crack_bodies, strict=True)
    cracks = [crack_geometry(scene, crack, body) for crack, body in given]
    return divided(scene.lattice, focus_of(scene, cracks), scene.case.numerics.refine.rings)


@contextmanager
def timed(seconds: dict[str, float], phase: str) -> Iterator[None]:
    """Add the wall time of a block to a phase."""
    start = time.perf_counter()
    yield
    seconds[phase] = seconds.get(phase, 0.0) + time.perf_counter() - start


def crack_geometry(scene: Scene, growing: GrowingCrack, body: int) -> CrackGeometry:
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
    first, last = np.flatnonzero(growing.rooted)[[0, -1]]
    given = shapely.get_coordinates(shapely.simplify(shapely.LineString(points[first : last + 1]), ON_LINE))
    points = np.concatenate([points[:first], given, points[last + 1 :]])
    gathered = scene.case.numerics.gathers_tip_functions
    return CrackGeometry(growing.crack.name, points, inside[0], inside[1], gathered=gathered)


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
    pieces = free_motions(cover, csr_array(vstack(rows, format="csr"))).pieces
    return [f"{piece} may move without any resistance ({piece.motion}): where it lies is arbitrary" for piece in pieces]


def _patches_at(cover: Cover, faces: ContactFaces) -> Ints:
    """Physical patches next to the contact points."""
    elements = np.concatenate([faces.nodes.plus, faces.nodes.minus])
    return np.unique(cover.patches.of_element.taken(elements[elements >= 0]).values)


def _law(scene: Scene, cover: Cover, faces: ContactFaces, growing: tuple[GrowingCrack, ...]) -> ContactLaw:
    """The law point by point. Faces that growth has made are broken from the start: they do not cohere."""
    friction, cohesion, compliance, along, residual, dilation, weakening = np.zeros((7, faces.n))
    kept = np.zeros(faces.n, dtype=bool)
    for index, law in enumerate(scene.laws):
        if law.contact is None:
            continue
        mine = faces.surface == index
        friction[mine], cohesion[mine] = law.contact.friction, law.contact.cohesion
        size = cover.surfaces[index].in_cells.size(faces.s[mine]) * scene.lattice.spacing
        compliance[mine], along[mine] = law.compliance(size), law.shear_compliance(size)
        residual[mine], kept[mine] = law.contact.residual_friction, law.contact.cohesion_kept
        dilation[mine] = np.tan(np.deg2rad(law.contact.dilation_angle))
        weakening[mine] = law.contact.weakening_length
        if index < len(growing):
            crack = growing[index]
            given = arc_lengths(scene.lattice.to_lattice(crack.crack.points))[crack.rooted]
            new = mine & ((faces.s < given[0] - ON_GIVEN_FACES) | (faces.s > given[-1] + ON_GIVEN_FACES))
            cohesion[new], friction[new] = 0.0, law.contact.residual_friction
    joints = any(law.joint for law in scene.laws)
    return ContactLaw(
        friction,
        cohesion,
        compliance,
        residual,
        kept,
        dilation=dilation if dilation.any() else None,
        shear_compliance=along if joints else None,
        weakening=weakening if weakening.any() else None,
    )


def _residual(
    matrix: SymmetricMatrix, contact: ContactSystem, loads: Floats, outcome: ContactOutcome
) -> tuple[float, int, float]:
    """Equilibrium residual K u + C' m + G' W p - f, relative to the largest of its parts, and the unknown it is at.

    The third are the terms that K u is the sum of at the unknown, relative as well. Where nothing is stressed all parts
    are round-off, and the terms give the size.
    """
    internal, terms = matrix.weighed(outcome.u)
    reactions = contact.system.constraints.T @ outcome.multipliers
    tractions = contact.gap_of.T @ (contact.weights * outcome.normal_traction)
    tractions = tractions + contact.slip_of.T @ (contact.weights * outcome.tangential_traction)
    parts = (internal, reactions, tractions, loads)
    size = max(np.abs(part).max(initial=0.0) for part in parts)
    size = max(size, UNSTRESSED * terms.max(initial=0.0))
    left = np.abs(internal + reactions + tractions - loads)
    place = int(np.argmax(left))
    return (float(left[place] / size), place, float(terms[place] / size)) if size > 0.0 else (0.0, place, 0.0)


def _place_of(cover: Cover, function: int) -> Floats:
    """The node of a physical patch (2,), or the tip that a singular function belongs to, in lattice coordinates."""
    if function < len(cover.patch_nodes):
        return np.asarray(cover.patch_nodes[function])
    first = [tip.first_function for tip in cover.tips]
    return cover.tips[int(np.searchsorted(first, function, side="right")) - 1].point
