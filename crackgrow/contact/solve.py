"""The contact of one increment of the loads, solved on the condensed model; displacements are formed at its end.

Unknown are the tractions of points that can be closed: those that cohere when the increment begins, since shear can
open faces that only the bond keeps from slipping, those that contact holds pieces by, and those that overlap without
tractions. Others that then overlap are taken in, until none does. Points that cohere and are neither pressed nor apart
are closed: |p_t| <= c - mu p_n holds at p_n = 0 too.

Points remember (`ContactMemory`): a point sticks where it stuck before,

    du_t = du_t' where |p_t| < b, else du_t - du_t' has the sign of p_t,    gap >= tan(dilation) |du_t|,

with du_t' the slip after the increment before. What breaks in an increment is broken in all of it, what slip
wears is worn as at its end: the increment is solved again until no more points break or wear, and closure and friction
of rough faces are those at the pressure that there is.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, ActiveSet, ContactMemory, active_set, complementarity_residual
from crackgrow.contact.equations import ActiveEquations, solve_active
from crackgrow.contact.lemke import solve_by_lemke
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.points import absolute_product
from crackgrow.contact.problem import ContactProblem, ContactSolution
from crackgrow.contact.sparse_points import SparsePoints
from crackgrow.contact.stuck import MANY, solve_among_stuck
from crackgrow.contact.system import ContactSystem, ill_conditioned
from crackgrow.errors import NotSolvedError
from crackgrow.geometry.tolerance import ROUND_OFF

OVERLAP = 1e-10
"""A gap above minus this fraction of the displacement's size is no overlap but round-off."""

UNPRESSED = 1e-6
"""A pressure below this fraction of the traction that would undo the jumps at its place is none: the point is open.

Not so if it coheres and its gap is below the same fraction of these jumps: the faces touch.
"""

AT_LIMIT = 1e-9
"""Shear closer to the cohesion of faces that touch than this fraction of it has reached it: they slip."""

ILL_CONDITIONED = 1e-2
"""If they differ by more, nothing can be made of the compliance."""

FAINT = 1e-10
"""Jumps below this fraction of the displacements that they are differences of are measured by it.

So it is where a pressure on faces just balances the stress: all jumps are round-off there, 1e-13 of displacements and
less. A block on rock that is a hundred million times softer has jumps of 1e-8 of them, which are known.
"""

GAIN = 0.5
"""Corrections that leave more than this part of the difference end: it is round-off of the displacements themselves."""

WORN = 1e-7
"""Less than this share of what slip can take is nothing: what slip has taken is found by repetition."""

CONSISTENT = 1e-9
"""Friction, or the softness of closure over that without pressure, may be off by so much from those at the pressure."""

MOST_WEARS = 1000
"""Repetitions. Where a fall of strength is just what the rock can follow each of them changes next to nothing."""

SETTLED = 1e-10
"""The same on a path: of each of its pieces only this much is left out of the balance of energies."""

UNSURE = 1e-8
"""The same, left at the end, of which the outcome carries a note."""

TOUCH_AGAIN = (
    "{} contact points open and touch again by dilation under one load: cohesion that is kept holds them from the next "
    "load on only, so that results depend on how many loads lead there; cohesion_after_slip: lost is the same for all"
)


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """What an increment is taken to do."""

    taken: Bools  # (n,) points that are among the unknowns
    lost: Floats  # (n,) share of what points can lose that is gone, in this increment or before
    opened: Bools  # (n,) points that have opened in this increment: they do not cohere in it
    pressed: Floats  # (n,) Pa: normal tractions that closure and friction of rough faces are taken at
    wears: int = 0  # how often slip has taken some of what can be lost, or these have been taken anew

    @property
    def places(self) -> Ints:
        """Normal, then tangential tractions (2 k,) of the points that are taken, among those of all points."""
        return np.flatnonzero(np.tile(self.taken, 2))


class TrialNotSolvedError(NotSolvedError):
    """An increment whose contact was not solved in a trial: what broke up to there has broken."""

    def __init__(self, trial: Trial, why: NotSolvedError) -> None:
        self.trial = trial
        super().__init__(str(why))


