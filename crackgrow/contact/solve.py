"""The contact problem of one step, condensed onto the contact points that can be closed.

u = u_free - K0^-1 G' W p, so that gap and slip of the contact points are free - S W p with S = G K0^-1 G'
(traction form of paper eqs. (15), (16): no penalty enters K, and k = infinity is allowed). Points that cohere when the
increment begins are among the unknowns, since shear can open faces that only the bond keeps from slipping. Others that
are open without contact tractions are left out; those that then overlap are taken in, until none does. Points that
cohere and are neither pressed nor apart are closed: |p_t| <= c - mu p_n holds at p_n = 0 too.

Loads come in increments, and points remember (`ContactMemory`): a point sticks where it stuck before,

    du_t = du_t' where |p_t| < b, else du_t - du_t' has the sign of p_t,    gap >= tan(dilation) |du_t|,

with du_t' the slip after the increment before. A point that slips or opens is broken: its friction is the residual one
from then on, and its cohesion lost unless it is kept. What breaks in an increment is broken in all of it: the increment
is solved again until no more points break. With dilation, the gap less tan(dilation) |du_t| takes the gap's place. It
is linear in the unknowns once the sense of the slip is known: the increment is solved again until no point slips the
other way than it was taken to.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.condensation import Condensation, Rock
from crackgrow.contact.condensed import condensed, solved, spoilt
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ContactProblem, complementarity_residual
from crackgrow.contact.law import ContactMemory
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import SolveError
from crackgrow.solid.linear_solver import displacement_size

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

OVERLAP = 1e-10
"""A gap above minus this fraction of the displacement's size is no overlap but round-off."""

UNPRESSED = 1e-6
"""A pressure below this fraction of the traction that would undo the jump is none: the point is open.

Not so if it coheres and its gap is below the same fraction of the jump: the faces touch.
"""

TOUCHING = 1e-8
"""Of the jump without contact: faces that cohere and are less apart touch."""

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

