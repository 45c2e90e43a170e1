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

from crackgrow.arrays import Floats
from crackgrow.contact.continuation import followed
from crackgrow.contact.coulomb import ActiveSet, active_set, project
from crackgrow.contact.equations import solve_active
from crackgrow.contact.loose import balancing
from crackgrow.contact.problem import ContactProblem, ContactSolution

ROUND_OFF: Final = 1e-12  # change of p by `project`, relative to the largest |p|, that a dense solve can leave
REPEATED_ROUND_OFF: Final = 1e-10  # the same where the active set repeats: another step cannot lower it
UNIT: Final = 1e-15  # round-off of a term of A p; its sum, weighed by r, is as far as a repeated set can come down
SOFT: Final = 1e4  # times the rock at a contact point: of the first springs; from 1e2 to 1e5 most need one release
SOFTER: Final = 1.5  # times the springs before: where many releases are needed stiff ones gain little
MOST_SPRINGS: Final = 30  # releases: of 3,855 problems at random they find all but 13, of which most are limit states
MOST_STEPS: Final = 100  # of Newton: 937 of 1,000 problems at random take 14 at most, one of 807 points 28


def solve_by_newton(problem: ContactProblem, start: Floats | None = None) -> ContactSolution:
    """Tractions of the contact problem; status "solved", or "limit" with the last ones found.

    `start` (2 n + l,) are unknowns to start from, `first_guess` if None. An iteration is one linear solve. Where an
    active set comes back, or none stays, the solution is followed from a state that is known (`continuation`); loose
    pieces are held by springs for it.
    "limit" is to be expected where A is not positive definite on the scale of its diagonal: rigid contact at more
    points than the displacement can follow, friction beyond the range in which a solution exists, or a piece of rock
    that contact does not hold.
    """
    found = _stepped(problem, first_guess(problem) if start is None else _checked(problem, start))
    if found.status != "solved":
        found = _around(problem, found) if problem.motions is None else _by_springs(problem, found)
    return found


def _around(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution followed from a state that is known, where supports hold all of the rock; `found` where none is."""
    way = followed(problem)
    if way is None:
        return found
    there = _stepped(problem, way[0])
    return replace(there, iterations=found.iterations + way[2] + there.iterations)


def _by_springs(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution where loose pieces are held by soft springs, which are released, and softer each time.

    A spring pushes a piece back to where it was found the last time (proximal point method, Rockafellar 1976): pieces
    that nothing presses have one place then, and each problem is one of rock that is held. `found` where no number of
    times is enough: what contact does not hold runs away.
    """
    motions, m, x, iterations = problem.motions, problem.free.size, found.unknowns, found.iterations
    assert motions is not None
    soft = SOFT * float(np.median(problem.scale)) * balancing(motions)  # (l, l) m per N/m
    best, least = found, as_far(problem)
    for _ in range(MOST_SPRINGS):
        still, springs = x[m:] + soft @ motions.pull, motions.jump @ soft @ motions.force
        free = problem.free + motions.jump @ still
        held = replace(problem, compliance=problem.compliance + springs, free=free, motions=None)
        there = _stepped(held, x[:m])
        if there.status != "solved":
            there = _around(held, there)
        iterations += there.iterations
        if there.status != "solved":
            break
        x = np.append(there.traction, still - soft @ (motions.force @ there.traction))
        left = missed(problem, x, problem.jump(x))
        if left <= least:
            best, least = replace(there, motion=x[m:]), left
        if left <= ROUND_OFF:
            break
        there = _stepped(problem, x)
        iterations += there.iterations
        if there.status == "solved":
            best = there
            break
        soft = SOFTER * soft
    return replace(best, iterations=iterations)


def _stepped(problem: ContactProblem, x: Floats) -> ContactSolution:
    """What Newton's steps from unknowns x (2 n + l,) on come to."""
    m, iterations = problem.free.size, 0
    active = active_set(problem, x[:m], problem.jump(x))
    seen: set[bytes] = set()
    as_good = as_far(problem)
    while active.key() not in seen and iterations < MOST_STEPS:
        seen.add(active.key())
        x, iterations = solve_active(problem, active), iterations + 1
        du = problem.jump(x)
        following = _through_stick(problem, active, active_set(problem, x[:m], du))
        if missed(problem, x, du) <= (as_good if following.key() == active.key() else ROUND_OFF):
            x[: problem.n_points] = np.minimum(x[: problem.n_points], 0.0)
            return ContactSolution(x[:m], "solved", iterations, active.states(), x[m:])
        active = following
    return ContactSolution(x[:m], "limit", iterations, active.states(), x[m:])


def as_far(problem: ContactProblem) -> float:
    """The change of tractions by `project` that another step cannot lower, relative to the largest."""
    return max(REPEATED_ROUND_OFF, UNIT * float((problem.reach / problem.scale).max(initial=0.0)))


def first_guess(problem: ContactProblem) -> Floats:
    """Unknowns (2 n + l,) to start from: all points stick."""
    stuck = np.zeros(problem.n_points, dtype=np.int64)
    return solve_active(problem, ActiveSet(np.ones(problem.n_points, dtype=bool), stuck, stuck))


def _checked(problem: ContactProblem, start: Floats) -> Floats:
    shape = (problem.free.size + problem.n_motions,)
    if start.shape != shape or not np.isfinite(start).all():
        raise ValueError(
            f"contact start: shape {start.shape} with {np.count_nonzero(~np.isfinite(start))} values that are not "
            f"finite, must be finite of shape {shape}: leave it out to start from a first guess"
        )
    return np.asarray(start, dtype=np.float64)


def missed(problem: ContactProblem, x: Floats, du: Floats) -> float:
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
    reversing = active.slip * following.slip < 0
    slip = np.where(reversing, 0, following.slip)
    sense = np.where(reversing, np.sign(problem.slipped), following.sense).astype(np.int64)
    return ActiveSet(following.closed, slip, sense)
