"""Loads in increments on one configuration, with what contact points remember and where the energy goes.

Of an increment from state 0 to state 1 (trapezoidal rule: exact as long as no point changes between stick, slip and
open on the way, when everything is linear in the loads)

    work        = (f_0 + f_1)/2 . (u_1 - u_0) + (m_0 + m_1)/2 . (g_1 - g_0)    of loads f and prescribed displacements g
    dissipation = int (p_t0 + p_t1)/2 (s_1 - s_0) + (p_n0 + p_n1)/2 (d_1 - d_0) ds    with slip s and dilation d

and the strain energy is u K u / 2, with that of elastic contact. Their balance holds where the equations are solved and
contact does no work of its own.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.contact.solve import ContactMemory, ContactOutcome
from crackgrow.contact.tractions import between_contact_points, nearest_contact_point
from crackgrow.run.configuration import Configuration
from crackgrow.run.result import Energy

Floats = NDArray[np.float64]

ON_OLD_FACES = 1e-6
"""Spacings: contact points closer than this to the crack as it was lie on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Remembered:
    """What the next increment needs of a state, at the contact points of the configuration it is on."""

    memory: ContactMemory
    normal: Floats  # (n,) Pa
    tangential: Floats  # (n,) Pa
    dilation: Floats  # (n,) m


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
        outcome = self.outcome
        return Remembered(outcome.memory, outcome.normal_traction, outcome.tangential_traction, outcome.dilation)


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
    remembered = Remembered(ContactMemory.fresh(n), np.zeros(n), np.zeros(n), np.zeros(n))
    return Start(0.0, False, remembered, Energy(0.0, 0.0, 0.0, 0.0, 0.0), np.zeros(3), False)


def from_state(state: LoadState) -> Start:
    """Go on from a state of the same configuration."""
    return Start(state.factor, True, state.remembered, state.energy, state.conjugates, False)


def carried(state: LoadState, configuration: Configuration) -> Start:
    """The state of another configuration, before the cracks grew, as the start on this one.

    Contact points on faces that were there before remember what was interpolated there; new faces know nothing.
    """
    old, faces, n = state.configuration, configuration.faces, configuration.faces.n
    slip, normal, tangential, dilation = np.zeros((4, n))
    broken = np.zeros(n, dtype=bool)
    for index, surface in enumerate(old.cover.surfaces):
        mine = np.flatnonzero(faces.surface == index)
        if len(mine) == 0:
            continue
        line = shapely.LineString(surface.points)
        places = shapely.points(faces.nodes.points[mine])
        there = shapely.dwithin(places, line, ON_OLD_FACES)
        mine, s = mine[there], shapely.line_locate_point(line, places[there])
        outcome = state.outcome
        for values, found in (
            (slip, outcome.memory.slip),
            (normal, outcome.normal_traction),
            (tangential, outcome.tangential_traction),
            (dilation, outcome.dilation),
        ):
            values[mine] = between_contact_points(old.cover, old.faces, index, s, found)
        nearest = nearest_contact_point(old.cover, old.faces, index, s)
        broken[mine] = np.append(outcome.memory.broken, False)[nearest]
    remembered = Remembered(ContactMemory(slip, broken), normal, tangential, dilation)
    return Start(state.factor, True, remembered, state.energy, state.conjugates, True)


def increment(configuration: Configuration, start: Start, factor: float) -> LoadState:
    """The state at a load factor after one increment. Raises SolveError where there is none."""
    began = time.perf_counter()
    outcome, residual = configuration.equilibrium(factor, start.remembered.memory)
    support_force = -float(outcome.multipliers @ configuration.held.given)
    conjugates = np.array([configuration.scaled @ outcome.u, configuration.constant @ outcome.u, support_force])
    energy = _balance(configuration, start, factor, outcome, conjugates)
    seconds = time.perf_counter() - began
    return LoadState(configuration, factor, outcome, residual, energy, conjugates, seconds)


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
    was = start.remembered
    shear = 0.5 * (was.tangential + outcome.tangential_traction) * (outcome.memory.slip - was.memory.slip)
    normal = 0.5 * (was.normal + outcome.normal_traction) * (outcome.dilation - was.dilation)
    dissipated = float(weights @ (shear + normal))
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
