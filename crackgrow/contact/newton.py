"""Semismooth Newton method for the condensed contact problem, with projected Gauss-Seidel sweeps against cycling.

The contact law is the fixed point p = project(p + r du) (`coulomb.project`). Its generalised derivative is that of
the branch every point is on, including the dependence of the shear bound on the normal traction; all branches are
linear, so that one Newton step is one linear solve with the current active set (Hintermueller, Ito, Kunisch 2002;
Alart, Curnier 1991 for friction). The problem is that of Li, Zheng, Guo 2017, equations (4) to (6) and (16). The
motions a of pieces that contact alone holds are unknown too, and follow from the balance of the tractions and the loads
on these pieces, F p = pull.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import ActiveSet, Branches, active_set, project
from crackgrow.contact.problem import ContactProblem, ContactSolution

ROUND_OFF: Final = 1e-12  # change of p by `project`, relative to the largest |p|, that a dense solve can leave
REPEATED_ROUND_OFF: Final = 1e-10  # the same where the active set repeats: another step cannot lower it
UNIT: Final = 1e-15  # round-off of a term of A p; its sum, weighed by r, is as far as a repeated set can come down
FIRST_SWEEPS: Final = 3  # Gauss-Seidel sweeps before the first step
SWEEPS: Final = (5, 10, 20, 40, 80, 160)  # after one cycle and the next: more than three are hardly ever of use
UNSEEN: Final = 1e-12  # motions that contact points see by less, relative to what they see best, are not seen

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


def solve_by_newton(problem: ContactProblem, start: Floats | None = None, max_iterations: int = 100) -> ContactSolution:
    """Tractions of the contact problem; status "solved", or "limit" with the best tractions found.

    `start` (2 n + l,) are unknowns to start from, `first_guess` if None. An iteration is one linear solve. Where an
    active set comes back without convergence projected Gauss-Seidel sweeps lead out of the cycle.
    "limit" is to be expected where A is not positive definite on the scale of its diagonal: rigid contact at more
    points than the displacement can follow, friction beyond the range in which a solution exists, or a piece of rock
    that contact does not hold.
    """
    x = first_guess(problem) if start is None else _checked(problem, start)
    m = problem.free.size
    best, least = x, np.inf
    active = active_set(problem, x[:m], problem.jump(x))
    seen: set[bytes] = set()
    ways_out = iter(SWEEPS)
    as_good = as_far(problem)
    for iteration in range(1, max_iterations + 1):
        seen.add(active.key())
        x = solve_active(problem, active)
        du = problem.jump(x)
        residual = max(change(problem, x[:m], du), problem.imbalance(x))
        following = _through_stick(problem, active, active_set(problem, x[:m], du))
        repeated = following.key() == active.key()
        if residual < least:
            best, least = x, residual
        if residual <= (as_good if repeated else ROUND_OFF):
            x[: problem.n_points] = np.minimum(x[: problem.n_points], 0.0)
            return ContactSolution(x[:m], "solved", iteration, active.states(), x[m:])
        if following.key() in seen:
            n_sweeps = next(ways_out, 0)
            if n_sweeps == 0 or problem.motions is not None:
                break
            x = sweep(problem, x, n_sweeps)
            following = active_set(problem, x[:m], problem.jump(x))
            seen.clear()
        active = following
    states = active_set(problem, best[:m], problem.jump(best)).states()
    return ContactSolution(best[:m], "limit", iteration, states, best[m:])


def sweep(problem: ContactProblem, x: Floats, n_sweeps: int) -> Floats:
    """Unknowns (2 n + l,) after projected Gauss-Seidel sweeps from x on, point by point, normal before tangential."""
    A, n = problem.compliance, problem.n_points
    p, rows = x.copy(), list(A)
    arrays = (problem.free, A.diagonal(), problem.friction, problem.cohesion, problem.dilation, problem.slipped)
    free, diagonal, friction, cohesion, dilation, slipped = (array.tolist() for array in arrays)
    for _ in range(n_sweeps):
        for i in range(n):
            t = n + i
            gap = free[i] - float(rows[i].dot(p))
            if dilation[i]:
                gap -= dilation[i] * abs(slipped[i] + free[t] - float(rows[t].dot(p)))
            p_n = min(0.0, float(p[i]) + gap / diagonal[i])
            p[i] = p_n
            b = max(0.0, cohesion[i] - friction[i] * p_n)
            if b > 0.0:
                p[t] = min(b, max(-b, float(p[t]) + (free[t] - float(rows[t].dot(p))) / diagonal[t]))
            else:
                p[t] = 0.0
    return p


def as_far(problem: ContactProblem) -> float:
    """The change of tractions by `project` that another step cannot lower, relative to the largest."""
    return max(REPEATED_ROUND_OFF, UNIT * float((problem.reach / problem.scale).max(initial=0.0)))


def first_guess(problem: ContactProblem) -> Floats:
    """Unknowns (2 n + l,) to start from: of sweeps, or where contact alone holds pieces with all points stuck."""
    if problem.motions is not None:
        n = problem.n_points
        stuck = np.zeros(n, dtype=np.int64)
        return solve_active(problem, ActiveSet(np.ones(n, dtype=bool), stuck, stuck))
    return sweep(problem, np.zeros(problem.free.size), FIRST_SWEEPS)


def _checked(problem: ContactProblem, start: Floats) -> Floats:
    shape = (problem.free.size + problem.n_motions,)
    if start.shape != shape or not np.isfinite(start).all():
        raise ValueError(
            f"contact start: shape {start.shape} with {np.count_nonzero(~np.isfinite(start))} values that are not "
            f"finite, must be finite of shape {shape}: leave it out to start from a first guess"
        )
    return np.asarray(start, dtype=np.float64)


def change(problem: ContactProblem, p: Floats, du: Floats) -> float:
    """Largest change of p by `project`, relative to the largest traction before or after."""
    projected = project(problem, p, du)
    scale = max(float(np.abs(p).max(initial=0.0)), float(np.abs(projected).max(initial=0.0)))
    if problem.motions is not None:
        scale = max(scale, problem.least_traction)
    return float(np.abs(projected - p).max(initial=0.0)) / scale if scale > 0.0 else 0.0


def _through_stick(problem: ContactProblem, active: ActiveSet, following: ActiveSet) -> ActiveSet:
    """Let a point stick for one step before it slips the other way: this ends most cycles of reversing points."""
    reversing = active.slip * following.slip < 0
    slip = np.where(reversing, 0, following.slip)
    sense = np.where(reversing, np.sign(problem.slipped), following.sense).astype(np.int64)
    return ActiveSet(following.closed, slip, sense)


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set.

    A singular system (rigid contact, more points than the displacement can follow) gets its least-squares solution.
    """
    branches = Branches(problem, active)
    K, right = branches.matrix(), branches.right()
    if problem.motions is None:
        return branches.tractions(_solution(K, right))
    found = _with_motions(problem, branches, K, right)
    unknown, motion = np.split(found, [len(right)])
    return np.concatenate([branches.tractions(unknown), motion])