@dataclass(frozen=True, slots=True, eq=False)
class PointStates:
    """What comes of a trial, at all points."""

    trial: Trial
    normal: Floats  # (n,) Pa, negative in compression
    tangential: Floats  # (n,) Pa
    gap: Floats  # (n,) m, less what dilation opens
    slip: Floats  # (n,) m
    dilation: Floats  # (n,) m: what slip has opened
    state: Ints  # (n,)
    coheres: Bools  # (n,)
    touching: Floats  # (n,) m: gaps up to which faces that cohere touch
    solution: ContactSolution | None = None  # None: no point has to be dealt with
    active: ActiveSet | None = None  # the branches of the law that taken points are on
    problem: ContactProblem | None = None  # that it is of, while it is kept: it is large
    n_unknowns: int = 0
    iterations: int = 0  # of all trials
    rock: tuple[Floats, Floats] | None = None  # displacements and multipliers, where tractions are found with them

    @property
    def complementarity(self) -> float:
        """The residual of the law, relative; zero where no problem is kept."""
        if self.problem is None or self.solution is None:
            return 0.0
        return complementarity_residual(self.problem, self.solution.unknowns, self.solution.jump)

    @property
    def status(self) -> Literal["none", "solved"]:
        """Whether any point had to be dealt with."""
        return "none" if self.solution is None else "solved"

    @property
    def rows(self) -> Ints:
        """Points (k,) that the solver had to deal with: all others stay open."""
        return np.flatnonzero(self.trial.taken)

    @property
    def opening(self) -> Floats:
        """Gaps (n,) m."""
        return self.gap + self.dilation

    @property
    def tractions(self) -> Floats:
        """(2 n,) Pa, all normals, then all tangentials."""
        return np.concatenate([self.normal, self.tangential])

    def light(self, keep: bool = False) -> PointStates:
        """The states without the equations they were found by, which are large; the problem goes if not to `keep`."""
        solution = self.solution and replace(self.solution, equations=None)
        return replace(self, solution=solution, problem=self.problem if keep else None)


@dataclass(frozen=True, slots=True, eq=False)
class ContactOutcome:
    """Displacements with the states of the contact points that are in equilibrium with them."""

    u: Floats  # (n_dofs,) m
    multipliers: Floats  # (m,) of the supports
    points: PointStates
    memory: ContactMemory
    penetration: float  # m: overlap beyond |p| / k
    complementarity: float  # relative
    notes: tuple[str, ...]  # what the user should know of how it was solved
    residual: float = float("nan")  # of equilibrium, relative; nan where it was not looked at
    largest_terms: float = float("nan")  # N/m: the absolute terms of a force in the rock, where their sum is largest


