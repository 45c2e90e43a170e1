"""Semismooth Newton method for the condensed contact problem.

The contact law is the fixed point p = project(p + r du) (`coulomb.project`). Its generalised derivative is that of
the branch every point is on, including the dependence of the shear bound on the normal traction; all branches are
linear, so that one Newton step is one linear solve with the current active set (Hintermueller, Ito, Kunisch 2002;
Alart, Curnier 1991 for friction). The problem is that of Li, Zheng, Guo 2017, equations (4) to (6) and (16). The
motions a of pieces that contact alone holds are unknown too, and follow from the balance of the tractions and the loads
on these pieces, F p = pull.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.contact.condensed import Condensed
from crackgrow.contact.continuation import solve_by_continuation
from crackgrow.contact.coulomb import ActiveSet, active_set, project
from crackgrow.contact.equations import ActiveEquations, solve_active
from crackgrow.contact.loose import balancing
from crackgrow.contact.problem import ContactProblem, ContactSolution

ROUND_OFF: Final = 1e-12  # change of p by `project`, relative to the largest |p|, that a dense solve can leave
REPEATED_ROUND_OFF: Final = 1e-10  # the same where the active set repeats: another step cannot lower it
UNIT: Final = 1e-15  # round-off of a term of A p; its sum, weighed by r, is as far as a repeated set can come down
SOFT: Final = 1e4  # times the rock at a contact point: of the first springs; from 1e2 to 1e5 most need one release
SOFTER: Final = 1.5  # times the springs before: where many releases are needed stiff ones gain little
MOST_SPRINGS: Final = 30  # releases: of 3,855 problems at random they find all but 13, of which most are limit states
FEW: Final = 0.1  # share of the points: where so few leave their branches the problem is condensed onto them
MOST_MOVING: Final = 0.2  # share of the points that it is condensed onto in the end: more cost another factorization
MOST_WEDGED: Final = 2  # times that points are taken in since there is no solution without them
MOST_STEPS: Final = 100  # of Newton: 937 of 1,000 problems at random take 14 at most, one of 807 points 28


def solve_by_newton(problem: ContactProblem, start: Floats | None = None) -> ContactSolution:
    """Tractions of the contact problem; status "solved", or "limit" with the last ones found.

    `start` (2 n + l,) are unknowns to start from; None: all points stick. An iteration is one linear solve. Where few
    points leave their branches the problem is condensed onto them; where an active set comes back, onto those that have
    changed since. Where these are all, the solution is followed from a state that is known (`continuation`); loose
    pieces are held by springs for it.
    "limit" is to be expected where A is not positive definite on the scale of its diagonal: rigid contact at more
    points than the displacement can follow, friction beyond the range in which a solution exists, or a piece of rock
    that contact does not hold.
    """
    if start is None:
        slip = np.where(problem.resists, 0, 1)  # where the way does not matter it is one and the same
        sense = np.where(problem.resists, np.sign(problem.slipped), 1).astype(np.int64)
        active = ActiveSet(np.ones(problem.n_points, dtype=bool), slip, sense)
    else:
        active = _branches(problem, _checked(problem, start))
    found = _stepped(problem, active)
    if found.status != "solved" and problem.motions is not None:
        found = _by_springs(problem, found)
    return found


def _by_springs(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution where loose pieces are held by soft springs, which are released, and softer each time.

    A spring pushes a piece back to where it was found the last time (proximal point method, Rockafellar 1976): pieces
    that nothing presses have one place then, and each problem is one of rock that is held. `found` where no number of
    times is enough: what contact does not hold runs away.
    """
    motions, m, x, iterations = problem.motions, problem.free.size, found.unknowns, found.iterations
    assert motions is not None
    soft = SOFT * float(np.median(problem.scale)) * balancing(motions)  # (l, l) m per N/m
    best, least = found, residual_floor(problem)
    for _ in range(MOST_SPRINGS):
        still, springs = x[m:] + soft @ motions.pull, motions.jump @ soft @ motions.force
        free = problem.free + motions.jump @ still
        held = replace(problem, compliance=problem.compliance + springs, free=free, motions=None)
        there = _stepped(held, _branches(held, x[:m]))
        iterations += there.iterations
        if there.status != "solved":
            break
        x = np.append(there.traction, still - soft @ (motions.force @ there.traction))
        left = residual(problem, x, problem.jump(x))
        if left <= least:
            best, least = replace(there, motion=x[m:]), left
        if left <= ROUND_OFF:
            break
        there = _stepped(problem, _branches(problem, x))
        iterations += there.iterations
        if there.status == "solved":
            best = there
            break
        soft = SOFTER * soft
    return replace(best, iterations=iterations)