def _with_motions(problem: ContactProblem, branches: Branches, K: Floats, right: Floats) -> Floats:
    """Unknown tractions and motions (k + l,)."""
    motions, given = problem.motions, branches.known()
    assert motions is not None
    size, pull = float(problem.scale.mean()), float(np.abs(motions.force).max()) or 1.0
    balance = branches.per_unknown(motions.force) / pull
    n_motions = len(balance)
    bordered = np.block([[K / size, -branches.of_motions(motions.jump)], [balance, np.zeros((n_motions, n_motions))]])
    x = _solution(bordered, np.append(right, (motions.pull - motions.force @ given) * (size / pull)), SINGULAR)
    x[: len(K)] /= size
    return x


def _solution(K: Floats, right: Floats, singular: float = 0.0) -> Floats:
    """Solution (k,) of K x = `right`; the least-squares one where K is singular, or worse conditioned than that."""
    if not right.size:
        return right
    lu, pivots, info = dgetrf(K.T)  # LAPACK wants columns: the rows of K are those of its transpose
    if not info and (singular == 0.0 or dgecon(lu, np.abs(K).sum(axis=1).max(), norm="1")[0] > singular):
        x = np.asarray(dgetrs(lu, pivots, right, trans=1)[0])
        if singular:  # supports carry what the balance of pieces misses: all digits count
            x += dgetrs(lu, pivots, right - K @ x, trans=1)[0]
        if np.isfinite(x).all():
            return x
    return np.asarray(np.linalg.lstsq(K, right, rcond=LEAST_SQUARES if singular else None)[0])