@dataclass(frozen=True, slots=True, eq=False)
class Increment:
    """An increment of the loads: contact points are taken in and break until the law holds."""

    contact: ContactSystem
    memory: ContactMemory  # of the increment before
    free: Floats  # (2 n,) m: jumps without tractions
    pull: Floats  # (l,) N/m: what the loads do on the rigid motions
    tolerance: float  # m: less overlap is none
    moved: Floats  # (2 n,) m: jumps that foundations take away by moving
    loads: tuple[Floats, Floats]  # (n_dofs,) N/m, and what supports are given (m,) m

    def solved(self, start: PointStates | None = None) -> PointStates:
        """The states of all points. Raises TrialNotSolvedError where there are none.

        `start` is what was found for others that are close.
        """
        found = start if start is not None and start.trial.taken.any() else self._untouched()
        trial = found.trial if found.trial.taken.any() else None
        while trial is not None:
            try:
                found = self._tried(trial, found)
            except NotSolvedError as error:
                raise TrialNotSolvedError(trial, error) from error
            trial = self._revised(found)
        return found

    def begun(self, near: PointStates) -> PointStates:
        """States that are close as a start: what broke or opened in their own increment is not of this one."""
        taken = near.trial.taken | self.memory.coheres(self.contact.law)
        trial = Trial(taken, self.memory.lost, np.zeros(len(taken), dtype=bool), near.normal)
        return replace(near, trial=trial, iterations=0)

    def formed(
        self,
        state: PointStates,
        without: tuple[Floats, Floats],
        known: tuple[Floats, Floats] | None = None,
    ) -> ContactOutcome:
        """The outcome of states with their displacements, and both corrected until their jumps are the same.

        `without` are the displacements and multipliers without tractions, `known` those of the states, if they are.
        Raises NotSolvedError where the compliance is wrong altogether.
        """
        here, best, rock, off, last_off = self, state, without, 0.0, np.inf
        while state.solution is not None:
            there = (
                known
                or state.rock
                or self.contact.displacements(self.loads, without, state.tractions, state.solution.motion)
            )
            known = None
            more, now_off = here._missing(state, there[0])
            if not now_off <= ILL_CONDITIONED and last_off == np.inf:
                raise ill_conditioned(f"wrong by {now_off:.1g} of the jumps")
            if not now_off < last_off:
                break  # pieces that nothing presses lie somewhere else after each correction
            best, rock, off = state, there, now_off
            if off <= ROUND_OFF or off > GAIN * last_off:
                break
            here, last_off = replace(here, free=here.free + more), off
            state = here.solved(state)
        return self._outcome(best, rock, off)

    def memory_after(self, state: PointStates) -> ContactMemory:
        """What points keep of their states.

        Slip wears all of what it does: many increments that each take less than `WORN` take something together. Points
        that stick keep their slip to the bit: by round-off of it faces that dilate would part where loads are gone.
        """
        parted = state.gap - self.contact.law.compliance * np.maximum(state.normal, 0.0)  # a pulled joint is longer
        apart = (state.state == OPEN) & (parted > self.tolerance)
        slip = state.slip - self.contact.law.shear_compliance * state.tangential
        slip = np.where(state.state == STICK, self.memory.slip, slip)
        law = self.contact.law
        breaks = apart | ((state.state == SLIP) & ~law.weakens)
        lost = np.where(breaks, 1.0, np.minimum(self._worn(state), 1.0))
        rate, risen = self.memory.dilates(law, state.trial.lost)
        risen = risen + (rate - law.dilation_of(lost)) * np.abs(slip)
        return ContactMemory(slip, lost, ~apart, risen, state.normal, state.tangential, state.dilation)

    def _missing(self, state: PointStates, u: Floats) -> tuple[Floats, float]:
        """Jumps (2 n,) m of displacements u (n_dofs,) m less those by the compliance; the most, relative to the jumps.

        The compliance is good to the round-off of one elimination, the displacements are refined.
        """
        jumps = np.concatenate([state.opening, state.slip])
        more = self.contact.operator @ u - self.moved - jumps
        faint = FAINT * float((self.contact.operator_sizes @ np.abs(u)).max())
        off = float(np.abs(more).max())
        farthest = max(float(np.abs(np.concatenate([jumps, self.free])).max()), faint)
        return more, off / farthest if farthest > 0.0 else 0.0

    def _outcome(self, state: PointStates, rock: tuple[Floats, Floats], off: float) -> ContactOutcome:
        """The outcome with displacements and multipliers of the `rock`, whose jumps are `off`."""
        notes = []
        if off > UNSURE:
            notes.append(f"jumps of the faces are off by {off:.1g} of the largest: the system is ill conditioned")
        law = self.contact.law
        again = state.trial.opened & (state.state != OPEN) & (law.cohesion[-1] > 0.0)
        if again.any():
            notes.append(TOUCH_AGAIN.format(again.sum()))
        elastic = -law.closure(state.normal)
        return ContactOutcome(
            u=rock[0],
            multipliers=rock[1],
            points=state.light(keep=True),
            memory=self.memory_after(state),
            penetration=float(np.max(-(state.gap - elastic), initial=0.0)),
            complementarity=max(state.complementarity, off),
            notes=tuple(notes),
        )

    def _untouched(self) -> PointStates:
        """What the rock does without contact tractions, and the first trial."""
        law, (gap, slip) = self.contact.law, np.split(self.free, 2)
        rate, risen = self.memory.dilates(law, self.memory.lost)
        n, dilation = len(gap), rate * np.abs(slip) + risen
        sees = np.any(self.contact.moving != 0.0, axis=1).reshape(2, -1).any(axis=0)
        taken = self.memory.coheres(law) | (gap - dilation < -self.tolerance) | sees
        if taken.any():  # all that carry nothing while they are open
            taken |= law.bound_of(self.memory.lost)[1] == 0.0
        none, nothing = np.zeros(n, dtype=bool), np.zeros(n)
        trial = Trial(taken, self.memory.lost, none, nothing)
        return PointStates(trial, nothing, nothing, gap - dilation, slip, dilation, np.full(n, OPEN), none, nothing)

    def _tried(self, trial: Trial, start: PointStates) -> PointStates:
        """Tractions and jumps of a trial, looked for from those of another one on."""
        problem, known, near = self._problem(trial), None, None
        if start.solution is not None:
            near = start.solution.equations
            known = np.append((start.tractions - self._pulled(trial))[trial.places], start.solution.motion)
        solution = _solved_among_stuck(problem, known)
        if solution is None and isinstance(problem.points, SparsePoints):
            problem = self._condensed(trial)
            solution = _solved_among_stuck(problem, known)
        solution = solution or solve_contact_problem(problem, self.contact.solver, known, near)
        active = active_set(problem, solution.traction, problem.jump_of(solution))
        found = self._with(trial, problem, (solution, active))
        return replace(found, iterations=start.iterations + solution.iterations)

    def on_branch(self, like: PointStates) -> PointStates:
        """The states where every point is on the branch that it has in others, whether the law holds or not.

        Points lose by slip on these branches what the law says, and no more.
        """
        states = self._on_branch(like)
        for _ in range(MOST_WEARS):
            lost, settled_down = self._worn(states), not self._bent(states)
            if settled_down and np.abs(lost - states.trial.lost).max(initial=0.0) <= SETTLED:
                break
            trial = replace(states.trial, lost=lost, pressed=states.normal)
            states = self._on_branch(replace(states, trial=trial))
        return states

    def _on_branch(self, like: PointStates) -> PointStates:
        """The states on branches of others, with what points of these have lost."""
        if like.active is None or like.solution is None:
            return self._untouched()
        problem, near = self._problem(like.trial), like.solution.equations
        solution = _solved_among_stuck(problem, None, like.active)
        if solution is None:
            problem = self._condensed(like.trial) if isinstance(problem.points, SparsePoints) else problem
            x, m = solve_active(problem, like.active, near), problem.free.size
            solution = ContactSolution(x[:m], "solved", 0, like.active.states(), x[m:], near)
        found = self._with(like.trial, problem, (solution, like.active))
        return replace(found, iterations=like.iterations)

    def _problem(self, trial: Trial) -> ContactProblem:
        """The problem of a trial."""
        contact, law = self.contact, self.contact.law
        friction, cohesion = law.bound_of(trial.lost, trial.pressed)
        cohesion[trial.opened] = 0.0
        rate, _ = self.memory.dilates(law, trial.lost)
        rows, at, n = np.flatnonzero(trial.taken), trial.places, len(friction)
        resists = (friction > 0.0) | (cohesion > 0.0) | (rate > 0.0)
        counts = np.concatenate([np.ones(len(rows), dtype=bool), resists[rows]])
        jumps = np.where(counts, (self.free - self._beyond_law(trial))[at], 0.0)
        softer, pull, by_jumps = None, self.pull, None
        if np.isfinite(law.most).any():
            softness = law.compliance * law.softness(trial.pressed)
            softer = np.append(softness - law.compliance, np.zeros(n))[at]
        points = contact.condensed(rows, resists[rows], softer)
        pulled = self._pulled(trial)
        if pulled.any():  # unknown are tractions less the tensile strength
            cohesion = np.maximum(cohesion - friction * pulled[:n], 0.0)
            pull = pull - points.force @ pulled[at]
        if not isinstance(points, SparsePoints):
            jumps = jumps - points.compliance @ pulled[at] if pulled.any() else jumps
        else:
            by_jumps = partial(self._by_jumps, points, trial)
        law_of = (friction[rows], cohesion[rows], rate[rows], self.memory.slip[rows])
        return ContactProblem(points, jumps, *law_of, pull, by_jumps)

    def _by_jumps(self, points: SparsePoints, trial: Trial, motion: Floats, jumps: Floats) -> Floats:
        """Tractions (2 k,) Pa of a trial's problem, by amplitudes (l,) of motions and jumps (2 k,) m of its law."""
        return self._rock(points, trial, motion, jumps)[2] - self._pulled(trial)[trial.places]

    def _rock(self, points: SparsePoints, trial: Trial, motion: Floats, jumps: Floats) -> tuple[Floats, Floats, Floats]:
        """Displacements (n_dofs,) m, multipliers (m,) and tractions (2 k,) Pa by the same."""
        loose, beyond = self.contact.loose, self.moved + self._beyond_law(trial)
        loads = self.loads[0] + (0.0 if loose is None else loose.carrying(motion))
        return points.with_jumps(loads, self.loads[1], jumps + beyond[trial.places])

    def _condensed(self, trial: Trial) -> ContactProblem:
        """The problem of a trial on condensed rock. Raises NotSolvedError where its points are too many for that."""
        self.contact.condense()
        return self._problem(trial)

    def _beyond_law(self, trial: Trial) -> Floats:
        """What jumps (2 n,) m have beyond those of the law of a trial, and elastic contact."""
        law = self.contact.law
        _, risen = self.memory.dilates(law, trial.lost)
        beyond = np.concatenate([risen, self.memory.slip])
        if np.isfinite(law.most).any():
            softness = law.compliance * law.softness(trial.pressed)
            beyond[: len(risen)] -= law.closure(trial.pressed) + softness * trial.pressed
        return np.asarray(beyond)

    def _pulled(self, trial: Trial) -> Floats:
        """(2 n,) Pa: the tensile strength that taken points have in a trial, across the faces."""
        left = np.where(trial.taken & ~trial.opened, self.contact.law.tension_of(trial.lost), 0.0)
        return np.concatenate([left, np.zeros(len(left))])

    def _with(self, trial: Trial, problem: ContactProblem, found: tuple[ContactSolution, ActiveSet]) -> PointStates:
        """The states of all points with a solution of a trial's problem."""
        contact, law, (solution, active) = self.contact, self.contact.law, found
        rows, n = np.flatnonzero(trial.taken), len(trial.taken)
        p = self._pulled(trial)
        strong, rock = p[:n] > 0.0, None
        p[trial.places] += solution.traction
        p_n, p_t = np.split(p, 2)
        if isinstance(problem.points, SparsePoints):
            jumps, most = problem.jump_of(solution), np.abs(solution.traction).max(initial=0.0)
            rock = self._rock(problem.points, trial, solution.motion, jumps)[:2]
            gap, slip = np.split(contact.operator @ rock[0] - self.moved, 2)
            terms = np.abs(jumps) + problem.points.scale * most
        else:
            gap, slip = np.split(self.free - contact.rock @ p + contact.moving @ solution.motion, 2)
            lying, _ = problem.settled()  # how supports hold loose pieces to be solved for does not matter
            terms = absolute_product(lying.points.compliance, np.abs(solution.traction)) + np.abs(lying.free)
        rate, risen = self.memory.dilates(law, trial.lost)
        dilation = rate * np.abs(slip - law.shear_compliance * p_t) + risen
        state, coheres, touching = np.full(n, OPEN), np.zeros(n, dtype=bool), np.zeros(n)
        touching[rows] = UNPRESSED * terms.reshape(2, len(rows)).max(axis=0)  # gaps that are none beside these terms
        coheres[rows] = (problem.cohesion > 0.0) | strong[rows]
        apart = gap - dilation - law.compliance * np.maximum(p_n, 0.0)
        state[rows] = np.where(strong[rows], solution.state, _states(problem, solution, apart[rows], touching[rows]))
        return PointStates(
            trial, p_n, p_t, gap - dilation, slip, dilation, state, coheres, touching, solution, active, problem,
            problem.n_unknowns, rock=rock,
        )  # fmt: skip

    def _revised(self, found: PointStates) -> Trial | None:
        """The next trial: with points that overlap, that break, or that open; None if there are no more."""
        trial = found.trial
        missed = ~trial.taken & (found.gap < -self.tolerance)
        if missed.any():
            return replace(trial, taken=trial.taken | missed)
        law = self.contact.law
        if self._bent(found):
            if trial.wears >= MOST_WEARS:
                raise NotSolvedError("closure or friction of rough faces does not settle at the pressure that there is")
            return replace(trial, pressed=found.normal, wears=trial.wears + 1)
        at_once = ~law.weakens | ((found.state == OPEN) & (law.tension[0] > 0.0))
        breaking = trial.taken & (found.state != STICK) & (trial.lost < 1.0) & law.breakable & at_once
        if breaking.any():
            return replace(trial, lost=np.where(breaking, 1.0, trial.lost))
        worn = self._worn(found)
        if trial.wears < MOST_WEARS and (worn > trial.lost + WORN).any():
            return replace(trial, lost=np.maximum(worn, trial.lost), wears=trial.wears + 1)
        opening = trial.taken & (found.state == OPEN) & found.coheres & ~trial.opened
        return replace(trial, opened=trial.opened | opening) if opening.any() else None

    def _bent(self, found: PointStates) -> bool:
        """Whether closure, or friction of rough faces, was taken at another pressure than there is."""
        law = self.contact.law
        return bool(law.bends.any()) and law.changed(found.normal, found.trial.pressed) > CONSISTENT

    def _worn(self, found: PointStates) -> Floats:
        """What points that slip have lost (n,) by then; all others what the trial says."""
        law = self.contact.law
        slips = found.trial.taken & (found.state == SLIP) & law.weakens
        moved = found.slip - law.shear_compliance * found.tangential - self.memory.slip
        lost, most = self.memory.lost, np.where(law.flattens, np.inf, 1.0)  # how far beyond all says the mean dilation
        return np.where(slips, np.minimum(lost + law.worn(lost, moved), most), found.trial.lost)


