"""Loads in increments on one configuration, with what contact points remember and where the energy goes.

Of an increment from state 0 to state 1 (trapezoidal rule: exact as long as no point changes between stick, slip and
open on the way, when everything is linear in the loads)

    work        = (f_0 + f_1)/2 . (u_1 - u_0) + (m_0 + m_1)/2 . (g_1 - g_0)    of loads f and prescribed displacements g
    dissipation = int (p_t0 + p_t1)/2 (s_1 - s_0) + (p_n0 + p_n1)/2 (d_1 - d_0) ds    with slip s and dilation d

and the strain energy is u K u / 2, with that of elastic contact. Of points that change on the way more is known. One
that sticks at first and slips at the end has slipped under friction's limit, not under the smaller shear that it began
with: its p_t0 is the limit b_0, in the direction of p_t1. One that opens slips without shear. Pressure begins where the
gap has closed and ends where it opens: it does no work on the gap. The work of the loads, whose displacement follows
the jump, changes by as much.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.contact.coulomb import OPEN, SLIP
from crackgrow.contact.faces import FacePoints, points_at
from crackgrow.contact.jump import gap_and_slip
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.solve import ContactOutcome
from crackgrow.contact.tractions import between_contact_points, nearest_contact_point
from crackgrow.cover.cover import Surface
from crackgrow.run.configuration import Configuration
from crackgrow.run.result import Energy

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ON_OLD_FACES = 1e-6
"""Spacings: points closer than this to the crack as it was lie on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Remembered:
    """What the next increment needs of a state, at the contact points of the configuration it is on."""

    memory: ContactMemory
    normal: Floats  # (n,) Pa
    tangential: Floats  # (n,) Pa
    dilation: Floats  # (n,) m
    gap: Floats  # (n,) m, less the dilation and the elastic part: zero at closed points


