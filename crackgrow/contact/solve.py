"""The contact problem of one step, condensed onto the contact points that can be closed.

u = u_free - K0^-1 G' W p, so that gap and slip of the contact points are free - S W p with S = G K0^-1 G'
(traction form of paper eqs. (15), (16): no penalty enters K, and k = infinity is allowed). Points that are open
without contact tractions are left out; those that then overlap are taken in, until none does.

Loads come in increments, and points remember (`ContactMemory`): a point sticks where it stuck before,

    du_t = du_t' where |p_t| < b, else du_t - du_t' has the sign of p_t,    gap >= tan(dilation) |du_t|,

with du_t' the slip after the increment before. A point that slips or opens is broken: its friction is the residual one
from then on, and its cohesion lost unless it is kept. What breaks in an increment is broken in all of it: the increment
is solved again until no more points break. With dilation, the gap less tan(dilation) |du_t| takes the gap's place. It
is linear in the unknowns once the sense of the slip is known: the increment is solved again until no point slips the
other way than it was taken to.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ContactProblem, ContactSolution, complementarity_residual
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

MOST_TURNS = 60
"""Solves after which points whose slip still turns round are given up."""

SLACK = 1e-10
"""Springs with a force below this part of the loads are slack."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactLaw:
    """Law of every contact point."""

    friction: Floats  # (n,)
    cohesion: Floats  # (n,) Pa
    compliance: Floats  # (n,) m/Pa: 1/k, zero for rigid contact
    residual_friction: Floats | None = None  # (n,) of broken points; None: as before
    kept: Bools | None = None  # (n,) whether broken points that are closed cohere; None: they don't
    dilation: Floats | None = None  # (n,) tan(dilation angle); None: zero

    def bound_of(self, broken: Bools) -> tuple[Floats, Floats]:
        """Friction (n,) and cohesion (n,) where some points are `broken` (n,)."""
        friction = self.friction if self.residual_friction is None else self.residual_friction
        cohesion = np.zeros(len(broken)) if self.kept is None else np.where(self.kept, self.cohesion, 0.0)
        return np.where(broken, friction, self.friction), np.where(broken, cohesion, self.cohesion)

    @property
    def breakable(self) -> Bools:
        """Which points (n,) have something to lose."""
        n = len(self.friction)
        friction, cohesion = self.bound_of(np.ones(n, dtype=bool))
        return np.asarray((friction < self.friction) | (cohesion < self.cohesion))


@dataclass(frozen=True, slots=True, eq=False)
class ContactMemory:
    """What contact points keep from one increment to the next."""

    slip: Floats  # (n,) m, less its elastic part
    broken: Bools  # (n,) has slipped or opened

    @classmethod
    def fresh(cls, n: int) -> ContactMemory:
        """Memory of n points that nothing has happened to."""
        return cls(np.zeros(n), np.zeros(n, dtype=bool))


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
    columns: _Columns = field(init=False, repr=False)  # displacements per unit traction, found when needed

    def __post_init__(self) -> None:
        object.__setattr__(self, "columns", _Columns(self.system, self.gap_of, self.slip_of, self.weights))


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
    return _solve(contact, loads, given, memory or ContactMemory.fresh(len(contact.weights)), None, without)


def solve_contact_held_loosely(
    contact: ContactSystem,
    springs: Springs,
    pieces: tuple[FreePiece, ...],
    loads: Floats,
    given: Floats,
    memory: ContactMemory | None = None,
) -> ContactOutcome:
    """As `solve_contact` where the system's stiffness contains `springs` on pieces that contact alone holds.

    The springs' far ends follow the rock until they carry no force (the proximal point method, Rockafellar 1976): the
    solution is that of the rock without springs. Raises FreePieceError where contact does not hold a piece.
    """
    memory = memory or ContactMemory.fresh(len(contact.weights))
    outcome: ContactOutcome | None = None
    ends, drifts = [np.zeros(len(springs.dofs))], []
    forces: list[float] = []
    slack = False
    for _ in range(MOST_PULLS):
        pulled = loads.copy()
        np.add.at(pulled, springs.dofs, springs.stiffness * ends[-1])
        outcome = _solve(contact, pulled, given, memory, outcome)
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
    trial = _Increment(contact, u_free, multipliers, memory, OVERLAP * size)
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
    """An increment: contact points are taken in and break until the law holds; they stay so for further solves."""

    def __init__(
        self, contact: ContactSystem, u_free: Floats, multipliers: Floats, memory: ContactMemory, tolerance: float
    ) -> None:
        self._contact, self._memory, self._tolerance = contact, memory, tolerance
        self._u_free, self._multipliers = u_free, multipliers
        self._gap, self._slip = contact.gap_of @ u_free, contact.slip_of @ u_free
        self._taken = np.zeros(len(contact.weights), dtype=bool)
        self._broken = memory.broken.copy()
        self._opened = np.zeros(len(contact.weights), dtype=bool)  # in this increment: they do not cohere in it

    def outcome(self, rise: Floats) -> ContactOutcome:
        """The solution where slip s opens the faces by `rise` (n,) times s: the tangent of the dilation, signed."""
        contact, law, memory = self._contact, self._contact.law, self._memory
        n, taken, breakable = len(contact.weights), self._taken, law.breakable
        free_gap, free_slip = self._gap - rise * self._slip, self._slip - memory.slip
        p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
        notes: set[str] = set()
        iterations, complementarity = 0, 0.0
        u, multipliers = self._u_free, self._multipliers
        gap = free_gap
        taken |= gap < -self._tolerance
        while taken.any():
            friction, cohesion = law.bound_of(self._broken)
            cohesion[self._opened] = 0.0
            frictional = (friction > 0.0) | (cohesion > 0.0)
            rows = np.flatnonzero(taken)
            sliding = rows if frictional[rows].any() else rows[:0]
            response = contact.columns.of(rows, sliding)
            free = np.concatenate([free_gap[rows], free_slip[sliding]])
            problem = _condensed(contact, response, free, friction, cohesion, rows, sliding, rise)
            solution, note = _solved(problem, contact.solver)
            notes.update([note] if note else [])
            iterations += solution.iterations
            complementarity = complementarity_residual(problem, solution.traction)
            p_n, p_t, state = np.zeros(n), np.zeros(n), np.full(n, OPEN)
            p_n[rows] = solution.traction[: len(rows)]
            unpressed = p_n[rows] > -UNPRESSED * np.max(np.abs(free) / problem.compliance.diagonal())
            state[rows] = np.where(unpressed, OPEN, solution.state)
            p_t[sliding] = solution.traction[len(rows) :]
            u = self._u_free - response @ solution.traction
            gap = contact.gap_of @ u - rise * (contact.slip_of @ u - law.compliance * p_t)
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
                multipliers = multipliers - contact.columns.multipliers(rows, sliding) @ solution.traction
                break
        slip = contact.slip_of @ u
        dilation = rise * (slip - law.compliance * p_t)
        return ContactOutcome(
            u=u,
            multipliers=multipliers,
            normal_traction=p_n,
            tangential_traction=p_t,
            gap=gap + dilation,
            slip=slip,
            state=state,
            memory=ContactMemory(slip - law.compliance * p_t, self._broken | (state == SLIP) | (gap > self._tolerance)),
            dilation=dilation,
            n_unknowns=int(taken.sum()) * (2 if taken.any() and len(sliding) else 1),
            iterations=iterations,
            penetration=float(np.max(-(gap - law.compliance * p_n), initial=0.0)),
            complementarity=complementarity,
            status="solved" if taken.any() else "none",
            notes=tuple(sorted(notes)),
        )