def _solved_among_stuck(
    problem: ContactProblem, start: Floats | None, active: ActiveSet | None = None
) -> ContactSolution | None:
    """What `solve_among_stuck` finds of many points; None for few, and where round-off has spoilt it."""
    if problem.n_points > MANY or isinstance(problem.points, SparsePoints):
        with suppress(NotSolvedError):
            return solve_among_stuck(problem, start, active)
    return None


def solve_contact_problem(
    problem: ContactProblem,
    solver: Literal["newton", "lemke"],
    start: Floats | None = None,
    near: ActiveEquations | None = None,
) -> ContactSolution:
    """Solve a contact problem of n points by `solver`.

    Newton alone uses `start` (2 n + l,), tractions (Pa) and l amplitudes of rigid motions at first, and `near`, the
    factorized equations of a similar problem. Raises NotSolvedError where no solution is found.
    """
    if solver == "lemke":
        found, other = solve_by_lemke(problem), "; numerics.contact.solver: newton may find one"
    else:
        other = "; numerics.contact.solver: lemke may find one, and takes long with many points"
        found = solve_by_newton(problem, start, near)
    if found.status == "solved":
        return found
    raise NotSolvedError(
        f"the contact problem of {problem.n_points} points was not solved: {solver}: status '{found.status}' after "
        f"{found.iterations} iterations, residual {complementarity_residual(problem, found.unknowns):.2g}{other}; "
        f"try a coarser contact spacing or a softer contact stiffness{_advice(problem)}"
    )