@dataclass(frozen=True, slots=True, eq=False)
class LoadState:
    """A configuration under its loads."""

    configuration: Configuration
    factor: float
    outcome: ContactOutcome
    residual: float
    energy: Energy
    conjugates: Floats  # (3,): displacement under the loads per load factor, m N/m; under held loads; support force
    seconds: float  # of all increments

    @property
    def remembered(self) -> Remembered:
        """What the next increment on this configuration needs."""
        outcome, gap = self.outcome, _free_gap(self.configuration, self.outcome)
        return Remembered(outcome.memory, outcome.normal_traction, outcome.tangential_traction, outcome.dilation, gap)


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where an increment starts from: the unloaded state, or the state of another configuration carried over."""

    factor: float
    holding: bool  # whether loads that are held act already
    remembered: Remembered
    energy: Energy
    conjugates: Floats
    grown: bool  # whether the configuration has changed on the way: what is missing was released by growth


def unloaded(configuration: Configuration) -> Start:
    """Nothing has happened yet."""
    n = configuration.faces.n
    remembered = Remembered(ContactMemory.fresh(n), *np.zeros((4, n)))
    return Start(0.0, False, remembered, Energy(0.0, 0.0, 0.0, 0.0, 0.0), np.zeros(3), False)


def from_state(state: LoadState) -> Start:
    """Go on from a state of the same configuration."""
    return Start(state.factor, True, state.remembered, state.energy, state.conjugates, False)


def carried(state: LoadState, configuration: Configuration) -> Start:
    """The state of another configuration, before the cracks grew, as the start on this one.

    Contact points remember the slip of the faces that were there before, averaged as they average their own; tractions
    are interpolated. New faces know nothing.
    """
    old, faces, outcome = state.configuration, configuration.faces, state.outcome
    n = faces.n
    jump = np.zeros(len(faces.lengths))  # at the integration points
    elastic, normal, tangential, dilation, gap = np.zeros((5, n))
    broken = np.zeros(n, dtype=bool)
    for index, surface in enumerate(old.cover.surfaces):
        points, s = _on_old_faces(faces.points, index, surface)
        jump[points] = gap_and_slip(old.cover, points_at(old.cover, index, s), outcome.u)[1]
        mine, s = _on_old_faces(faces.nodes, index, surface)
        for values, found in (
            (elastic, old.contact.law.compliance * outcome.tangential_traction),
            (normal, outcome.normal_traction),
            (tangential, outcome.tangential_traction),
            (dilation, outcome.dilation),
            (gap, state.remembered.gap),
        ):
            values[mine] = between_contact_points(old.cover, old.faces, index, s, found)
        nearest = nearest_contact_point(old.cover, old.faces, index, s)
        broken[mine] = np.append(outcome.memory.broken, False)[nearest]
    slip = faces.functions @ (faces.lengths * jump) / faces.weights - elastic
    remembered = Remembered(ContactMemory(slip, broken), normal, tangential, dilation, gap)
    return Start(state.factor, True, remembered, state.energy, state.conjugates, True)


def _on_old_faces(points: FacePoints, index: int, surface: Surface) -> tuple[Ints, Floats]:
    """Which points of a surface lie on it as it was, and their arc lengths there."""
    mine = np.flatnonzero(points.surface == index)
    line, places = shapely.LineString(surface.points), shapely.points(points.points[mine])
    there = shapely.dwithin(places, line, ON_OLD_FACES)
    return mine[there], shapely.line_locate_point(line, places[there])


def increment(configuration: Configuration, start: Start, factor: float) -> LoadState:
    """The state at a load factor after one increment. Raises SolveError where there is none."""
    began = time.perf_counter()
    outcome, residual = configuration.equilibrium(factor, start.remembered.memory)
    support_force = -float(outcome.multipliers @ configuration.held.given)
    conjugates = np.array([configuration.scaled @ outcome.u, configuration.constant @ outcome.u, support_force])
    energy = _balance(configuration, start, factor, outcome, conjugates)
    seconds = time.perf_counter() - began
    return LoadState(configuration, factor, outcome, residual, energy, conjugates, seconds)


def held_loads(configuration: Configuration) -> Start:
    """The state of the held loads alone, which come first where contact remembers anything.

    Raises SolveError where there is none.
    """
    start, law = unloaded(configuration), configuration.contact.law
    remembers = (law.friction > 0.0) | (law.cohesion > 0.0)
    if configuration.constant.any() and remembers.any():
        return from_state(increment(configuration, start, 0.0))
    return start


def _balance(
    configuration: Configuration, start: Start, factor: float, outcome: ContactOutcome, conjugates: Floats
) -> Energy:
    """The energies after an increment."""
    before, change = start.energy, conjugates - start.conjugates
    mean_factor, mean_holding = 0.5 * (start.factor + factor), 1.0 if start.holding else 0.5
    mean_support = 0.5 * (start.conjugates[2] + conjugates[2])
    work = mean_factor * change[0] + mean_holding * change[1] + mean_support * (factor - start.factor)
    weights, law = configuration.contact.weights, configuration.contact.law
    strain = 0.5 * float(outcome.u @ (configuration.matrix @ outcome.u))
    tractions = outcome.normal_traction**2 + outcome.tangential_traction**2
    strain += 0.5 * float(weights @ (law.compliance * tractions))
    dissipated, more_work = _contact_work(configuration, start.remembered, outcome)
    work += more_work
    missing = float(work) - (strain - before.strain) - dissipated
    total = Energy(
        work=before.work + float(work),
        strain=strain,
        dissipated=before.dissipated + dissipated,
        released=before.released + (missing if start.grown else 0.0),
        error=0.0,
    )
    size = max(abs(total.work), strain, abs(total.dissipated))
    left = total.work - total.strain - total.dissipated - total.released
    return Energy(total.work, strain, total.dissipated, total.released, abs(left) / size if size > 0.0 else 0.0)


def _contact_work(configuration: Configuration, was: Remembered, outcome: ContactOutcome) -> tuple[float, float]:
    """What an increment dissipates (J/m), and by how much the loads' work is more than the trapezoidal rule says."""
    weights, law = configuration.contact.weights, configuration.contact.law
    friction, cohesion = law.bound_of(outcome.memory.broken)
    limit = np.copysign(np.maximum(cohesion - friction * was.normal, 0.0), outcome.tangential_traction)
    is_slip, is_open = outcome.state == SLIP, outcome.state == OPEN
    shear_then = np.where(is_slip, limit, np.where(is_open, 0.0, was.tangential))
    slipped = outcome.memory.slip - was.memory.slip
    by_slip = 0.5 * weights @ ((shear_then + outcome.tangential_traction) * slipped)
    pressed = 0.5 * weights * (was.normal + outcome.normal_traction)
    by_dilation = pressed @ (outcome.dilation - was.dilation)
    late = 0.5 * weights @ ((shear_then - was.tangential) * slipped)
    on_gap = pressed @ (_free_gap(configuration, outcome) - was.gap)
    return float(by_slip + by_dilation), float(late - on_gap)


def _free_gap(configuration: Configuration, outcome: ContactOutcome) -> Floats:
    """Gap (n,) m less the dilation and the elastic part: zero at closed points."""
    elastic = configuration.contact.law.compliance * outcome.normal_traction
    return np.asarray(outcome.gap - outcome.dilation - elastic)