MOST_TURNS = 60
"""Solves after which points whose slip still turns round are given up."""


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
    contact tractions, if they are known. Raises SolveError where the contact solver finds no solution.
    """
    return solve_increment(contact, loads, given, memory or ContactMemory.fresh(len(contact.weights)), None, without)


def solve_increment(
    contact: ContactSystem,
    loads: Floats,
    given: Floats,
    memory: ContactMemory,
    last: ContactOutcome | None,
    without: tuple[Floats, Floats] | None = None,
) -> ContactOutcome:
    """One increment; `last` is the outcome under nearly the same loads, if there is one."""
    u_free, multipliers = contact.system.solve(loads, given) if without is None else without
    size = displacement_size(loads, u_free if last is None else last.u, given)
    free = Rock(u_free, multipliers, contact.gap_of @ u_free, contact.slip_of @ u_free)
    trial = _Increment(contact, loads, given, free, memory, size, last)
    dilation = contact.law.dilation
    if dilation is None or not dilation.any():
        return trial.outcome(np.zeros(len(contact.weights)))
    sense = np.sign(memory.slip if last is None else last.memory.slip)
    for _ in range(MOST_TURNS):
        outcome = trial.outcome(dilation * sense)
        slip = np.where(outcome.state == STICK, memory.slip, outcome.memory.slip)  # but for round-off
        turned = (sense * slip < 0.0) | ((sense == 0.0) & (slip != 0.0))
        turned &= dilation * np.abs(slip) > OVERLAP * size
        if not turned.any():
            return outcome
        sense[turned] = np.sign(slip[turned])
    raise SolveError(
        f"the opening by dilation did not settle: {turned.sum()} points slip to and fro; use a smaller dilation angle"
    )


class _Increment:
    """An increment: contact points are taken in and break until the law holds; they stay so for further solves.

    Every solve starts from the tractions of the one before.
    """

    def __init__(
        self,
        contact: ContactSystem,
        loads: Floats,
        given: Floats,
        free: Rock,
        memory: ContactMemory,
        size: float,
        last: ContactOutcome | None,
    ) -> None:
        self._contact, self._memory, self._size, self._tolerance = contact, memory, size, OVERLAP * size
        self._loads, self._given, self._free = loads, given, free
        self._taken = memory.coheres(contact.law)
        self._broken = memory.broken.copy()
        self._opened = np.zeros(len(contact.weights), dtype=bool)  # in this increment: they do not cohere in it
        self._last = None if last is None else (last.normal_traction, last.tangential_traction)

    def outcome(self, rise: Floats) -> ContactOutcome:
        """The solution where slip s opens the faces by `rise` (n,) times s: the tangent of the dilation, signed."""
        contact, law, memory = self._contact, self._contact.law, self._memory
        n, taken, breakable = len(contact.weights), self._taken, law.breakable
        p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
        notes: set[str] = set()
        iterations, complementarity, off, last_off = 0, 0.0, 0.0, np.inf
        u, multipliers, slip = self._free.u, self._free.multipliers, self._free.slip
        gap = self._free.gap - rise * slip
        problem: ContactProblem | None = None
        taken |= gap < -self._tolerance
        while taken.any():
            friction, cohesion = law.bound_of(self._broken)
            cohesion[self._opened] = 0.0
            frictional = (friction > 0.0) | (cohesion > 0.0)
            rows = np.flatnonzero(taken)
            sliding = rows if frictional[rows].any() else rows[:0]
            rock = contact.onto(rows, sliding)
            free_gap, free_slip = self._free.gap - rise * self._free.slip, self._free.slip - memory.slip
            free = np.concatenate([free_gap[rows], free_slip[sliding]])
            problem = condensed(contact, rock.compliance, free, friction, cohesion, rows, sliding, rise)
            start = None if self._last is None else np.concatenate([self._last[0][rows], self._last[1][sliding]])
            weights = None if rise.any() else contact.weights[rows]
            solution, note = solved(problem, weights, contact.solver, start)
            notes.update([note] if note else [])
            iterations += solution.iterations
            complementarity = complementarity_residual(problem, solution.traction)
            p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
            p_n[rows] = solution.traction[: len(rows)]
            p_t[sliding] = solution.traction[len(rows) :]
            self._last = p_n, p_t
            gap, slip = rock.jumps(self._free, solution.traction)
            gap = gap - rise * (slip - law.compliance * p_t)
            unpressed = p_n[rows] >= -UNPRESSED * np.max(np.abs(free) / problem.compliance.diagonal())
            # where springs hold pieces, the jump without contact says nothing
            noise = self._tolerance if contact.loose else TOUCHING * float(np.abs(free).max())
            jump = max(float(np.abs(gap[rows]).max()), float(np.abs(slip[rows]).max()))
            apart = gap[rows] > max(UNPRESSED * jump, noise)
            touching = (cohesion[rows] > 0.0) & ~apart
            held = np.where(np.abs(p_t[rows]) < (1.0 - AT_LIMIT) * cohesion[rows], STICK, SLIP)
            state[rows] = np.where(unpressed, np.where(touching, held, OPEN), solution.state)
            missed = ~taken & (gap < -self._tolerance)
            breaking = taken & (state != STICK) & ~self._broken & breakable
            opening = taken & (state == OPEN) & (cohesion > 0.0) & ~self._opened
            if missed.any():
                taken |= missed
            elif breaking.any():
                self._broken |= breaking
            elif opening.any():
                self._opened |= opening
            else:
                u, multipliers = rock.displacements(self._free, self._loads, self._given, solution.traction)
                more_gap, more_slip, off = self._missing(rock, u, solution.traction)
                if off <= ROUND_OFF or off > GAIN * last_off:
                    break
                self._free = replace(self._free, gap=self._free.gap + more_gap, slip=self._free.slip + more_slip)
                last_off = off
                continue
            last_off = np.inf
        if off > UNSURE:
            notes.add(f"jumps of the faces are off by {off:.1g} of the largest: the system is ill conditioned")
        dilation = rise * (slip - law.compliance * p_t)
        apart = (state == OPEN) & (gap > self._tolerance)
        return ContactOutcome(
            u=u,
            multipliers=multipliers,
            normal_traction=p_n,
            tangential_traction=p_t,
            gap=gap + dilation,
            slip=slip,
            state=state,
            memory=ContactMemory(slip - law.compliance * p_t, self._broken | (state == SLIP) | apart, ~apart),
            dilation=dilation,
            n_unknowns=int(taken.sum()) * (2 if taken.any() and len(sliding) else 1),
            iterations=iterations,
            penetration=float(np.max(-(gap - law.compliance * p_n), initial=0.0)),
            complementarity=max(complementarity, off),
            status="solved" if taken.any() else "none",
            notes=tuple(sorted(notes)),
            rows=np.flatnonzero(taken),
            problem=problem,
        )

    def _missing(self, rock: Condensation, u: Floats, t: Floats) -> tuple[Floats, Floats, float]:
        """Gap and slip (n,) m of the displacements `u` (n_dofs,) less those by the compliance, under tractions `t`.

        The compliance is good to the round-off of one elimination, the displacements are refined. The third is the
        largest difference, relative to the jumps. Raises SolveError where the compliance is wrong altogether.
        """
        contact, free = self._contact, self._free
        gap, slip = rock.jumps(free, t)
        more_gap, more_slip = contact.gap_of @ u - gap, contact.slip_of @ u - slip
        off, size, farthest = (
            max(float(np.abs(jumps).max()) for jumps in some)
            for some in ((more_gap, more_slip), (gap, slip), (gap, slip, free.gap, free.slip))
        )
        if not off <= SPOILT * farthest:
            raise spoilt(f"wrong by {off / farthest:.1g} of the jumps")
        # where springs hold pieces, the jump without contact says nothing
        size = max(size, self._size) if contact.loose else farthest
        return more_gap, more_slip, off / size if size > 0.0 else 0.0
