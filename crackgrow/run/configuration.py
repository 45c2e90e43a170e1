"""A configuration of the cracks made ready for its loads: cover, assembly and factorization, each done once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, vstack

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.model import PointForce, PointSupport, Stage
from crackgrow.contact.coulomb import OPEN, STICK, ContactMemory
from crackgrow.contact.face_loads import face_load_vector
from crackgrow.contact.faces import ContactFaces, FacePoints
from crackgrow.contact.hold import alone, check_can_hold
from crackgrow.contact.jump import across_and_along, averaged, contact_operators, gap_and_slip
from crackgrow.contact.solve import OVERLAP, ContactOutcome, Increment, PointStates, Trial, TrialNotSolvedError
from crackgrow.contact.system import ContactSystem
from crackgrow.cover.cover import Cover
from crackgrow.errors import NotSolvedError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.debond import Debond, debond_number
from crackgrow.fracture.interface_tips import InterfaceTip, interface_tips
from crackgrow.fracture.sites import Site
from crackgrow.fracture.stress_intensity import Integrals
from crackgrow.fracture.tip_stress import StressFunctional, stress_functionals
from crackgrow.linear import ConstrainedSystem, SymmetricMatrix
from crackgrow.ragged import distinct
from crackgrow.run.clock import SPENT, timed
from crackgrow.run.layout import constraints_of, contact_faces, cover_of
from crackgrow.run.residual import LARGEST, LARGEST_STRAIN, check_magnitude, checked_residual
from crackgrow.run.scene import Scene
from crackgrow.run.starting import sites_of
from crackgrow.run.surface_laws import SurfaceLaw, laws_at_points
from crackgrow.solid.dependent import with_dependent_held
from crackgrow.solid.loads import load_vector
from crackgrow.solid.places import boxes_of_functions
from crackgrow.solid.rigid_modes import check_held, check_not_seen, free_motions
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import Constraints

SIGNS = np.array([1.0, 1.0, -1.0])
"""Of works: loads do work on displacements; what supports are given does it on forces of theirs, which resist."""

TAKEN_BACK = 1e-12
"""Of loads: less than this is nothing that is left where they take each other back."""

ROUND_OFF = 1e-15
"""Of the largest force of any load: the same, where loads at a place are themselves the round-off of larger forces."""


class LoadLevel(NamedTuple):
    """How much of the loads acts: a place on their way."""

    factor: float  # of the loads that are scaled
    holding: float = 1.0  # how much of those that are held acts

    def towards(self, last: LoadLevel, share: float) -> LoadLevel:
        """The place after a share of the way to the `last` one, which is the last one itself after all of it."""
        return last if share == 1.0 else LoadLevel(*(a + share * (b - a) for a, b in zip(self, last, strict=True)))


@dataclass(frozen=True, slots=True, eq=False)
class _Units:
    """The rock without contact tractions, per unit of the scaled loads, of the held ones, of given displacements.

    Of reciprocal rock the displacements along a load that tractions make are the work of these on the jumps that the
    load makes.
    """

    jumps: Floats  # (2 n, 3) m: gaps, then slips
    conjugates: Floats  # (3, 3) m N/m: displacement along each of the loads, of each; the third: the force of supports
    pull: Floats  # (l, 3) N/m: what they do on each rigid motion that supports leave free


@dataclass(frozen=True, slots=True, eq=False)
class Excavated:
    """A body that has been taken out, and by which forces it held the rest."""

    body: str
    forces: Floats  # (n_dofs,) N/m

    def share_left(self, stage: Stage) -> float:
        """How much of the forces acts at the end of a stage."""
        return 1.0 - dict(stage.excavated).get(self.body, 0.0)


@dataclass(frozen=True, eq=False)
class Configuration:
    """Everything that depends on where the cracks lie, and not on how much they are loaded."""

    scene: Scene
    cracks: tuple[GrowingCrack, ...]
    cover: Cover
    stiffness: SymmetricMatrix  # (n_dofs, n_dofs) Pa, per metre of thickness
    held: Constraints  # with given displacements at load factor 1
    contact: ContactSystem
    faces: ContactFaces
    moves: Floats  # (surfaces, 2) m: how far foundations move at load factor 1
    sites: tuple[Site, ...]  # the tips of the cover in their order, then places where cracks may start

    @property
    def scaled(self) -> Floats:
        """Loads (n_dofs,) N/m at load factor 1."""
        return self.contact.loads[:, 0]

    @property
    def constant(self) -> Floats:
        """Loads (n_dofs,) N/m that are held."""
        return self.contact.loads[:, 1]

    def loads(self, level: LoadLevel) -> Floats:
        """Loads (n_dofs,) N/m."""
        scaled, constant, _ = self.shares(level).tolist()
        return np.asarray(constant * self.constant + scaled * self.scaled)

    def given(self, level: LoadLevel) -> Floats:
        """Given displacements (m,) m."""
        return np.asarray(self.shares(level)[2] * self.held.given)

    def farthest(self, level: LoadLevel) -> float:
        """The largest of the given displacements, of supports and of foundations, m."""
        most = max(float(np.abs(of).max(initial=0.0)) for of in (self.held.given, self.moves))
        return abs(float(self.shares(level)[2])) * most

    def gap_and_slip(self, level: LoadLevel, points: FacePoints, u: Floats) -> tuple[Floats, Floats]:
        """Return gap, positive where open, and slip (n,) m at points of surfaces, of displacements `u` (n_dofs,) m.

        What foundations have moved under the load is taken off. Slip is positive where the left face moves forward.
        """
        gap, slip = gap_and_slip(self.cover, points, u)
        away = across_and_along(points, self.shares(level)[2] * self.moves[points.surface])
        return gap - away[0], slip - away[1]

    @cached_property
    def _moved(self) -> Floats:
        """Jumps (2 n,) m that foundations take away from contact points as they move at load factor 1."""
        return averaged(self.faces, self.moves[self.faces.points.surface])

    def shares(self, level: LoadLevel) -> Floats:
        """What the scaled loads, the constant ones and given displacements (3,) are multiplied by.

        Nothing at all where they take each other back: what is left of their sum is round-off, on which points would
        slip and open.
        """
        a, b = self.scene.given_parts
        shares = np.array([level.factor, level.holding, a + b * level.factor])
        moved = (self.held.given.any() or self.moves.any()) and abs(shares[2]) > TAKEN_BACK * (
            abs(a) + abs(b * level.factor)
        )
        return shares if moved or self._acts(level) else np.zeros(3)

    def _acts(self, level: LoadLevel) -> bool:
        """Whether anything is left of the sum of the scaled and the constant loads."""
        parts = np.array([level.factor, level.holding])
        products = parts[:, None] * self._products * parts
        if products.sum() > np.sqrt(TAKEN_BACK) * np.trace(products):
            return True  # without a look at every force
        scaled, constant = level.factor * self.scaled, level.holding * self.constant
        largest = max(np.abs(scaled).max(initial=0.0), np.abs(constant).max(initial=0.0))
        return bool(np.abs(scaled + constant).max(initial=0.0) > TAKEN_BACK * largest)

    @cached_property
    def _products(self) -> Floats:
        """(2, 2): the scaled loads and the constant ones, each times each."""
        both = np.stack([self.scaled, self.constant])
        size = np.abs(both).max(initial=0.0)
        both = both / size if size > 0.0 else both
        return np.asarray(both @ both.T)

    @property
    def sized(self) -> bool:
        """Whether tractions or slips of a size change what contact does: else states are in proportion to all loads."""
        law = self.contact.law
        # what breaks is gone from the least slip on
        return bool(law.cohesion.any() or law.breakable.any() or law.bends.any())

    @property
    def forgets(self) -> bool:
        """Whether points have plain friction alone, so that slip does not depend on the way of loads that grow."""
        law = self.contact.law
        return not (self.sized or law.tension.any() or law.dilation.any())

    def with_excavated(self, excavated: Sequence[Excavated]) -> Configuration:
        """The configuration with forces by which rock that is gone held it, as far as they are not released."""
        if not excavated:
            return self
        scaled, constant = self.scaled.copy(), self.constant.copy()
        for rock in excavated:
            a, b = self.scene.through_stage(rock.share_left)
            constant += a * rock.forces
            scaled += b * rock.forces
        return replace(self, contact=replace(self.contact, loads=_each_load(scaled, constant)))

    def increment(self, level: LoadLevel, memory: ContactMemory) -> Increment:
        """An increment from `memory` on."""
        units, share = self._units, self.shares(level)
        along, size = units.conjugates[:2] @ share, float(np.abs(self.loads(level)).sum())
        length = abs(float(along @ share[:2])) / size if size > 0.0 else 0.0
        tolerance = OVERLAP * max(length, self.farthest(level))
        loads = (self.loads(level), self.given(level))
        return Increment(
            self.contact, memory, units.jumps @ share, units.pull @ share, tolerance, share[2] * self._moved, loads
        )

    def states(self, level: LoadLevel, memory: ContactMemory, near: PointStates | None = None) -> PointStates:
        """States of the contact points after an increment. Raises SolveError where there are none.

        FreePieceError says which piece contact does not hold. `near` are states that may be close.
        """
        check_magnitude("loads", self.loads(level), LARGEST, "N/m")
        check_magnitude("prescribed displacements", np.array([self.farthest(level)]), self._farthest, "m")
        increment = self.increment(level, memory)
        check_magnitude("displacements", increment.free, self._farthest, "m")
        try:
            found = increment.solved(None if near is None else increment.begun(near))
        except TrialNotSolvedError as error:
            if self.contact.loose is None:
                raise
            self.check_can_hold(level, error.trial)
            raise NotSolvedError(f"{alone(self.contact.loose.pieces)}; {error}") from error
        check_magnitude("contact tractions", found.tractions, LARGEST, "Pa")
        return found

    def under_laws(self, laws: tuple[SurfaceLaw, ...]) -> Configuration:
        """The same rock and loads with other laws of contact; what is known of the rock stays known."""
        scene = replace(self.scene, laws=laws)
        contact = self.contact.with_law(laws_at_points(laws, self.cover, self.faces, self.cracks, scene.debonds))
        other = replace(self, scene=scene, contact=contact)
        other.__dict__["_units"] = self._units
        return other

    def check_can_hold(self, level: LoadLevel, trial: Trial | None = None) -> None:
        """Raise FreePieceError where no tractions that contact can carry, in a trial those left to it, hold a piece."""
        if self.contact.loose is not None:
            names = [str(self.cover.surfaces[surface].name) for surface in self.faces.surface.tolist()]
            check_can_hold(self.contact, names, self.loads(level), trial)

    def conjugates(self, level: LoadLevel, states: PointStates) -> Floats:
        """(3,): displacement under the loads per load factor, m N/m; under held loads; support force."""
        units, share = self._units, self.shares(level)
        forces = np.tile(self.contact.weights, 2) * states.tractions
        if states.rock is not None:
            u, multipliers = states.rock
            of_supports = -(self.held.given @ multipliers) - self._moved @ forces
            return np.append(self.contact.loads[:, :2].T @ u, of_supports)
        found = units.conjugates @ share - SIGNS * (units.jumps.T @ forces)
        motion = np.zeros(len(units.pull)) if states.solution is None else states.solution.motion
        return np.asarray(found + units.pull.T @ motion)

    def conjugate_terms(self, level: LoadLevel, states: PointStates) -> Floats:
        """(3,): sizes of what `conjugates` sums up, which is nothing beside them where contact holds all in place."""
        units, share = self._units, self.shares(level)
        forces = np.tile(self.contact.weights, 2) * states.tractions
        return np.asarray(np.abs(units.conjugates @ share) + np.abs(units.jumps.T @ forces))

    def displacements(self, ends: Sequence[tuple[LoadLevel, PointStates]]) -> list[tuple[Floats, Floats]]:
        """Displacements (n_dofs,) m and multipliers (m,) under loads with tractions of each of some states, together.

        Those of `equilibrium` but for its corrections.
        """
        left = [end for end in ends if end[1].rock is None]
        found = iter(self._by_tractions(left) if left else ())
        return [states.rock or next(found) for _, states in ends]

    def _by_tractions(self, ends: Sequence[tuple[LoadLevel, PointStates]]) -> list[tuple[Floats, Floats]]:
        """The same of states whose displacements are not known."""
        level, solved = zip(*ends, strict=True)
        shares = np.stack([self.shares(each) for each in level], axis=1)
        loads = np.stack([self.loads(each) for each in level], axis=1)
        given = np.stack([self.given(each) for each in level], axis=1)
        tractions = np.stack([states.tractions for states in solved], axis=1)
        none = np.zeros(len(self._units.pull))
        motion = np.stack([none if each.solution is None else each.solution.motion for each in solved], axis=1)
        without = self._without_tractions(shares)
        u, multipliers = self.contact.displacements((loads, given), without, tractions, motion)
        return list(zip(np.ascontiguousarray(u.T), np.ascontiguousarray(multipliers.T), strict=True))

    def equilibrium(
        self,
        level: LoadLevel,
        memory: ContactMemory,
        states: PointStates,
        known: tuple[Floats, Floats] | None = None,
    ) -> ContactOutcome:
        """Displacements and tractions after an increment from `memory` on, at whose end the points have some `states`.

        `known` is what `displacements` says of them. Raises SolveError where they can't be found to a small residual.
        """
        loads, share = self.loads(level), self.shares(level)
        without = self._without_tractions(share)
        outcome = self.increment(level, memory).formed(states, without, known)
        check_magnitude("displacements", outcome.u, self._farthest, "m")
        if self.contact.loose is not None:
            outcome = replace(outcome, notes=(*outcome.notes, *_unheld(self.cover, self.contact, outcome)))
        residual, largest = checked_residual(self.cover, self.stiffness, self.contact, loads, outcome)
        return replace(outcome, residual=residual, largest_terms=largest)

    @property
    def _farthest(self) -> float:
        """No displacement is larger than this, m."""
        return LARGEST_STRAIN * self.scene.lattice.spacing

    @cached_property
    def integrals(self) -> Integrals:
        """The integrals of K of all tips."""
        return Integrals(self.cover, self.singular)

    @property
    def singular(self) -> Floats:
        """The points (k, 2), lattice coordinates, at which forces act or supports hold."""
        case = self.scene.case
        points = [load.point for load in case.loads if isinstance(load, PointForce) and any(load.force)]
        points += [support.point for support in case.supports if isinstance(support, PointSupport)]
        return self.cover.lattice.to_lattice(np.array(points).reshape(-1, 2))

    @cached_property
    def interface_tips(self) -> list[tuple[InterfaceTip, Debond | None]]:
        """The tips of cracked interfaces, with what grows at them."""
        debonds, found = self.scene.debonds, list[tuple[InterfaceTip, Debond | None]]()
        for tip in interface_tips(self.cover, self.singular):
            number = debond_number(debonds, self.cover.surfaces[tip.surface].name)
            found.append((tip, None if number is None else debonds[number]))
        return found

    @cached_property
    def stress_functionals(self) -> dict[int, StressFunctional]:
        """What the stress fields read off, by the number of their site: those in bodies that have a strength."""
        scene = self.scene
        some = [number for number, site in enumerate(self.sites) if scene.case.bodies[site.body].strength is not None]
        strong = [self.sites[number] for number in some]
        found = stress_functionals(self.cover, strong, [scene.radius_at(site) for site in strong])
        radii = [scene.shear_radius_at(site) for site in strong]
        sheared = [n for n, radius in enumerate(radii) if radius is not None]
        over = stress_functionals(self.cover, [strong[n] for n in sheared], [radius for radius in radii if radius])
        for n, functional in zip(sheared, over, strict=True):
            found[n] = replace(found[n], shear=functional)
        return dict(zip(some, found, strict=True))

    @cached_property
    def _units(self) -> _Units:
        """What each of the loads does without contact tractions."""
        loads, loose, (u, multipliers) = self.contact.loads, self.contact.loose, self.contact.without_tractions
        conjugates = np.vstack([loads[:, :2].T @ u, -self.held.given @ multipliers])
        mirrored = np.outer(SIGNS, SIGNS) * conjugates.T  # the same of reciprocal rock, but for round-off
        conjugates = 0.5 * (conjugates + mirrored)
        pull = np.zeros((0, 3)) if loose is None else np.stack([loose.along(load) for load in loads.T], axis=1)
        jumps = self.contact.operator @ u
        jumps[:, 2] -= self._moved
        return _Units(jumps, conjugates, pull)

    def _without_tractions(self, shares: Floats) -> tuple[Floats, Floats]:
        """Displacements (n_dofs,) m and multipliers (m,) under such `shares` (3,) of the loads; of k states: (3, k)."""
        u, multipliers = self.contact.without_tractions
        return u @ shares, multipliers @ shares


def assemble(scene: Scene, growing: tuple[GrowingCrack, ...]) -> Configuration:
    """Make a configuration ready. Raises GeometryError or SolveError where the cover or its system can't be made."""
    scene = scene.with_cracks(growing)
    case = scene.case
    with timed("cover"):
        cover = cover_of(scene, growing)
        sites = sites_of(scene, cover, growing)
    with timed("assembly"):
        stiff = stiffness(cover, scene.materials, case.numerics.quadrature)
        matrix = with_dependent_held(stiff)
        check_magnitude("stiffness", np.array([matrix.largest()]), LARGEST, "Pa")
        faces = contact_faces(scene, cover)
        operators = contact_operators(cover, faces)
        held = constraints_of(scene, cover)
        check_magnitude("prescribed displacements", held.given, LARGEST, "m")
        bodies = [g.crack.body for g in growing]
        scaled, constant = _loads(scene, cover, bodies)
        volumes = held.load >= 0
        free = free_motions(cover, csr_array(held.matrix[~volumes]))
        check_held(free, _patches_at(cover, faces))
        if volumes.any():
            check_not_seen(free, csr_array(held.matrix[volumes]))
    with timed("factorize"):
        loose = free.held_once(matrix) if free.pieces else None
        held_once = matrix if loose is None else matrix.with_diagonal(loose.dofs, loose.stiffness)
        system = ConstrainedSystem(held_once, held.matrix, boxes_of_functions(cover), held.compliance)
        system.factorize()
        SPENT.n_factorizations += 1
    weights = faces.weights * scene.lattice.spacing
    law = laws_at_points(scene.laws, cover, faces, growing, scene.debonds)
    solver = case.numerics.contact.solver
    loads, given = _each_load(scaled, constant), np.outer(held.given, (0.0, 0.0, 1.0))
    contact = ContactSystem(system, *operators, weights, law, solver, loose, loads, given)
    moves = np.zeros((len(cover.surfaces), 2))
    for n, foundation in enumerate(reversed(scene.foundations), 1):  # they are the last of the surfaces
        moves[-n] = foundation.moves
    return Configuration(scene, growing, cover, stiff, held, contact, faces, moves, sites)


