"""Loads in increments on one configuration: the states on the path, each with its energies (`energies`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import LoadHistory
from crackgrow.case.surface import SurfaceName
from crackgrow.contact.coulomb import OPEN, ContactMemory
from crackgrow.contact.faces import FacePoints, points_at
from crackgrow.contact.solve import ContactOutcome, PointStates
from crackgrow.cover.cover import Cover, Surface
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.clock import timed
from crackgrow.run.configuration import SIGNS, Configuration, Excavated, LoadLevel
from crackgrow.run.energies import Course, course_of_jump, course_to, dissipated_on, strain_energy
from crackgrow.run.path import MOST_JUMPS, Piece, next_piece, starts_in_proportion
from crackgrow.run.result import BALANCED, ContactPoints, CrackFaces, Energy
from crackgrow.run.scene import Scene
from crackgrow.run.state_values import along_surfaces
from crackgrow.solid.elasticity import PlaneElasticity

MOST_PIECES = 2000
"""Pieces of an increment, after which the rest of it is taken at once."""

FEW_POINTS, INCREMENTS = 200, 8
"""Where a growing load acts on more contact points of plain friction it is taken in so many increments: events would be
hundreds, each at the cost of some increments. Slip and K are the same, of the dissipation 0.1 to 6 % is lost."""

SIMPSON = 2.0 / 3.0
"""Of what is in the middle beyond the mean of both ends: what the mean over all of the way has beyond it."""


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where an increment starts from: the unloaded state, the one before, that of another configuration carried over.

    What is remembered is that of the condensed model, which increments are solved on: tractions that were corrected for
    displacements would not be on any path of it.
    """

    level: LoadLevel  # how much of the loads acts already
    memory: ContactMemory
    energy: Energy
    conjugates: Floats  # (3,): displacement under the loads per load factor, m N/m; under held loads; support force
    round_off: float = 0.0  # J/m: the round-off of what the energies have been sums of on the way
    course: Course = field(default_factory=dict)  # what faces have done since the step began
    grown: bool = False  # whether the configuration has changed on the way: what is missing was released by growth


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadState(Start):
    """A configuration under its loads, from which the next increment starts."""

    configuration: Configuration
    before: ContactMemory  # what points remembered when the increment began
    states: PointStates  # of the condensed model
    notes: tuple[str, ...] = ()  # what the user should know of how it was found
    via: tuple[LoadState, ...] = ()  # the states that an increment went through, in turn
    formed: ContactOutcome | None = None  # None: displacements are formed when they are asked for

    @property
    def factor(self) -> float:
        """The load factor."""
        return self.level.factor

    @property
    def scene(self) -> Scene:
        """The scene of the configuration."""
        return self.configuration.scene

    @property
    def cover(self) -> Cover:
        """The cover of the configuration."""
        return self.configuration.cover

    @property
    def cracks(self) -> tuple[GrowingCrack, ...]:
        """The cracks of the configuration."""
        return self.configuration.cracks

    @cached_property
    def materials(self) -> tuple[PlaneElasticity, ...]:
        """Materials, body by body, in-situ stress included."""
        return self.scene.materials_at(self.factor)

    @cached_property
    def outcome(self) -> ContactOutcome:
        """Displacements and tractions. Raises SolveError where they don't balance."""
        return self.formed or self.configuration.equilibrium(self.level, self.before, self.states)

    @cached_property
    def along_surfaces(self) -> tuple[ContactPoints, tuple[CrackFaces, ...]]:
        """Contact points and samples of all surfaces."""
        return along_surfaces(self)

    def light(self) -> LoadState:
        """The state without what its contact was found by, which is large."""
        return replace(self, states=self.states.light())


@dataclass(frozen=True, slots=True, eq=False)
class Origin:
    """What a step goes on from besides its cracks: with both it can be solved again, to the same bits."""

    guess: float = 1.0  # load factor that a search for the critical one tries first
    start: Start | None = None  # None: the case's loads come one after the other, from the unloaded state on
    excavated: tuple[Excavated, ...] = ()  # rock that has been taken out


FROM_REST = Origin()
"""The first step."""


def unloaded(configuration: Configuration) -> Start:
    """Nothing has happened yet."""
    n = configuration.faces.n
    memory = ContactMemory.fresh(n)
    holding = 0.0 if configuration.constant.any() else 1.0
    return Start(LoadLevel(0.0, holding), memory, Energy(0.0, 0.0, 0.0, 0.0, 0.0), np.zeros(3))


def next_load(state: LoadState) -> Start:
    """Go on from a state with the next load of the case, which is a step of its own unless cracks grow."""
    course = {} if state.scene.case.growth is None else state.course
    return Start(state.level, state.memory, state.energy, state.conjugates, state.round_off, course)


