"""The contact problem of one step, condensed onto the contact points that can be closed.

u = u_free - K0^-1 G' W p, so that gap and slip of the contact points are free - S W p with S = G K0^-1 G'
(traction form of paper eqs. (15), (16): no penalty enters K, and k = infinity is allowed). Points that are open
without contact tractions are left out; those that then overlap are taken in, until none does. A point that opens
loses its cohesion, so that open faces carry no shear.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.coulomb import OPEN, ContactProblem, ContactSolution, complementarity_residual
from crackgrow.contact.lemke import solve_by_lemke
from crackgrow.contact.newton import solve_by_newton
from crackgrow.errors import FreePieceError, SolveError
from crackgrow.solid.linear_solver import ConstrainedSystem, displacement_size
from crackgrow.solid.rigid_modes import FreePiece, Springs

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

OVERLAP = 1e-10
"""A gap above minus this fraction of the displacement's size is no overlap but round-off."""

UNPRESSED = 1e-6
"""A pressure below this fraction of the traction that would undo the jump is none: the point is open."""


MOST_PULLS = 60
"""Solves after which springs that still carry force are given up."""

LAST_PULLS = 8
"""The springs' force has to halve within so many solves."""

NEARLY_SLACK = 1e-5
"""The same where round-off lets the springs' force fall no further: the solution carries a note."""

NO_CHANGE = 1e-9
"""A change of the springs' drift by less than this fraction is round-off."""

