"""The energies of states on a path: what loads do on the way from one to another, what becomes of it, and where.

Within a straight piece of the path (`path`) everything is linear in the loads, so that these are exact (trapezoidal
rule); on a bent one, where strength falls with slip, Simpson's rule takes the middle in:

    work        = (f_0 + f_1)/2 . (u_1 - u_0) + (m_0 + m_1)/2 . (g_1 - g_0)    of loads f and prescribed displacements g
    dissipation = int (b_0 + b_1)/2 |s_1 - s_0| + (p_n0 + p_n1)/2 (d_1 - d_0) ds    of slip s and dilation d

with b the shear that the law of friction allows (its mean over the slip), and the strain energy is u K u / 2, with that
of elastic contact. Where points jump, since bonds break or let go, friction does not take all that the loads and the
rock give, and the rest is released.

A laboratory would hear where the energy goes: faces that slip, open and break on the way of the loads. Each kind is
told once of a surface in a step, with the load and the place at which it begins, and with all the energy that goes into
it until the end of the step, so that the events of a step add up to its energies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.contact.coulomb import OPEN, SLIP, ContactLaw, ContactMemory
from crackgrow.contact.solve import PointStates
from crackgrow.geometry.tolerance import ROUND_OFF
from crackgrow.run.result import Event, EventKind

if TYPE_CHECKING:
    from crackgrow.run.increments import LoadState, Start

Course = Mapping[tuple[str, EventKind], Event]
"""The events of surfaces since the step began, by surface and kind, in the order of their beginning; without a step."""

NO_STEP = -1


def strain_energy(state: LoadState) -> tuple[float, float]:
    """Strain energy (J/m) of rock, u K u / 2 = u'(f - C'm - G'W p) / 2, and of elastic contact, and its round-off."""
    contact, states, shares = state.configuration.contact, state.states, state.configuration.shares(state.level)
    sizes = state.configuration.conjugate_terms(state.level, states) * np.abs(shares)
    loads = state.conjugates * shares
    jumps = np.concatenate([states.gap + states.dilation, states.slip])
    law = contact.law
    elastic = np.concatenate([-law.closure(states.normal), law.shear_compliance * states.tangential])
    tractions = np.tile(contact.weights, 2) * states.tractions
    terms = float(np.maximum(np.abs(loads), sizes).sum() + np.abs(tractions * jumps).sum())
    bent = contact.weights @ contact.law.stored(states.normal)
    return 0.5 * float(loads.sum() - tractions @ (jumps - elastic)) + float(bent), ROUND_OFF * terms


def dissipated_on(state: LoadState, middle: PointStates | None) -> tuple[Bools, Floats]:
    """Which points (n,) slide to a state; what friction and dilation take (n,) J/m, by the `middle` of a bent way."""
    contact, was, now, states = state.configuration.contact, state.before, state.memory, state.states
    weights, law = contact.weights, contact.law
    closed, slides, taken = states.state != OPEN, states.state == SLIP, states.trial.taken
    if states.active is not None:  # at the end of a piece points are about to leave these branches
        closed[taken] = states.active.closed
        slides[taken] = (states.active.slip != 0) & (states.active.closed | states.coheres[taken])
    bulge = np.zeros(len(weights)) if middle is None else _bulge(law, was, now, middle)
    resisted = _resisted(law, was, now, bulge, states.trial.opened)
    by_slip = resisted * np.abs(now.slip - was.slip)
    by_dilation = (was.normal + now.normal + bulge / 3.0) * (now.dilation - was.dilation)
    return slides, 0.5 * weights * (np.where(slides, by_slip, 0.0) + np.where(closed, by_dilation, 0.0))


def _bulge(law: ContactLaw, was: ContactMemory, now: ContactMemory, middle: PointStates) -> Floats:
    """What normal tractions (n,) Pa on the way have beyond those that are linear in slip, over share (1 - share) of it.

    Where a point does not slip it does not matter.
    """
    slip = now.slip - was.slip
    moved = middle.slip - law.shear_compliance * middle.tangential - was.slip
    share = np.divide(moved, slip, out=np.full(len(slip), 0.5), where=slip != 0.0)
    share = np.where(np.abs(share - 0.5) < 0.25, share, 0.5)
    linear = was.normal + share * (now.normal - was.normal)
    return np.asarray((middle.normal - linear) / (share * (1.0 - share)))