def mapped(state: LoadState, configuration: Configuration) -> Start:
    """The state of another configuration, before the cracks grew or rock was taken out, as the start on this one.

    Contact points remember the slip of the faces that were there before, averaged as they average their own; tractions
    are interpolated. New faces know nothing. Surfaces all of whose points are where they were remember the same to the
    bit: by the round-off of slip that is read off displacements bonds would break where all loads go.
    """
    old, faces, outcome, points = state.configuration, configuration.faces, state.outcome, state.outcome.points
    n = faces.n
    jump = np.zeros(len(faces.lengths))  # at the integration points
    elastic, normal, tangential, dilation, risen, lost = np.zeros((6, n))
    closed = np.ones(n, dtype=bool)
    numbers = {_first_of_many(surface.name): n for n, surface in enumerate(configuration.cover.surfaces)}
    for index, surface in enumerate(old.cover.surfaces):
        if (name := _first_of_many(surface.name)) not in numbers:
            continue
        mine, s = _on_old_faces(faces.points, numbers[name], surface)
        jump[mine] = old.gap_and_slip(state.level, points_at(old.cover, index, s), outcome.u)[1]
        mine, s = _on_old_faces(faces.nodes, numbers[name], surface)
        for values, found in (
            (elastic, old.contact.law.shear_compliance * points.tangential),
            (normal, points.normal),
            (tangential, points.tangential),
            (dilation, points.dilation),
            (risen, outcome.memory.risen),
        ):
            (values[mine],) = old.faces.between(index, s, found)
        nearest = old.faces.nearest(index, s)
        lost[mine] = np.append(outcome.memory.lost, 0.0)[nearest]
        closed[mine] = np.append(points.state != OPEN, True)[nearest]
    slip = faces.functions @ (faces.lengths * jump) / faces.weights - elastic
    memory = ContactMemory(slip, lost, closed | (lost == 0.0), risen, normal, tangential, dilation)
    for index, surface in enumerate(old.cover.surfaces):
        before = np.flatnonzero(old.faces.surface == index)
        after = np.flatnonzero(faces.surface == numbers.get(_first_of_many(surface.name), -1))
        if np.array_equal(old.faces.nodes.points[before], faces.nodes.points[after]):
            for kind, array in memory.arrays.items():
                array[after] = state.memory.arrays[kind][before]
    return Start(state.level, memory, state.energy, state.conjugates, state.round_off, grown=True)


def _first_of_many(name: SurfaceName) -> SurfaceName:
    """The name of a surface whether or not there are others like it: an interface may part at one more place."""
    return replace(name, number=name.number or 0)


def _on_old_faces(points: FacePoints, index: int, surface: Surface) -> tuple[Ints, Floats]:
    """Which points of the surface of a number lie on it as it was, and their arc lengths there."""
    mine = np.flatnonzero(points.surface == index)
    line, places = shapely.LineString(surface.line.points), shapely.points(points.points[mine])
    there = shapely.dwithin(places, line, SAME_PLACE)
    return mine[there], shapely.line_locate_point(line, places[there])


def increment(configuration: Configuration, start: Start, factor: float) -> LoadState:
    """The state at a load factor, with all held loads. Raises SolveError where there is none."""
    end = LoadLevel(factor)
    with timed("contact"):
        if start.grown:
            return _formed(_ended(start, [_booked(_part(configuration, start, end), start)], 0))
        reached, in_turn = list[LoadState](), 0
        for state, jumps in follow(configuration, start, end):
            reached.append(state if state.level == end else state.light())
            in_turn = jumps
        return _formed(_ended(start, reached, in_turn))


def rising(configuration: Configuration, start: Start, factor: float) -> Iterator[LoadState]:
    """The states on the way to a load factor, each as after an increment up to it, as far as contact bears the load.

    Raises SolveError where no branch goes on, or there are no displacements.
    """
    reached = list[LoadState]()
    for state, jumps in follow(configuration, start, LoadLevel(factor), open_ended=True):
        yield _formed(_ended(start, [*reached, state], jumps))
        reached.append(state.light())


def _ended(start: Start, reached: Sequence[LoadState], jumps: int) -> LoadState:
    """The last of the states that were reached from a start, with the others and what is in doubt; jumps led there."""
    energies, notes = [start.energy, *(state.energy for state in reached)], list[str]()
    smaller = "apply the load in smaller steps (loading.history)"
    if jumps > MOST_JUMPS or len(reached) > MOST_PIECES:
        notes.append(
            f"contact points change in {len(reached)} pieces of one load, and how they change in the rest of it "
            f"was not followed: which of them break or slip, and where, is only as good as that; {smaller}"
        )
    fallen = max(one.dissipated - other.dissipated for one, other in pairwise(energies))
    if fallen > BALANCED * max(energy.size for energy in energies):
        where = "as cracks grow; use smaller cells" if start.grown else f"in a part of the load; {smaller}"
        notes.append(f"what friction dissipates falls by {fallen:.2g} J/m {where}")
    return replace(reached[-1], via=tuple(reached[:-1]), notes=tuple(notes))


