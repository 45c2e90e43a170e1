"""The linear solve of one active set: tractions under the equations of the branches that the points are on.

Unknown are p_n of closed and p_t of sticking points. With slip = 0, 1 or -1 of a point, sense that of all its slip, and
the jump du = free - A p + B a, they follow from

    du_n - d sense (s0 + du_t) = 0   where it is closed,     du_t = 0   where it sticks,

elsewhere p_n = 0 and p_t = slip (cohesion - friction p_n). These are the derivatives of `coulomb.project`, branch by
branch, and all of them are linear. The motions a of pieces that contact alone holds are unknown too, and follow from
the balance of the tractions and the loads on these pieces, F p = pull.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import ActiveSet, ContactProblem

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """Unknowns (m + k,) of the problem with the equations of one active set.

    A singular system (rigid contact, more points than the displacement can follow) gets its least-squares solution.
    """
    m, n = problem.free.size, problem.n_points
    slip = np.zeros(n, dtype=np.int64) if problem.friction is None else active.slip
    stuck = np.zeros(m - n, dtype=bool) if problem.friction is None else slip == 0
    rows = np.flatnonzero(np.concatenate([active.closed, stuck]))
    x = np.zeros(m + problem.n_motions)
    if problem.cohesion is not None:
        x[n:m] = slip * problem.cohesion
    equations = _Equations(problem, active, slip, rows)
    K, right = equations.matrix(), equations.right(x[:m])
    if problem.motions is None:
        x[rows] = _solution(K, right)
    else:
        x[rows], x[m:] = np.split(_with_motions(problem, equations, K, (right, x[:m])), [len(rows)])
    if problem.friction is not None:
        sliding = np.flatnonzero(slip)
        x[n + sliding] -= slip[sliding] * problem.friction[sliding] * x[sliding]
    return x


class _Equations:
    """The equations for the unknown tractions `rows` (k,) of an active set."""

    def __init__(self, problem: ContactProblem, active: ActiveSet, slip: Ints, rows: Ints) -> None:
        n = problem.n_points
        self._problem, self._rows, self._n = problem, rows, n
        self._closed = rows[: np.searchsorted(rows, n)]
        self._sliding = np.flatnonzero(slip[self._closed])  # places in `rows` of points that are closed and slide
        self._points = self._closed[self._sliding]
        self._lean = np.zeros(n)  # by which gaps of closed points go with their slip
        if problem.friction is not None and problem.dilation is not None:
            self._slope = slip[self._points] * problem.friction[self._points]
            self._lean = problem.dilation * (slip if active.sense is None else active.sense)

    def matrix(self) -> Floats:
        """(k, k) jumps that unknown tractions take away, of the branches."""
        return self._of_rows(self._per_unknown)

    def right(self, given: Floats) -> Floats:
        """(k,) where the tractions that are not unknown have a part `given` (m,) of their own."""
        A, problem = self._problem.compliance, self._problem
        right = self._of_rows(lambda some: problem.free[some] - A.take(some, axis=0) @ given)
        if problem.slipped is not None:
            right[: len(self._closed)] -= (self._lean * problem.slipped)[self._closed]
        return right

    def of_motions(self, jump: Floats) -> Floats:
        """(k, l) what the branches see of motions with the jumps (m, l)."""
        return self._of_rows(lambda some: jump.take(some, axis=0))

    def per_unknown(self, of: Floats) -> Floats:
        """(r, k) per unknown traction, with the shear that goes with pressure, of something (r, m) per traction."""
        found = of.take(self._rows, axis=1)
        if len(self._sliding):
            found[:, self._sliding] -= of.take(self._n + self._points, axis=1) * self._slope
        return found

    def _per_unknown(self, some: Ints) -> Floats:
        return self.per_unknown(self._problem.compliance.take(some, axis=0))

    def _of_rows(self, of: Callable[[Ints], Floats]) -> Floats:
        """What `of` says of the unknown rows, with the part of the slip that dilation adds to gaps."""
        found, lean = of(self._rows), self._lean[self._points]
        if lean.any():
            found[self._sliding] -= (lean * of(self._n + self._points).T).T
        return found


def _with_motions(problem: ContactProblem, equations: _Equations, K: Floats, known: tuple[Floats, Floats]) -> Floats:
    """Unknown tractions and motions (k + l,); `known` are the right-hand side and the tractions that are given."""
    motions, (right, given) = problem.motions, known
    assert motions is not None
    size, pull = float(problem.scale.mean()), float(np.abs(motions.force).max()) or 1.0
    balance = equations.per_unknown(motions.force) / pull
    n_motions = len(balance)
    bordered = np.block([[K / size, -equations.of_motions(motions.jump)], [balance, np.zeros((n_motions, n_motions))]])
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