def _resisted(law: ContactLaw, was: ContactMemory, now: ContactMemory, bulge: Floats, opened: Bools) -> Floats:
    """Twice the mean of the law's shear (n,) Pa over slip, by Simpson's rule up to where all is lost, and beyond."""
    slip = now.slip - was.slip
    worn = law.worn(was.lost, slip)
    left = np.where(law.weakens, 1.0 - was.lost, 0.0)
    falls = np.divide(left, worn, out=np.where(left > 0.0, 1.0, 0.0), where=worn > left)  # share of the slip

    def shear(share: Floats | float) -> Floats:
        """After a share of the slip."""
        falling = np.minimum(law.worn(was.lost, share * slip), left)
        lost = np.where(law.weakens, was.lost + falling, now.lost)
        normal = was.normal + share * (now.normal - was.normal) + share * (1.0 - share) * bulge
        friction, cohesion = law.bound_of(lost, normal)
        cohesion[opened] = 0.0  # where they have opened faces do not cohere, though they may touch again
        return np.maximum(cohesion - friction * normal, 0.0)

    first, fallen, last = shear(0.0), shear(falls), shear(1.0)
    falling = first + 4.0 * shear(0.5 * falls) + fallen
    beyond = fallen + 4.0 * shear(0.5 * (1.0 + falls)) + last
    return (falls * falling + (1.0 - falls) * beyond) / 3.0


def course_to(state: LoadState, start: Start, slides: Bools, dissipated: Floats) -> Course:
    """The course after a straight or bent piece of the way, on which points slide and friction takes (n,) J/m."""
    course = _with_begun(start.course, state, start, slides, _losing(state, start) & ~start.memory.broken)
    return _with_energy(course, "slip", state, dissipated)


def course_of_jump(state: LoadState, start: Start, energy: float) -> Course:
    """The course after a jump of points that releases energy (J/m): it goes to what breaks, by the length of that.

    Where nothing breaks it goes to what slips. It takes from what had begun to break in another step, too.
    """
    breaks = _losing(state, start)
    kind: EventKind = "break" if breaks.any() else "slip"
    shares = state.configuration.contact.weights * (breaks if kind == "break" else _slip(state, start))
    course = _with_begun(state.course, state, start, state.states.state == SLIP, breaks)
    return _with_energy(course, kind, state, energy * shares / shares.sum()) if shares.any() else course


def _slip(state: LoadState, start: Start) -> Floats:
    """How far (n,) m points slip between a start and a state."""
    return np.abs(state.memory.slip - start.memory.slip)


def _losing(state: LoadState, start: Start) -> Bools:
    """Which points (n,) lose of what they can lose."""
    return np.asarray(state.configuration.contact.law.breakable & (state.memory.lost > start.memory.lost))


def _with_begun(course: Course, state: LoadState, start: Start, slides: Bools, breaks: Bools) -> Course:
    """The course with what surfaces begin to do between a start and a state."""
    configuration, was = state.configuration, start.memory
    faces, slip, found = configuration.faces, _slip(state, start), dict(course)
    pressed = (was.normal < 0.0) | (start.level.factor != 0.0)  # or have just lost their pressure, at an event
    parts = was.closed & ~state.memory.closed & (was.coheres(configuration.contact.law) | pressed)
    kinds: dict[EventKind, Bools] = {"break": breaks, "slip": slides & (slip > 0.0), "opening": parts}
    for kind, which in kinds.items():
        for number in np.unique(faces.surface[which]).tolist():
            mine = np.flatnonzero(which & (faces.surface == number))
            first = state.cover.lattice.to_metres(faces.nodes.points[mine[np.argmax(slip[mine])]])
            name, factor = str(state.cover.surfaces[number].name), start.level.factor + 0.0  # no -0
            found.setdefault((name, kind), Event(NO_STEP, kind, name, "", first, "", factor, 0.0))
    return found


def _with_energy(course: Course, kind: EventKind, state: LoadState, energy: Floats) -> Course:
    """The course with more energy (n,) J/m of points in the events of one kind, of surfaces that have one."""
    surfaces, found = state.cover.surfaces, dict(course)
    of_surface = np.bincount(state.configuration.faces.surface, energy, len(surfaces))
    for number in np.flatnonzero(of_surface).tolist():
        key = str(surfaces[number].name), kind
        if (event := found.get(key)) is not None:
            found[key] = replace(event, energy=event.energy + float(of_surface[number]))
    return found