def follow(
    configuration: Configuration, start: Start, end: LoadLevel, *, open_ended: bool = False
) -> Iterator[tuple[LoadState, int]]:
    """The states on the way from a start to a load, in turn, and how many jumps in turn have led to each.

    Raises SolveError where there is none at the load; where the way is `open_ended` at that up to which there are any.
    """
    at, number = start, _number_of(configuration, start)
    for share in np.linspace(0.0, 1.0, number + 1)[1:].tolist() if number else ():
        state = _part(configuration, at, start.level.towards(end, share))
        yield state, 0
        at = state
    pieces, jumps = number, 0
    before: Piece | None = None
    largest = max(abs(start.level.factor), abs(end.factor))
    while not pieces or at.level != end:
        if pieces < MOST_PIECES:
            piece = next_piece(configuration, at.memory, (at.level, end), largest, jumps, before, open_ended)
            state = _stated(configuration, at, piece.states, at.level.towards(end, piece.share), piece.middle)
            before, is_jump = piece if piece.kind == "straight" else None, piece.kind == "jump"
        else:
            state, is_jump = _part(configuration, at, end), True
        jumps = jumps + 1 if is_jump else 0
        if is_jump:
            state = _booked(state, at)
            released = state.energy.released - at.energy.released
            state = replace(state, course=course_of_jump(state, at, released))
        yield state, jumps
        at, pieces = state, pieces + 1


def _number_of(configuration: Configuration, start: Start) -> int:
    """Number of increments that a load is taken in, 0 where it goes from event to event."""
    loading = configuration.scene.case.loading
    if not isinstance(loading, LoadHistory):
        return 0
    if loading.increments is not None:
        return 0 if loading.increments == "events" else loading.increments
    few = configuration.faces.n <= FEW_POINTS or starts_in_proportion(configuration, start.memory, start.level)
    return INCREMENTS if loading.grows and configuration.forgets and not few else 0


def equilibrated(state: LoadState, configuration: Configuration) -> Start:
    """The state of another configuration mapped to this one, in equilibrium under the same loads, as the start.

    What this one does not store any more is released.
    """
    start = mapped(state, configuration)
    states = configuration.states(state.level, start.memory)
    start = replace(start, conjugates=configuration.conjugates(state.level, states))
    found = _booked(_stated(configuration, start, states, state.level), start)
    return replace(next_load(found), course=next_load(state).course)


def _formed(state: LoadState) -> LoadState:
    """The state with its displacements. Raises SolveError where there are none."""
    formed = state.outcome
    return replace(state, states=state.states.light(keep=True), formed=formed)


def held_loads(configuration: Configuration) -> Start:
    """The state of the held loads alone, which come first where contact remembers anything. Raises SolveError."""
    start, law = unloaded(configuration), configuration.contact.law
    remembers = law.friction.any() or law.cohesion.any() or law.tension.any()
    if configuration.constant.any() and remembers:
        return increment(configuration, start, 0.0)
    return start


def _part(configuration: Configuration, start: Start, level: LoadLevel) -> LoadState:
    """The state after one implicit increment: a point that slips at its end has slipped in all of it."""
    return _stated(configuration, start, configuration.states(level, start.memory), level)


def _stated(
    configuration: Configuration, start: Start, states: PointStates, level: LoadLevel, middle: PointStates | None = None
) -> LoadState:
    """The state with its energies, of the states of contact points; in the `middle` too where the way is bent."""
    was, conjugates = start.memory, configuration.conjugates(level, states)
    none = Energy(start.energy.work, 0.0, start.energy.dissipated, start.energy.released, 0.0)
    memory = configuration.increment(level, was).memory_after(states)
    state = LoadState(level, memory, none, conjugates, configuration=configuration, before=was, states=states)
    shares = [configuration.shares(at) for at in (start.level, level)]
    change, more = conjugates - start.conjugates, shares[1] - shares[0]
    mean = 0.5 * (start.conjugates + conjugates)
    work = 0.5 * (shares[0] + shares[1])[:2] @ change[:2] + mean[2] * more[2]
    if middle is not None:
        bulge = SIMPSON * (configuration.conjugates(start.level.towards(level, 0.5), middle) - mean)
        work -= SIGNS * bulge @ more
    strain, terms = strain_energy(state)
    round_off = max(terms, start.round_off)  # work that comes back keeps the round-off of what it was
    slides, by_point = dissipated_on(state, middle)
    dissipated = none.dissipated + float(by_point.sum())
    energy = _checked(replace(none, work=none.work + float(work), strain=strain, dissipated=dissipated), round_off)
    return replace(state, energy=energy, round_off=round_off, course=course_to(state, start, slides, by_point))


def _missing(energy: Energy) -> float:
    """What the energies miss of each other, J/m."""
    return energy.work - energy.strain - energy.dissipated - energy.released


def _checked(energy: Energy, round_off: float) -> Energy:
    """The energies with their error, beyond what is round-off."""
    left = max(abs(_missing(energy)) - round_off, 0.0)
    return replace(energy, error=left / energy.size if energy.size > 0.0 else 0.0)


def _booked(state: LoadState, start: Start) -> LoadState:
    """A state with what is missing since the start booked as released."""
    missing = _missing(state.energy) - _missing(start.energy)
    released = replace(state.energy, released=state.energy.released + missing)
    return replace(state, energy=_checked(released, state.round_off))
