"""The equations of one active set of the contact problem, factorized: the derivative of `coulomb.project` there.

With slip = 0, 1 or -1 of a point, sense that of all its slip, and the jump du = free - A p + B a, the tractions that
the set leaves unknown, p_n of closed and p_t of stuck points, follow from

    du_n - d sense (s0 + du_t) = 0   where it is closed,     du_t = 0   where it sticks,

elsewhere p_n = 0 and p_t = slip (cohesion - friction p_n). Where contact alone holds pieces of rock the balance of the
tractions and the loads on them, F p = pull, is among these. All are linear, and the factors serve all loads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.coulomb import ActiveSet
from crackgrow.contact.points import absolute_product
from crackgrow.contact.problem import ContactProblem

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


class ActiveEquations:
    """The factorized equations of one active set, of points on rock. Singular ones have least-squares solutions.

    They are singular where contact is rigid at more points than the displacement can follow, or no closed point sees a
    motion.
    """

    def __init__(self, problem: ContactProblem, active: ActiveSet) -> None:
        self.points, self._coefficients, n = problem.points, _coefficients(problem, active), problem.n_points
        closed, sticks, self._slope, self._lean = self._coefficients
        self._rows = np.flatnonzero(np.concatenate([closed, sticks]))  # (k,) of the unknown tractions
        both = self._rows[: np.searchsorted(self._rows, n)]
        self._sliding = np.flatnonzero(active.slip[both])  # places in the rows of points that are closed and slide
        self._slides = both[self._sliding]
        self._least = SINGULAR if problem.n_motions else 0.0
        self._size = float(self.points.scale.mean()) if problem.n_motions else 1.0
        self._force = float(np.abs(self.points.force).max(initial=0.0)) or 1.0
        K = self._matrix()
        self.singular = False
        if len(K):
            norm = float(absolute_product(K, np.ones(len(K))).max())
            # LAPACK wants columns: the rows of K are those of its transpose
            self._lu, self._pivots, info = dgetrf(K.T, overwrite_a=1)
            self.singular = bool(info) or (self._least > 0.0 and dgecon(self._lu, norm, norm="1")[0] <= self._least)

    def are_of(self, problem: ContactProblem, active: ActiveSet) -> bool:
        """Whether they are those of an active set of a problem, whatever its loads."""
        pairs = zip(self._coefficients, _coefficients(problem, active), strict=True)
        return problem.points is self.points and all(np.array_equal(mine, its) for mine, its in pairs)

    def solution(self, problem: ContactProblem, active: ActiveSet) -> Floats:
        """All unknowns (2 n + l,) of an active set of a problem, whose equations they are."""
        n, shear = problem.n_points, active.slip * problem.cohesion
        jumps = problem.free - self.points.compliance[:, n:] @ shear
        jumps[:n] -= self._lean * problem.slipped
        right = self._of_rows(lambda rows: jumps[rows])
        if problem.n_motions:
            given = problem.pull - self.points.force[:, n:] @ shear
            right = np.append(right, given * (self._size / self._force))
        x, k, p = self._solved(right), len(self._rows), np.concatenate([np.zeros(n), shear])
        p[self._rows] = x[:k] / self._size
        return np.concatenate([self._with_shear(p), x[k:]])

    def _matrix(self) -> Floats:
        """K (k + l, k + l): jumps that unknown tractions take away, and motions add; what tractions do on motions."""
        jump = self.points.jump
        K, n_motions = self._of_rows(lambda some: self._per_unknown(self.points.compliance, some)), jump.shape[1]
        if not n_motions:
            return K
        k, whole = len(K), np.zeros((len(K) + n_motions,) * 2)
        np.divide(K, self._size, out=whole[:k, :k])
        whole[:k, k:] = -self._of_rows(lambda rows: jump[rows])
        whole[k:, :k] = self._per_unknown(self.points.force, np.arange(n_motions)) / self._force
        return whole

    def _solved(self, right: Floats) -> Floats:
        """x (k + l,) of K x = `right`."""
        if not right.size:
            return right
        if not self.singular:
            x = np.asarray(dgetrs(self._lu, self._pivots, right, trans=1)[0])
            if self._least:  # supports carry what the balance of pieces misses: all digits count
                x += dgetrs(self._lu, self._pivots, right - self._times(x), trans=1)[0]
            if np.isfinite(x).all():
                return x
        return np.asarray(np.linalg.lstsq(self._matrix(), right, rcond=LEAST_SQUARES if self._least else None)[0])

    def _times(self, x: Floats) -> Floats:
        """K x (k + l,)."""
        points, k, p = self.points, len(self._rows), np.zeros(len(self.points.scale))
        p[self._rows] = x[:k] / self._size
        jumps = points.compliance @ self._with_shear(p) - points.jump @ x[k:]
        return np.append(self._of_rows(lambda rows: jumps[rows]), points.force @ p * (self._size / self._force))

    def _with_shear(self, p: Floats) -> Floats:
        """Tractions (2 n,) with the shear that goes with pressure where points slip added to them, in place."""
        n = len(self._slope)
        p[n:] -= self._slope * p[:n]
        return p

    def _per_unknown(self, of: Floats, some: Ints) -> Floats:
        """(r, k) per unknown traction, with the shear that goes with pressure, of rows `some` (r,) per traction."""
        found = of[np.ix_(some, self._rows)]
        if len(self._sliding):
            found[:, self._sliding] -= of[np.ix_(some, len(self._slope) + self._slides)] * self._slope[self._slides]
        return found

    def _of_rows(self, of: Callable[[Ints], Floats]) -> Floats:
        """What `of` says of the unknown rows, with the part of the slip that dilation adds to gaps."""
        found, lean = of(self._rows), self._lean[self._slides]
        if lean.any():
            found[self._sliding] -= (lean * of(len(self._lean) + self._slides).T).T
        return found


def _coefficients(problem: ContactProblem, active: ActiveSet) -> tuple[Bools, Bools, Floats, Floats]:
    """Which points (n,) are closed, which stick; the slope of shear with pressure, and of gaps with their slip."""
    closed, slip = active.closed, active.slip
    slope = np.where(closed, slip * problem.friction, 0.0)
    return closed, slip == 0, slope, np.where(closed, problem.dilation * active.sense, 0.0)


def equations_of(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> ActiveEquations:
    """The equations of an active set, which may be those of `near`."""
    return near if near is not None and near.are_of(problem, active) else ActiveEquations(problem, active)


def solve_active(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set, which may be those of `near`.

    Its loose pieces are settled for it.
    """
    lying, unknowns = problem.settled()
    return unknowns(equations_of(lying, active, near).solution(lying, active))
