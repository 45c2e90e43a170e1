"""The contact problem of one step, condensed onto the contact points that can be closed.

u = u_free - K0^-1 G' W p, so that gap and slip of the contact points are free - S W p with S = G K0^-1 G'
(traction form of paper eqs. (15), (16): no penalty enters K, and k = infinity is allowed). Points that cohere when the
increment begins are among the unknowns, since shear can open faces that only the bond keeps from slipping. Others that
are open without contact tractions are left out; those that then overlap are taken in, until none does. Points that
cohere and are neither pressed nor apart are closed: |p_t| <= c - mu p_n holds at p_n = 0 too.

Pieces of rock that contact alone holds move as rigid bodies besides. K0 holds them by supports that are just enough,
which carry nothing once the loads and the tractions balance; how far the pieces move is unknown as well.

Loads come in increments, and points remember (`ContactMemory`): a point sticks where it stuck before,

    du_t = du_t' where |p_t| < b, else du_t - du_t' has the sign of p_t,    gap >= tan(dilation) |du_t|,

with du_t' the slip after the increment before. A point that slips or opens is broken: its friction is the residual one
from then on, and its cohesion lost unless it is kept. What breaks in an increment is broken in all of it: the increment
is solved again until no more points break.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.condensation import Condensation, Rock
from crackgrow.contact.condensed import condensed, solved, spoilt
from crackgrow.contact.coulomb import (
    OPEN,
    SLIP,
    STICK,
    ContactProblem,
    ContactSolution,
    Motions,
    complementarity_residual,
)
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.system import ContactSystem
from crackgrow.solid.linear_solver import displacement_size

OVERLAP = 1e-10
"""A gap above minus this fraction of the displacement's size is no overlap but round-off."""

UNPRESSED = 1e-6
"""A pressure below this fraction of the traction that would undo the jumps at its place is none: the point is open.

Not so if it coheres and its gap is below the same fraction of these jumps: the faces touch.
"""

AT_LIMIT = 1e-9
"""Shear closer to the cohesion of faces that touch than this fraction of it has reached it: they slip."""

ROUND_OFF = 1e-12
"""Jumps by the compliance that differ from those of the displacements by less than this fraction are the same."""

SPOILT = 1e-2
"""If they differ by more, nothing can be made of the compliance."""

GAIN = 0.5
"""Corrections that leave more than this part of the difference end: it is round-off of the displacements themselves."""

