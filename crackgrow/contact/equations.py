"""The equations of one active set of the contact problem, factorized.

They are solved for the tractions and motions that the set leaves unknown. Where contact alone holds pieces of rock the
balance of the tractions and the loads on them, F p = pull, is among these. The factors serve all loads, and active sets
that differ at a few points.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import ActiveSet, Branches
from crackgrow.contact.problem import ContactProblem, absolute_product

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

FEW: Final = 0.1
"""Share of the points: where so few have other equations an update costs less than factors anew."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


class ActiveEquations:
    """The factorized equations of one active set, of points on rock. Singular ones have least-squares solutions.

    They are singular where contact is rigid at more points than the displacement can follow, or no closed point sees a
    motion.
    """

    def __init__(self, problem: ContactProblem, active: ActiveSet) -> None:
        self.points, self.branches = problem.points, Branches(problem, active)
        self._least = SINGULAR if problem.n_motions else 0.0
        self._size = float(self.points.scale.mean()) if problem.n_motions else 1.0
        self._force = float(np.abs(self.points.force).max(initial=0.0)) or 1.0
        self._derivatives: dict[int, Floats] = {}  # by the row whose residual it is
        K = self._matrix()
        self.singular = False
        if len(K):
            norm = float(absolute_product(K, np.ones(len(K))).max())
            # LAPACK wants columns: the rows of K are those of its transpose
            self._lu, self._pivots, info = dgetrf(K.T, overwrite_a=1)
            self.singular = bool(info) or (self._least > 0.0 and dgecon(self._lu, norm, norm="1")[0] <= self._least)

    def _matrix(self) -> Floats:
        """K (k + l, k + l), of unknown tractions and motions."""
        branches, jump = self.branches, self.points.jump
        K, n_motions = branches.matrix(), jump.shape[1]
        if not n_motions:
            return K
        k, whole = len(K), np.zeros((len(K) + n_motions,) * 2)
        np.divide(K, self._size, out=whole[:k, :k])
        whole[:k, k:] = -branches.of_rows(lambda rows: jump[rows])
        whole[k:, :k] = branches.per_unknown(self.points.force, np.arange(n_motions)) / self._force
        return whole

    def solution(self, problem: ContactProblem, active: ActiveSet, most: float = 1.0) -> Floats | None:
        """All unknowns (2 n + l,) of a problem of these points on other branches, by a low-rank update of the factors.

        None where more than a share `most` of the points have other equations, and where those here are singular.
        With residuals r of these points S the unknowns are x + P r: r is such that S fulfil the other equations
        (Sherman, Morrison, Woodbury; Golub, Van Loan, equation (2.1.4)).
        """
        if problem.points is not self.points:
            return None
        branches = Branches(problem, active)
        moving, n, m = self.branches.differ(branches), problem.n_points, problem.free.size
        if moving.any() and (self.singular or moving.mean() > most):
            return None
        x = self._unmoved(problem, np.where(self.branches.sticks, 0.0, branches.shear))
        if not moving.any():
            return x
        S = np.flatnonzero(moving)
        both = np.column_stack([x, self._sensitivity(np.concatenate([S, n + S]))])
        p, du = [both[k] for k in (S, n + S)], []
        for rows in (S, n + S):
            jump = self.points.jump[rows] @ both[m:] - self.points.compliance[rows] @ both[:m]
            jump[:, 0] += problem.free[rows]
            du.append(jump)
        slope, lean = branches.slope[S, None], branches.lean[S, None]
        gap, shear = du[0] - lean * du[1], p[1] + slope * p[0]
        gap[:, 0] -= (branches.lean * problem.slipped)[S]
        shear[:, 0] -= branches.shear[S]
        scale = self.points.scale[:, None]
        across = np.where(branches.closed[S, None], gap / scale[S], p[0])
        along = np.where(branches.sticks[S, None], du[1] / scale[n + S], shear)
        left = np.vstack([across, along])
        try:
            x = x - both[:, 1:] @ np.linalg.solve(left[:, 1:], left[:, 0])
        except np.linalg.LinAlgError:
            return None
        # what the branches leave known is known to the bit
        return np.concatenate([branches.tractions(x[branches.rows], branches.shear), x[m:]])

    def _unmoved(self, problem: ContactProblem, shear: Floats) -> Floats:
        """The unknowns (2 n + l,) of a problem on the branches here, with shear (n,) Pa that is given."""
        branches, right = self.branches, self.branches.right(problem, shear)
        if problem.n_motions:
            given = problem.pull - self.points.force[:, len(shear) :] @ shear
            right = np.append(right, given * (self._size / self._force))
        x, k = self._solved(right), len(branches.rows)
        return np.concatenate([branches.tractions(x[:k] / self._size, shear), x[k:]])

    def _sensitivity(self, at: Ints) -> Floats:
        """The derivatives (2 n + l, k) of all unknowns by the residuals of the equations of rows `at` (k,).

        A residual of one is a traction of a unit, or the jump that this makes at its point.
        """
        new = np.array([row for row in at.tolist() if row not in self._derivatives], dtype=np.int64)
        if len(new):
            self._derivatives.update(zip(new.tolist(), self._derived(new).T, strict=True))
        return np.stack([self._derivatives[row] for row in at.tolist()], axis=1)

    def _derived(self, at: Ints) -> Floats:
        """The same, of rows that are not known yet."""
        points, branches, k = self.points, self.branches, np.arange(len(at))
        place = np.minimum(np.searchsorted(branches.rows, at), max(len(branches.rows) - 1, 0))
        unknown = branches.rows[place] == at if len(branches.rows) else np.zeros(len(at), dtype=bool)
        given = np.zeros((len(points.scale), len(at)))
        given[at[~unknown], k[~unknown]] = 1.0
        given = branches.with_shear(given)
        some = np.flatnonzero(given.any(axis=1))
        right = -branches.of_rows(lambda rows: points.compliance[np.ix_(rows, some)] @ given[some])
        right[place[unknown], k[unknown]] += points.scale[at[unknown]]
        right = np.vstack([right, -points.force @ given * (self._size / self._force)])
        x, rows = self._solved(right), branches.rows
        tractions = np.zeros_like(given)
        tractions[rows] = x[: len(rows)] / self._size
        return np.vstack([given + branches.with_shear(tractions), x[len(rows) :]])

    def _solved(self, right: Floats) -> Floats:
        """x of K x = `right`, of one column or some."""
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
        """K x, of one column or some."""
        points, branches, k = self.points, self.branches, len(self.branches.rows)
        p = np.zeros((len(points.scale), *x.shape[1:]))
        p[branches.rows] = x[:k] / self._size
        jumps = points.compliance @ branches.with_shear(p) - points.jump @ x[k:]
        return np.concatenate(
            [branches.of_rows(lambda rows: jumps[rows]), points.force @ p * (self._size / self._force)]
        )


def solve_active(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set; `near` are some that may be close."""
    x = None if near is None else near.solution(problem, active, FEW)
    if x is None:
        x = ActiveEquations(problem, active).solution(problem, active)
    assert x is not None  # of its own branches
    return x
