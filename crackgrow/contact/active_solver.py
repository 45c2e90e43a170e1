"""The linear solve of one active set: tractions under the equations of the branches that the points are on.

Unknown are p_n of closed and p_t of sticking points. With slip = 0, 1 or -1 of a point, sense that of all its slip, and
the jump du = free - A p, they follow from

    du_n - d sense (s0 + du_t) = 0   where it is closed,     du_t = 0   where it sticks,

elsewhere p_n = 0 and p_t = slip (cohesion - friction p_n). These are the derivatives of `coulomb.project`, branch by
branch, and all of them are linear.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from crackgrow.contact.coulomb import ActiveSet, ContactProblem, Floats, Ints


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """(m,) Pa: tractions with the equations of one active set.

    A singular system (rigid contact, more points than the displacement can follow) gets its least-squares solution.
    """
    A, n = problem.compliance, problem.n_points
    if problem.friction is None:
        rows = np.flatnonzero(active.closed)
        p = np.zeros(n)
        p[rows] = _solution(A.take(rows, axis=0).take(rows, axis=1), problem.free[rows])
        return p
    assert problem.cohesion is not None
    rows = np.flatnonzero(np.concatenate([active.closed, active.slip == 0]))
    given = np.append(np.zeros(n), active.slip * problem.cohesion)
    p = given.copy()
    p[rows] = _solution(*_equations(problem, active, rows, given))
    sliding = np.flatnonzero(active.slip)
    p[n + sliding] = given[n + sliding] - active.slip[sliding] * problem.friction[sliding] * p[sliding]
    return p


def _equations(problem: ContactProblem, active: ActiveSet, rows: Ints, given: Floats) -> tuple[Floats, Floats]:
    """Matrix (k, k) and right-hand side (k,) for the unknown tractions `rows`, where the others have a part `given`."""
    assert problem.friction is not None
    assert problem.dilation is not None
    assert problem.slipped is not None
    A, n = problem.compliance, problem.n_points
    closed = rows[: np.searchsorted(rows, n)]
    sliding = np.flatnonzero(active.slip[closed])  # places in `rows` of points that are closed and slide
    points = closed[sliding]
    slope = active.slip[points] * problem.friction[points]

    def per_unknown(some: Ints) -> Floats:
        """Jumps of `some` rows per unknown traction, with the shear that goes with pressure."""
        of = A.take(some, axis=0)
        found = of.take(rows, axis=1)
        found[:, sliding] -= of.take(n + points, axis=1) * slope
        return found

    K, right = per_unknown(rows), problem.free[rows] - A.take(rows, axis=0) @ given
    lean = problem.dilation * (active.slip if active.sense is None else active.sense)
    right[: len(closed)] -= lean[closed] * problem.slipped[closed]
    if lean[points].any():
        K[sliding] -= lean[points, None] * per_unknown(n + points)
        right[sliding] -= lean[points] * (problem.free[n + points] - A.take(n + points, axis=0) @ given)
    return K, right


def _solution(K: Floats, right: Floats) -> Floats:
    """Solution (k,) of K x = `right`, the least-squares one where K is singular."""
    if not right.size:
        return right
    lu, pivots, info = dgetrf(K.T)  # LAPACK wants columns: the rows of K are those of its transpose
    x = np.asarray(dgetrs(lu, pivots, right, trans=1)[0]) if not info else np.full(len(right), np.nan)
    return x if np.isfinite(x).all() else np.asarray(np.linalg.lstsq(K, right)[0])