UNSURE = 1e-8
"""The same, left at the end, of which the outcome carries a note."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactOutcome:
    """Displacements and the state of all contact points."""

    u: Floats  # (n_dofs,) m
    multipliers: Floats  # (m,) of the supports
    normal_traction: Floats  # (n,) Pa, negative in compression
    tangential_traction: Floats  # (n,) Pa
    gap: Floats  # (n,) m
    slip: Floats  # (n,) m
    state: Ints  # (n,)
    memory: ContactMemory
    dilation: Floats  # (n,) m: the part of the gap that slip has opened
    n_unknowns: int
    iterations: int
    penetration: float  # m: overlap beyond |p| / k
    complementarity: float  # relative
    status: Literal["none", "solved"]
    notes: tuple[str, ...]  # what the user should know of how it was solved
    rows: Ints  # (k,) points that the solver had to deal with: all others stay open
    problem: ContactProblem | None  # what it solved for them last


def solve_contact(
    contact: ContactSystem,
    loads: Floats,
    given: Floats,
    memory: ContactMemory | None = None,
    without: tuple[Floats, Floats] | None = None,
) -> ContactOutcome:
    """Displacements and contact tractions under `loads` (n_dofs,), with support displacements `given` (m,).

    `memory` is that of the increment before, None for the first; `without` are displacements and multipliers without
    contact tractions, if they are known. Raises NotSolvedError where the contact solver finds no solution.
    """
    memory = memory or ContactMemory.fresh(len(contact.weights))
    u, multipliers = contact.system.solve(loads, given) if without is None else without
    free = Rock(u, multipliers, contact.gap_of @ u, contact.slip_of @ u)
    return _Increment(contact, loads, given, memory).outcome(free)


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """What an increment is taken to do."""

    taken: Bools  # (n,) points that are among the unknowns
    broken: Bools  # (n,) points whose bond is broken, in this increment or before
    opened: Bools  # (n,) points that have opened in this increment: they do not cohere in it


@dataclass(frozen=True, slots=True, eq=False)
class _Answer:
    """What comes of a trial, at all points."""

    normal: Floats  # (n,) Pa
    tangential: Floats  # (n,) Pa
    gap: Floats  # (n,) m, less what dilation opens
    slip: Floats  # (n,) m
    dilation: Floats  # (n,) m
    state: Ints  # (n,)
    coheres: Bools  # (n,)
    rock: Condensation | None = None
    problem: ContactProblem | None = None
    solution: ContactSolution | None = None
    note: str = ""


class _Increment:
    """An increment: contact points are taken in and break until the law holds."""

    def __init__(self, contact: ContactSystem, loads: Floats, given: Floats, memory: ContactMemory) -> None:
        self._contact, self._loads, self._given, self._memory = contact, loads, given, memory

    def outcome(self, free: Rock) -> ContactOutcome:
        """The solution, where `free` is the state without contact tractions."""
        tolerance = OVERLAP * displacement_size(self._loads, free.u, self._given)
        answer = self._untouched(free)
        sees = np.any(self._contact.moving != 0.0, axis=1).reshape(2, -1).any(axis=0)
        trial = _Trial(
            self._memory.coheres(self._contact.law) | (answer.gap < -tolerance) | sees,
            self._memory.broken,
            np.zeros(len(self._contact.weights), dtype=bool),
        )
        u, multipliers, off, last_off, iterations = free.u, free.multipliers, 0.0, np.inf, 0
        notes: set[str] = set()
        while trial.taken.any():
            answer = self._answer(trial, free, answer)
            assert answer.rock is not None
            assert answer.solution is not None
            iterations += answer.solution.iterations
            notes.update([answer.note] if answer.note else [])
            revised = self._revised(trial, answer, tolerance)
            if revised is not None:
                trial, last_off = revised, np.inf
                continue
            u, multipliers = self._displacements(free, answer)
            more_gap, more_slip, off = self._missing(free, answer, u)
            if off <= ROUND_OFF or off > GAIN * last_off:
                break
            free, last_off = replace(free, gap=free.gap + more_gap, slip=free.slip + more_slip), off
        if off > UNSURE:
            notes.add(f"jumps of the faces are off by {off:.1g} of the largest: the system is ill conditioned")
        return self._told(trial, answer, (u, multipliers), (iterations, off, tolerance), tuple(sorted(notes)))

    def _untouched(self, free: Rock) -> _Answer:
        """What the rock does without contact tractions."""
        law, nothing = self._contact.law, np.zeros(len(free.gap))
        dilation = law.opening(free.slip)
        state, coheres = np.full(len(free.gap), OPEN), np.zeros(len(free.gap), dtype=bool)
        return _Answer(nothing, nothing, free.gap - dilation, free.slip, dilation, state, coheres)

    def _answer(self, trial: _Trial, free: Rock, start: _Answer) -> _Answer:
        """Tractions and jumps of a trial, looked for from those of another one on."""
        contact, law, before = self._contact, self._contact.law, self._memory.slip
        friction, cohesion = law.bound_of(trial.broken)
        cohesion[trial.opened] = 0.0
        rows = np.flatnonzero(trial.taken)
        slides = (friction > 0.0) | (cohesion > 0.0) | (law.dilating > 0.0)
        sliding = rows if slides[rows].any() else rows[:0]
        rock = contact.onto(rows, sliding)
        compliance = condensed(contact, rock.compliance, rows, sliding)
        jumps = np.concatenate([free.gap[rows], (free.slip - before)[sliding]])
        motions = self._motions(rows, sliding)
        if len(sliding):
            laws = (friction[rows], cohesion[rows], law.dilating[rows], before[rows])
            problem = ContactProblem(compliance, jumps, *laws, motions)
        else:
            problem = ContactProblem(compliance, jumps, motions=motions)
        known = None
        if start.solution is not None:
            known = np.concatenate([start.normal[rows], start.tangential[sliding], start.solution.motion])
        solution, note = solved(problem, contact.weights[rows], contact.solver, known)
        p_n, p_t = np.zeros((2, len(friction)))
        p_n[rows], p_t[sliding] = np.split(solution.traction, [len(rows)])
        gap, slip = self._jumps(free, rock, solution)
        dilation = law.opening(slip - law.compliance * p_t)
        state = np.full(len(friction), OPEN)
        found = _Answer(p_n, p_t, gap - dilation, slip, dilation, state, cohesion > 0.0, rock, problem, solution, note)
        state[rows] = _states(found, rows, cohesion[rows])
        return found

    def _motions(self, rows: Ints, sliding: Ints) -> Motions | None:
        """The rigid motions that supports leave free, as these points see them."""
        contact = self._contact
        if contact.loose is None:
            return None
        at = np.concatenate([rows, len(contact.weights) + sliding])
        jump = contact.moving[at]
        return Motions(jump, (jump * np.tile(contact.weights, 2)[at, None]).T, contact.loose.along(self._loads))

    def _jumps(self, free: Rock, rock: Condensation, solution: ContactSolution) -> tuple[Floats, Floats]:
        """Gap and slip (n,) m of all points."""
        gap, slip = rock.jumps(free, solution.traction)
        if self._contact.loose is None:
            return gap, slip
        moved_gap, moved_slip = np.split(self._contact.moving @ solution.motion, 2)
        return gap + moved_gap, slip + moved_slip

    def _displacements(self, free: Rock, answer: _Answer) -> tuple[Floats, Floats]:
        """Displacements (n_dofs,) m and multipliers (m,), with supports that follow pieces: they carry nothing."""
        assert answer.rock is not None
        assert answer.solution is not None
        loads, loose = self._loads, self._contact.loose
        if loose is not None:
            loads = loads + loose.carrying(answer.solution.motion)
        return answer.rock.displacements(free, loads, self._given, answer.solution.traction)

    def _revised(self, trial: _Trial, answer: _Answer, tolerance: float) -> _Trial | None:
        """The next trial: with points that overlap, that break, or that open; None if there are no more."""
        missed = ~trial.taken & (answer.gap < -tolerance)
        if missed.any():
            return replace(trial, taken=trial.taken | missed)
        breaking = trial.taken & (answer.state != STICK) & ~trial.broken & self._contact.law.breakable
        if breaking.any():
            return replace(trial, broken=trial.broken | breaking)
        opening = trial.taken & (answer.state == OPEN) & answer.coheres & ~trial.opened
        return replace(trial, opened=trial.opened | opening) if opening.any() else None

    def _missing(self, free: Rock, answer: _Answer, u: Floats) -> tuple[Floats, Floats, float]:
        """Gap and slip (n,) m of the displacements `u` (n_dofs,) less those by the compliance.

        The compliance is good to the round-off of one elimination, the displacements are refined. The third is the
        largest difference, relative to the jumps. Raises NotSolvedError where the compliance is wrong altogether.
        """
        gap, slip = answer.gap + answer.dilation, answer.slip
        more_gap, more_slip = self._contact.gap_of @ u - gap, self._contact.slip_of @ u - slip
        off, farthest = (
            max(float(np.abs(jumps).max()) for jumps in some)
            for some in ((more_gap, more_slip), (gap, slip, free.gap, free.slip))
        )
        if not off <= SPOILT * farthest:
            raise spoilt(f"wrong by {off / farthest:.1g} of the jumps")
        return more_gap, more_slip, off / farthest if farthest > 0.0 else 0.0

    def _told(
        self,
        trial: _Trial,
        answer: _Answer,
        rock: tuple[Floats, Floats],
        how: tuple[int, float, float],
        notes: tuple[str, ...],
    ) -> ContactOutcome:
        """The outcome of the last trial, with displacements and multipliers of the `rock`.

        `how`: the iterations, what the jumps are off by, and the overlap (m) that is none.
        """
        law, (iterations, off, tolerance) = self._contact.law, how
        apart = (answer.state == OPEN) & (answer.gap > tolerance)
        slip = answer.slip - law.compliance * answer.tangential
        broken = trial.broken | (answer.state == SLIP) | apart
        rows = np.flatnonzero(trial.taken)
        complementarity = 0.0
        if answer.problem is not None and answer.solution is not None:
            complementarity = complementarity_residual(answer.problem, answer.solution.unknowns)
        return ContactOutcome(
            u=rock[0],
            multipliers=rock[1],
            normal_traction=answer.normal,
            tangential_traction=answer.tangential,
            gap=answer.gap + answer.dilation,
            slip=answer.slip,
            state=answer.state,
            memory=ContactMemory(slip, broken, ~apart),
            dilation=answer.dilation,
            n_unknowns=0 if answer.problem is None else len(answer.problem.free),
            iterations=iterations,
            penetration=float(np.max(-(answer.gap - law.compliance * answer.normal), initial=0.0)),
            complementarity=max(complementarity, off),
            status="solved" if len(rows) else "none",
            notes=notes,
            rows=rows,
            problem=answer.problem,
        )


def _states(answer: _Answer, rows: Ints, cohesion: Floats) -> Ints:
    """The states (k,) of the points `rows` (k,): of `coulomb`, but for what round-off makes of points nearly open.

    Each is weighed by the terms that its own jumps are the sums of, whatever goes on elsewhere.
    """
    problem, solution = answer.problem, answer.solution
    assert problem is not None
    assert solution is not None
    terms = np.abs(problem.compliance) @ np.abs(solution.traction) + np.abs(problem.free)
    terms = terms.reshape(-1, len(rows)).max(axis=0)
    unpressed = answer.normal[rows] >= -UNPRESSED * terms / problem.scale[: len(rows)]
    apart = answer.gap[rows] > UNPRESSED * terms
    held = np.where(np.abs(answer.tangential[rows]) < (1.0 - AT_LIMIT) * cohesion, STICK, SLIP)
    return np.where(unpressed, np.where((cohesion > 0.0) & ~apart, held, OPEN), solution.state)
