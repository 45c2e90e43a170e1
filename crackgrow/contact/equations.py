"""The equations of one active set of the contact problem, factorized.

They are solved for the tractions and motions that the set leaves unknown. Where contact alone holds pieces of rock the
balance of the tractions and the loads on them, F p = pull, is among these.
"""

from __future__ import annotations

from functools import cached_property
from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.coulomb import ActiveSet, Branches
from crackgrow.contact.problem import ContactProblem, absolute_product

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


class ActiveEquations:
    """The equations of one active set. Singular ones have least-squares solutions.

    They are singular where contact is rigid at more points than the displacement can follow, or no closed point sees a
    motion.
    """

    def __init__(self, problem: ContactProblem, active: ActiveSet) -> None:
        self.problem, self.active, self.branches = problem, active, Branches(problem, active)
        self._least = 0.0 if problem.motions is None else SINGULAR
        self._size = float(problem.scale.mean()) if problem.n_motions else 1.0
        self._force = 1.0 if problem.motions is None else float(np.abs(problem.motions.force).max()) or 1.0
        self._derivatives: dict[int, Floats] = {}  # by the row whose residual it is
        K = self._matrix()
        self._largest, self.singular = float(np.abs(K).max(initial=0.0)), False
        if len(K):
            norm = float(absolute_product(K, np.ones(len(K))).max())
            # LAPACK wants columns: the rows of K are those of its transpose
            self._lu, self._pivots, info = dgetrf(K.T, overwrite_a=1)
            self.singular = bool(info) or (self._least > 0.0 and dgecon(self._lu, norm, norm="1")[0] <= self._least)

    def _matrix(self) -> Floats:
        """K (k + l, k + l), of unknown tractions and motions."""
        branches, motions = self.branches, self.problem.motions
        K = branches.matrix()
        if motions is None:
            return K
        k, whole = len(K), np.zeros((len(K) + len(motions.pull),) * 2)
        np.divide(K, self._size, out=whole[:k, :k])
        whole[:k, k:] = -branches.of_motions(motions.jump)
        whole[k:, :k] = branches.per_unknown(motions.force, np.arange(len(motions.pull))) / self._force
        return whole

    @cached_property
    def _jump(self) -> Floats:
        """(2 n,) m of the solution."""
        return self.problem.jump(self.solution)

    @cached_property
    def solution(self) -> Floats:
        """All unknowns (2 n + l,)."""
        problem, branches, right = self.problem, self.branches, self.branches.right()
        if problem.motions is not None:
            given = problem.motions.pull - problem.motions.force @ branches.known()
            right = np.append(right, given * (self._size / self._force))
        x = self._solved(right)
        return np.concatenate([branches.tractions(x[: len(branches.rows)] / self._size), x[len(branches.rows) :]])

    def updated(self, active: ActiveSet, most: float) -> Floats | None:
        """All unknowns (2 n + l,) with the equations of another active set, by a low-rank update of the factors.

        None where more than a share `most` of the points have other equations, and where those here are singular.
        With residuals r of these points S the unknowns are x + P r: r is such that S fulfil the other equations
        (Sherman, Morrison, Woodbury; Golub, Van Loan, equation (2.1.4)).
        """
        problem, n, m = self.problem, self.problem.n_points, self.problem.free.size
        moving = self.active.differs(active, problem)
        if not moving.any():
            return self.solution
        if self.singular or moving.mean() > most:
            return None
        S = np.flatnonzero(moving)
        x, P = self.solution, self._sensitivity(np.concatenate([S, n + S]))
        p, du = [np.column_stack([x[k], P[k]]) for k in (S, n + S)], []
        for rows in (S, n + S):
            per = -problem.compliance[rows] @ P[:m]
            if problem.motions is not None:
                per += problem.motions.jump[rows] @ P[m:]
            du.append(np.column_stack([self._jump[rows], per]))
        law = (active.slip, problem.friction, problem.cohesion, problem.dilation * active.sense, problem.slipped)
        slip, friction, cohesion, lean, slipped = (of[S, None] for of in law)
        gap, shear = du[0] - lean * du[1], p[1] + slip * friction * p[0]
        gap[:, :1] -= lean * slipped
        shear[:, :1] -= slip * cohesion
        scale = problem.scale[:, None]
        across = np.where(active.closed[S, None], gap / scale[S], p[0])
        along = np.where(slip == 0, du[1] / scale[n + S], shear)
        left = np.vstack([across, along])
        try:
            x = x - P @ np.linalg.solve(left[:, 1:], left[:, 0])
        except np.linalg.LinAlgError:
            return None
        branches = Branches(problem, active)  # what they leave known is known to the bit
        return np.concatenate([branches.tractions(x[branches.rows]), x[m:]])

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
        problem, branches, k = self.problem, self.branches, np.arange(len(at))
        place = np.minimum(np.searchsorted(branches.rows, at), max(len(branches.rows) - 1, 0))
        unknown = branches.rows[place] == at if len(branches.rows) else np.zeros(len(at), dtype=bool)
        given = np.zeros((problem.free.size, len(at)))
        given[at[~unknown], k[~unknown]] = 1.0
        given = branches.with_shear(given)
        some = np.flatnonzero(given.any(axis=1))
        right = -branches.of_rows(lambda rows: problem.compliance[np.ix_(rows, some)] @ given[some])
        right[place[unknown], k[unknown]] += problem.scale[at[unknown]]
        if problem.motions is not None:
            right = np.vstack([right, -problem.motions.force @ given * (self._size / self._force)])
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
        problem, branches, k = self.problem, self.branches, len(self.branches.rows)
        p = np.zeros((problem.free.size, *x.shape[1:]))
        p[branches.rows] = x[:k] / self._size
        jumps = problem.compliance @ branches.with_shear(p)
        if problem.motions is None:
            return branches.of_rows(lambda rows: jumps[rows])
        jumps -= problem.motions.jump @ x[k:]
        balance = problem.motions.force @ p * (self._size / self._force)
        return np.concatenate([branches.of_rows(lambda rows: jumps[rows]), balance])


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set."""
    return ActiveEquations(problem, active).solution