def _each_load(scaled: Floats, constant: Floats) -> Floats:
    """Loads (n_dofs, 3) N/m of which all that act are a sum: the scaled, the constant, none beside what is given."""
    return np.stack([scaled, constant, np.zeros(len(scaled))]).T


def _loads(scene: Scene, cover: Cover, crack_bodies: Sequence[str]) -> tuple[Floats, Floats]:
    """What of the loads (n_dofs,) N/m a load factor multiplies, and what it does not.

    Where loads take each other back all the way nothing is left of them, on which points would slip and open.
    """

    (constant, scaled), sizes = np.zeros((2, 2, cover.n_dofs))
    for load in scene.case.loads:
        f = load_vector(cover, scene.case.bodies, [load], scene.case.numerics.quadrature)
        f += face_load_vector(cover, crack_bodies, [load])
        parts = np.array(scene.parts(load))
        constant += parts[0] * f
        scaled += parts[1] * f
        sizes += np.outer(np.abs(parts), np.abs(f))
    for total, size in zip((constant, scaled), sizes, strict=True):
        total[_taken_back(total, size)] = 0.0
    return scaled, constant


def _taken_back(total: Floats, size: Floats) -> Bools:
    """Where (n_dofs,) nothing but round-off is left of forces whose sum is the total, and that of their sizes `size`.

    Both are in N/m.
    """
    left = np.abs(total)
    nothing = left <= np.maximum(TAKEN_BACK * size, ROUND_OFF * size.max(initial=0.0))
    return np.asarray(nothing & (left <= 0.5 * size))


def _unheld(cover: Cover, contact: ContactSystem, outcome: ContactOutcome) -> list[str]:
    """What to say of pieces that have rigid motions which neither supports nor pressed contact points see."""
    state = outcome.points.state
    pressed, stuck = state != OPEN, state == STICK
    rows = [contact.system.constraints, contact.gap_of[pressed], contact.slip_of[stuck]]
    pieces = free_motions(cover, csr_array(vstack(rows, format="csr"))).pieces
    return [f"{piece} may move without any resistance ({piece.motion}): where it lies is arbitrary" for piece in pieces]


def _patches_at(cover: Cover, faces: ContactFaces) -> Ints:
    """Physical patches next to the contact points."""
    elements = np.concatenate([faces.nodes.plus, faces.nodes.minus])
    return distinct(cover.patches.of_element.taken(elements[elements >= 0]).values)