def _condensed(
    contact: ContactSystem,
    response: Floats,
    free: Floats,
    friction: Floats,
    cohesion: Floats,
    rows: Ints,
    sliding: Ints,
    rise: Floats,
) -> ContactProblem:
    """The problem of the contact points `rows` (k,), with tangential rows of the points `sliding` (k,) or (0,).

    With dilation the gap's rows are those of the gap less `rise` (n,) times the slip. Raises SolveError where that
    leaves a point without resistance.
    """
    law = contact.law
    compliance = np.concatenate([contact.gap_of[rows] @ response, contact.slip_of[sliding] @ response])
    compliance[np.diag_indices_from(compliance)] += np.concatenate([law.compliance[rows], law.compliance[sliding]])
    n = len(rows)
    if rise[rows].any():  # where there is dilation there is friction: the points that slide are `rows`
        compliance[:n] -= rise[rows, None] * compliance[n:]
        n_steep = int(np.sum(compliance.diagonal()[:n] <= 0.0))
        if n_steep:
            raise SolveError(
                f"pressing {n_steep} contact points makes them slip and open by dilation more than it closes them: "
                "use a smaller dilation angle, or supports that hold the rock without contact"
            )
    scale = None
    if contact.loose:  # the few rigid motions are the largest eigenvalues
        values = np.linalg.eigvalsh(0.5 * (compliance + compliance.T))
        scale = np.full(len(free), np.median(np.abs(values)))
    if not len(sliding):
        return ContactProblem(compliance, free, scale=scale)
    return ContactProblem(compliance, free, friction[rows], cohesion[rows], scale)


class _Columns:
    """Displacements per unit traction of contact points, K0^-1 G' W, each solved for once and only when needed."""

    def __init__(self, system: ConstrainedSystem, gap_of: csr_array, slip_of: csr_array, weights: Floats) -> None:
        self._system, self._weights = system, weights
        self._operators = (gap_of, slip_of)
        self._known: tuple[dict[int, tuple[Floats, Floats]], ...] = ({}, {})  # of gap, of slip

    def of(self, rows: Ints, sliding: Ints) -> Floats:
        """(n_dofs, k + l) for normal tractions at points `rows` (k,) and tangential ones at `sliding` (l,)."""
        self._find(rows, sliding)
        columns = [u for u, _ in self._parts(rows, sliding)]
        return np.stack(columns, axis=1) if columns else np.empty((self._operators[0].shape[1], 0))

    def multipliers(self, rows: Ints, sliding: Ints) -> Floats:
        """(m, k + l) support multipliers per unit traction; of columns that are known."""
        return np.stack([multipliers for _, multipliers in self._parts(rows, sliding)], axis=1)

    def _parts(self, rows: Ints, sliding: Ints) -> list[tuple[Floats, Floats]]:
        pairs = zip(self._known, (rows, sliding), strict=True)
        return [known[row] for known, wanted in pairs for row in wanted.tolist()]

    def _find(self, rows: Ints, sliding: Ints) -> None:
        """Solve for all columns that are not known yet, at once."""
        pairs = zip(self._known, (rows, sliding), strict=True)
        new = [[row for row in wanted.tolist() if row not in known] for known, wanted in pairs]
        if not any(new):
            return
        forces = [(op[some].T * self._weights[some]).toarray() for op, some in zip(self._operators, new, strict=True)]
        u, multipliers = self._system.solve(np.concatenate(forces, axis=1))
        found = zip(u.T, multipliers.T, strict=True)
        for known, some in zip(self._known, new, strict=True):
            known.update({row: next(found) for row in some})


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