def _advice(problem: ContactProblem) -> str:
    """Advice where friction or dilation is large enough to be what the solvers fail at."""
    n, A = problem.n_points, problem.points.compliance
    coupling, normal = np.abs(A[n:, :n].diagonal()), A.diagonal()[:n]
    steep = problem.dilation * coupling >= normal
    if steep.any():
        return (
            f", or a smaller dilation angle: pressing {steep.sum()} of the points makes them slip and open by dilation "
            "more than it closes them"
        )
    wedged = problem.friction * coupling >= normal
    if not wedged.any():
        return ""
    return f", or less friction: of {problem.friction.max():.3g} it may leave several solutions, or none"


def _states(problem: ContactProblem, solution: ContactSolution, gap: Floats, nothing: Floats) -> Ints:
    """The states (k,): of `coulomb`, but for what round-off makes of points nearly open.

    `nothing` (k,) m are gaps that are none: each point is weighed by the terms that its own jumps are the sums of,
    whatever goes on elsewhere.
    """
    n, cohesion = problem.n_points, problem.cohesion
    unpressed = solution.traction[:n] >= -nothing / problem.points.scale[:n]
    held = np.where(np.abs(solution.traction[n:]) < (1.0 - AT_LIMIT) * cohesion, STICK, SLIP)
    touches = (cohesion > 0.0) & (gap <= nothing)
    return np.where(unpressed, np.where(touches, held, OPEN), solution.state)