def _stepped(problem: ContactProblem, active: ActiveSet) -> ContactSolution:
    """What Newton's steps from an active set on come to."""
    passed, keys = list[ActiveSet](), list[bytes]()
    as_good, ends = residual_floor(problem), False
    while not ends:
        passed.append(active)
        keys.append(active.key())
        equations = ActiveEquations(problem, active)
        x = equations.solution()
        now = _through_stick(problem, active, _branches(problem, x))
        if residual(problem, x, problem.jump(x)) <= (as_good if now.key() == keys[-1] else ROUND_OFF):
            return _ended(problem, x, active, "solved", len(passed))
        back = keys.index(now.key()) if now.key() in keys else len(keys)  # where they begin to go round in circles
        moving = np.any([active.differs(other, problem) for other in (now, *passed[back:])], axis=0)
        ends = back < len(keys) or len(keys) == MOST_STEPS
        if ends or moving.mean() <= FEW:
            found = _of_some(problem, equations, x, moving, 1.0 if ends else MOST_MOVING)
            now = _branches(problem, found.unknowns)
            if ends and found.status != "solved":
                found = _around(problem, found)
            ends |= found.status == "solved"
        active = now
    return replace(found, iterations=found.iterations + len(passed))


def _of_some(
    problem: ContactProblem, equations: ActiveEquations, x: Floats, moving: Bools, most: float
) -> ContactSolution:
    """The solution where few points leave the branches of the equations of an active set, whose unknowns are x.

    These points are `moving` (n,), and those that leave their branches with them, up to a share `most` of all; status
    "limit" where it takes more, or all.
    """
    moving, there, iterations, part, wedged = moving.copy(), x, 0, None, 0
    while moving.any() and not moving.all() and moving.mean() <= most and wedged <= MOST_WEDGED:
        part = Condensed.onto(equations, x, moving, part)
        if part is None:
            break
        found = None
        if part.problem is not None:
            near = np.append(there[part.at], np.zeros(part.problem.n_motions))
            found = _stepped(part.problem, _branches(part.problem, near))
            iterations += found.iterations
        if found is None or found.status != "solved":  # no solution while others stay on their branches
            moving[part.most_sensitive(moving)], wedged = True, wedged + 1
            continue
        there = part.expanded(found)
        now = _branches(problem, there)
        leaving = equations.active.differs(now, problem) & ~moving
        if not leaving.any():
            good = residual(problem, there, problem.jump(there)) <= residual_floor(problem)
            return _ended(problem, there, now, "solved" if good else "limit", iterations)
        moving |= leaving
    return _ended(problem, there, equations.active, "limit", iterations)


def _around(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution followed from a state that is known, where supports hold all of the rock; `found` where none is."""
    way = None if problem.motions is not None else solve_by_continuation(problem)
    if way is None:
        return found
    x = solve_active(problem, way[1])
    status = "solved" if residual(problem, x, problem.jump(x)) <= residual_floor(problem) else "limit"
    return _ended(problem, x, way[1], status, found.iterations + way[2])


def _ended(problem: ContactProblem, x: Floats, active: ActiveSet, status: str, iterations: int) -> ContactSolution:
    """The solution with unknowns x (2 n + l,)."""
    n, m = problem.n_points, problem.free.size
    if status == "solved":
        x[:n] = np.minimum(x[:n], 0.0)
    return ContactSolution(x[:m], status, iterations, active.states(), x[m:])


def _branches(problem: ContactProblem, x: Floats) -> ActiveSet:
    """The branches that points are on with unknowns x (2 n + l,)."""
    return active_set(problem, x[: problem.free.size], problem.jump(x))


def residual_floor(problem: ContactProblem) -> float:
    """The change of tractions by `project` that another step cannot lower, relative to the largest."""
    return max(REPEATED_ROUND_OFF, UNIT * float((problem.reach / problem.scale).max(initial=0.0)))


def _checked(problem: ContactProblem, start: Floats) -> Floats:
    shape = (problem.free.size + problem.n_motions,)
    if start.shape != shape or not np.isfinite(start).all():
        raise ValueError(
            f"contact start: shape {start.shape} with {np.count_nonzero(~np.isfinite(start))} values that are not "
            f"finite, must be finite of shape {shape}: leave it out to start from a first guess"
        )
    return np.asarray(start, dtype=np.float64)


def residual(problem: ContactProblem, x: Floats, du: Floats) -> float:
    """What unknowns x (2 n + l,) with the jump du (2 n,) miss: the largest change of a traction by `project`, relative
    to the largest one before or after, or the imbalance of loose pieces."""
    p = x[: problem.free.size]
    projected = project(problem, p, du)
    scale = max(float(np.abs(p).max(initial=0.0)), float(np.abs(projected).max(initial=0.0)))
    if problem.motions is not None:
        scale = max(scale, problem.least_traction)
    change = float(np.abs(projected - p).max(initial=0.0)) / scale if scale > 0.0 else 0.0
    return max(change, problem.imbalance(x))


def _through_stick(problem: ContactProblem, active: ActiveSet, following: ActiveSet) -> ActiveSet:
    """Let a point stick for one step before it slips the other way: this ends most cycles of reversing points."""
    reversing = (active.slip * following.slip < 0) & (following.closed | (problem.cohesion > 0.0))
    slip = np.where(reversing, 0, following.slip)
    sense = np.where(reversing, np.sign(problem.slipped), following.sense).astype(np.int64)
    return ActiveSet(following.closed, slip, sense)