SLACK = 1e-10
"""Springs with a force below this part of the loads are slack."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw:
    """Law of every contact point."""

    friction: Floats  # (n,)
    cohesion: Floats  # (n,) Pa
    compliance: Floats  # (n,) m/Pa: 1/k, zero for rigid contact


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
    n_unknowns: int
    iterations: int
    penetration: float  # m: overlap beyond |p| / k
    complementarity: float  # relative
    status: Literal["none", "solved"]
    notes: tuple[str, ...]  # what the user should know of how it was solved


@dataclass(frozen=True, slots=True, eq=False)
class ContactSystem:
    """All that the contact points need of the rock."""

    system: ConstrainedSystem
    gap_of: csr_array  # (n, n_dofs)
    slip_of: csr_array  # (n, n_dofs)
    weights: Floats  # (n,) m, length of every contact point
    law: ContactLaw
    solver: Literal["newton", "lemke"]
    loose: bool = False  # whether `system` holds pieces by springs, in whose compliance that of the rock is lost


def solve_contact(contact: ContactSystem, loads: Floats, given: Floats) -> ContactOutcome:
    """Displacements and contact tractions under `loads` (n_dofs,), with support displacements `given` (m,).

    Raises SolveError where the contact solver finds no solution.
    """
    return _solve(contact, _Columns(contact), loads, given, None)


def solve_contact_held_loosely(
    contact: ContactSystem, springs: Springs, pieces: tuple[FreePiece, ...], loads: Floats, given: Floats
) -> ContactOutcome:
    """As `solve_contact` where the system's stiffness contains `springs` on pieces that contact alone holds.

    The springs' far ends follow the rock until they carry no force (the proximal point method, Rockafellar 1976): the
    solution is that of the rock without springs. Raises FreePieceError where contact does not hold a piece.
    """
    columns = _Columns(contact)
    outcome: ContactOutcome | None = None
    ends, drifts = [np.zeros(len(springs.dofs))], []
    forces: list[float] = []
    slack = False
    for _ in range(MOST_PULLS):
        pulled = loads.copy()
        np.add.at(pulled, springs.dofs, springs.stiffness * ends[-1])
        outcome = _solve(contact, columns, pulled, given, outcome)
        if slack:  # this was once more: the error left has fallen again
            return outcome
        drifts.append(outcome.u[springs.dofs] - ends[-1])
        ends.append(accelerated(ends, drifts))
        pressed = contact.weights @ np.abs(outcome.normal_traction)
        forces.append(float(np.abs(springs.stiffness * drifts[-1]).max()))
        if forces[-1] <= SLACK * max(float(np.abs(loads).sum()), float(pressed)):
            slack = True
        elif len(forces) > LAST_PULLS and forces[-1] > 0.5 * forces[-1 - LAST_PULLS]:
            break
    assert outcome is not None
    left = forces[-1] / max(float(np.abs(loads).sum()), float(pressed))
    if left <= NEARLY_SLACK:
        note = f"pieces held by contact are out of balance by {left:.1g} of the loads: very unlike stiffnesses"
        return replace(outcome, notes=(*outcome.notes, note))
    drift = drifts[-1]
    piece = pieces[int(springs.piece[int(np.argmax(np.abs(drift)))])]
    what = f"{piece} is free to move: contact does not hold it"
    raise FreePieceError(what, "it needs supports, friction or another load")


def accelerated(ends: list[Floats], drifts: list[Floats]) -> Floats:
    """The next ends (k,) of springs after `ends` (k,) that gave `drifts` (k,), by Anderson's method (1965).

    Where the drift is linear in the ends, as it is once the contact states are found, k steps suffice, however loose
    or stiff the springs. Steps that changed the drift by round-off alone say nothing and are left out.
    """
    steps = np.diff(np.array(ends), axis=0)[-len(ends[0]) :]
    changes = np.diff(np.array(drifts), axis=0)[-len(ends[0]) :]
    telling = np.abs(changes).max(axis=1, initial=0.0) > NO_CHANGE * np.abs(drifts[-1]).max()
    plain = ends[-1] + drifts[-1]
    if not telling.any():
        return plain
    share = np.linalg.lstsq(changes[telling].T, drifts[-1], rcond=NO_CHANGE)[0]
    return np.asarray(plain - share @ (steps + changes)[telling])


def _solve(
    contact: ContactSystem, columns: _Columns, loads: Floats, given: Floats, last: ContactOutcome | None
) -> ContactOutcome:
    """One solve; `last` is the outcome under nearly the same loads, if there is one."""
    gap_of, slip_of, law = contact.gap_of, contact.slip_of, contact.law
    u_free, multipliers = contact.system.solve(loads, given)
    free_gap, free_slip = gap_of @ u_free, slip_of @ u_free
    n = len(contact.weights)
    tolerance = OVERLAP * displacement_size(loads, u_free if last is None else last.u, given)
    taken = free_gap < -tolerance
    frictional = (law.friction > 0.0) | (law.cohesion > 0.0)
    p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
    cohesion = law.cohesion.copy()
    notes: set[str] = set()
    iterations, complementarity = 0, 0.0
    u, gap = u_free, free_gap
    while taken.any():
        rows = np.flatnonzero(taken)
        sliding = rows if frictional[rows].any() else rows[:0]
        response = np.concatenate([columns.of_gap(rows), columns.of_slip(sliding)], axis=1)
        free = np.concatenate([free_gap[rows], free_slip[sliding]])
        problem = _condensed(contact, response, free, cohesion, rows, sliding)
        solution, note = _solved(problem, contact.solver)
        notes.update([note] if note else [])
        iterations += solution.iterations
        complementarity = complementarity_residual(problem, solution.traction)
        p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
        p_n[rows] = solution.traction[: len(rows)]
        unpressed = p_n[rows] > -UNPRESSED * np.max(np.abs(free) / problem.compliance.diagonal())
        state[rows] = np.where(unpressed, OPEN, solution.state)
        p_t[sliding] = solution.traction[len(rows) :]
        u = u_free - response @ solution.traction
        gap = gap_of @ u
        missed = ~taken & (gap < -tolerance)
        broken = taken & (state == OPEN) & (cohesion > 0.0)
        if missed.any():
            taken |= missed
        elif broken.any():
            cohesion[broken] = 0.0
        else:
            multipliers = multipliers - columns.multipliers(rows, sliding) @ solution.traction
            break
    return ContactOutcome(
        u=u,
        multipliers=multipliers,
        normal_traction=p_n,
        tangential_traction=p_t,
        gap=gap,
        slip=slip_of @ u,
        state=state,
        n_unknowns=int(taken.sum()) * (2 if frictional[taken].any() else 1),
        iterations=iterations,
        penetration=float(np.max(-(gap - law.compliance * p_n), initial=0.0)),
        complementarity=complementarity,
        status="solved" if taken.any() else "none",
        notes=tuple(sorted(notes)),
    )


def _condensed(
    contact: ContactSystem, response: Floats, free: Floats, cohesion: Floats, rows: Ints, sliding: Ints
) -> ContactProblem:
    """The problem of the contact points `rows` (k,), with tangential rows of the points `sliding` (k,) or (0,)."""
    law = contact.law
    compliance = np.concatenate([contact.gap_of[rows] @ response, contact.slip_of[sliding] @ response])
    compliance[np.diag_indices_from(compliance)] += np.concatenate([law.compliance[rows], law.compliance[sliding]])
    scale = None
    if contact.loose:  # the few rigid motions are the largest eigenvalues
        values = np.linalg.eigvalsh(0.5 * (compliance + compliance.T))
        scale = np.full(len(free), np.median(np.abs(values)))
    if not len(sliding):
        return ContactProblem(compliance, free, scale=scale)
    return ContactProblem(compliance, free, law.friction[rows], cohesion[rows], scale)


class _Columns:
    """Displacements per unit traction of contact points, K0^-1 G' W, each solved for once and only when needed."""

    def __init__(self, contact: ContactSystem) -> None:
        self._system, self._weights = contact.system, contact.weights
        self._operators = (contact.gap_of, contact.slip_of)
        self._known: tuple[dict[int, tuple[Floats, Floats]], ...] = ({}, {})

    def of_gap(self, rows: Ints) -> Floats:
        """(n_dofs, k) for normal tractions at contact points `rows` (k,)."""
        return self._of(0, rows)

    def of_slip(self, rows: Ints) -> Floats:
        """(n_dofs, k) for tangential tractions at contact points `rows` (k,)."""
        return self._of(1, rows)

    def multipliers(self, rows: Ints, sliding: Ints) -> Floats:
        """(m, k + l) support multipliers per unit traction."""
        parts = [self._known[0][row][1] for row in rows.tolist()] + [self._known[1][row][1] for row in sliding.tolist()]
        return np.stack(parts, axis=1)

    def _of(self, kind: int, rows: Ints) -> Floats:
        known, operator = self._known[kind], self._operators[kind]
        new = [row for row in rows.tolist() if row not in known]
        if new:
            u, multipliers = self._system.solve((operator[new].T * self._weights[new]).toarray())
            known.update({row: (u[:, i], multipliers[:, i]) for i, row in enumerate(new)})
        n_dofs = operator.shape[1]
        return np.stack([known[row][0] for row in rows.tolist()], axis=1) if len(rows) else np.empty((n_dofs, 0))


def _solved(problem: ContactProblem, solver: Literal["newton", "lemke"]) -> tuple[ContactSolution, str]:
    """Solution of a contact problem by `solver`, or by the other one, and then a note that says why."""
    failures = []
    for name in (solver, "lemke" if solver == "newton" else "newton"):
        try:
            solution = solve_by_newton(problem) if name == "newton" else solve_by_lemke(problem)
        except SolveError as error:
            failures.append(f"{name}: {error}")
            continue
        if solution.status == "solved":
            note = f"the contact problem was solved by {name} after {failures[0]}" if failures else ""
            return solution, note
        residual = complementarity_residual(problem, solution.traction)
        failures.append(
            f"{name}: status '{solution.status}' after {solution.iterations} iterations, residual {residual:.2g}"
        )
    raise SolveError(
        f"the contact problem of {problem.n_points} points was not solved: {'; '.join(failures)}; "
        "try a coarser contact spacing or a softer contact stiffness"
    )
