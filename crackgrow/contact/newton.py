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
from crackgrow.contact.coulomb import ActiveSet, active_set, project
from crackgrow.contact.equations import ActiveEquations, equations_of
from crackgrow.contact.points import CondensedPoints
from crackgrow.contact.problem import ContactProblem, ContactSolution

ROUND_OFF: Final = 1e-12  # change of p by `project`, relative to the largest |p|, that a dense solve can leave
REPEATED_ROUND_OFF: Final = 1e-10  # the same where the active set repeats: another step cannot lower it
UNIT: Final = 1e-15  # round-off of a term of A p; its sum, weighed by r, is as far as a repeated set can come down
SOFT: Final = 1e4  # times the rock at a contact point: of the first springs; from 1e2 to 1e5 most need one release
SOFTER: Final = 1.5  # times the springs before: where many releases are needed stiff ones gain little
NEAR: Final = 0.1  # times the rock at a contact point: of the compliance that holds tractions near those before
NEARER: Final = 10.0  # times that, where Newton's steps still go round in circles
FARTHER: Final = 0.5  # times that, where they don't
NEAREST: Final = 100.0  # times the rock: where they do even so the tractions before lead nowhere
MOST_TIMES: Final = 40  # of 80 hard problems at random twice as many solve no more
MOST_STEPS: Final = 100  # of Newton: 937 of 1,000 problems at random take 14 at most, one of 807 points 28


def solve_by_newton(
    problem: ContactProblem, start: Floats | None = None, near: ActiveEquations | None = None
) -> ContactSolution:
    """Tractions of the contact problem; status "solved", or "limit" with the last ones found.

    `start` (2 n + l,) are unknowns to start from; None: all points stick. `near` are equations that may be the first
    ones. An iteration is one linear solve. Loose pieces are settled for it. Where an active set comes back the solution
    is looked for from others that are near (`_by_proximal_points`).
    "limit" is to be expected where A is not positive definite on the scale of its diagonal: rigid contact at more
    points than the displacement can follow, friction beyond the range in which a solution exists, or a piece of rock
    that contact does not hold.
    """
    (lying, unknowns), m = problem.settled(), problem.free.size
    if start is None:
        slip = np.where(problem.resists, 0, 1)  # where the way does not matter it is one and the same
        sense = np.where(problem.resists, np.sign(problem.slipped), 1).astype(np.int64)
        active = ActiveSet(np.ones(problem.n_points, dtype=bool), slip, sense)
    else:
        active = _branches(lying, np.append(start[:m], 2.0 * start[m:] - unknowns(start)[m:]))
    found = _stepped(lying, active, near)
    if found.status != "solved":
        found = _by_proximal_points(lying, found)
    return replace(found, motion=unknowns(found.unknowns)[m:])


def _stepped(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> ContactSolution:
    """What Newton's steps from an active set on come to."""
    equations, keys, as_good = near, list[bytes](), residual_floor(problem)
    while True:
        equations = equations_of(problem, active, equations)
        x = equations.solution(problem, active)
        du = problem.jump(x)
        now = active_set(problem, x[: problem.free.size], du)
        # a point sticks for one step before it slips the other way: this ends most cycles of reversing points
        reversing = (active.slip * now.slip < 0) & (now.closed | (problem.cohesion > 0.0))
        sense = np.where(reversing, np.sign(problem.slipped), now.sense).astype(np.int64)
        now = ActiveSet(now.closed, np.where(reversing, 0, now.slip), sense)
        keys.append(active.key())
        settled = now.key() == keys[-1]
        if residual(problem, x, du) <= (as_good if settled else ROUND_OFF):
            return _ended(problem, x, active, "solved", len(keys), equations)
        if now.key() in keys or len(keys) == MOST_STEPS:
            return _ended(problem, x, active, "limit", len(keys), equations)
        active = now


def _by_proximal_points(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution where Newton's steps go round in circles: proximal point method (Rockafellar 1976).

    Tractions p and the places a of loose pieces are held near those of the last time, by a compliance of all points and
    by soft springs,

        du = free - A p - c diag(A) (p - p') + B a,    a = a' + S (pull - F p),

    which leaves one solution where these are stiff enough, and a place to pieces that nothing presses. From there on
    Newton's steps are tried again. `found` where no number of times is enough: what contact does not hold runs away.
    """
    m, x, iterations, points = problem.free.size, found.unknowns, found.iterations, problem.points
    soft = SOFT * float(np.median(points.scale)) * points.balance
    near, best, least = 0.0 if problem.n_motions else NEAR, found, residual_floor(problem)
    for _ in range(MOST_TIMES):
        still = x[m:] + soft @ problem.pull
        added = np.diag(near * points.scale) + points.jump @ soft @ points.force
        moved = near * points.scale * x[:m] + points.jump @ still
        stiff = CondensedPoints(points.compliance + added)
        held = replace(problem, points=stiff, free=problem.free + moved, pull=np.zeros(0))
        there = _stepped(held, _branches(held, x[:m]))
        iterations += there.iterations
        if there.status != "solved":
            if near < NEAREST:
                near = max(NEARER * near, NEAR)
            else:  # nothing is found near these
                x, near = 0.5 * x, NEAR
            continue
        x = np.append(there.traction, still - soft @ (points.force @ there.traction))
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
        near, soft = FARTHER * near, SOFTER * soft
    return replace(best, iterations=iterations)


def _ended(
    problem: ContactProblem, x: Floats, active: ActiveSet, status: str, iterations: int, equations: ActiveEquations
) -> ContactSolution:
    """The solution with unknowns x (2 n + l,)."""
    n, m = problem.n_points, problem.free.size
    if status == "solved":
        x[:n] = np.minimum(x[:n], 0.0)
    return ContactSolution(x[:m], status, iterations, active.states(), x[m:], equations)


def _branches(problem: ContactProblem, x: Floats) -> ActiveSet:
    """The branches that points are on with unknowns x (2 n + l,)."""
    return active_set(problem, x[: problem.free.size], problem.jump(x))


def residual_floor(problem: ContactProblem) -> float:
    """The change of tractions by `project` that another step cannot lower, relative to the largest."""
    return max(REPEATED_ROUND_OFF, UNIT * float((problem.points.reach / problem.points.scale).max(initial=0.0)))


def residual(problem: ContactProblem, x: Floats, du: Floats) -> float:
    """What unknowns x (2 n + l,) with the jump du (2 n,) miss: the largest change of a traction by `project`, relative
    to the largest one before or after, or the imbalance of loose pieces."""
    p = x[: problem.free.size]
    projected = project(problem, p, du)
    scale = max(float(np.abs(p).max(initial=0.0)), float(np.abs(projected).max(initial=0.0)))
    if problem.n_motions:
        scale = max(scale, problem.least_traction)
    change = float(np.abs(projected - p).max(initial=0.0)) / scale if scale > 0.0 else 0.0
    return max(change, problem.imbalance(x))
