"""The equations of one active set of the contact problem, factorized.

They are solved for the tractions and motions that the set leaves unknown. Where contact alone holds pieces of rock the
balance of the tractions and the loads on them, F p = pull, is among these. The factors serve all loads.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import ActiveSet, Branches
from crackgrow.contact.problem import ContactProblem, absolute_product

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
        self.points, self.branches = problem.points, Branches(problem, active)
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

    def are_of(self, problem: ContactProblem, active: ActiveSet) -> bool:
        """Whether they are those of an active set of a problem, whatever its loads."""
        return problem.points is self.points and not self.branches.differ(Branches(problem, active)).any()

    def solution(self, problem: ContactProblem, active: ActiveSet) -> Floats:
        """All unknowns (2 n + l,) of an active set of a problem, whose equations they are."""
        branches, shear = self.branches, active.slip * problem.cohesion
        right = branches.right(problem, shear)
        if problem.n_motions:
            given = problem.pull - self.points.force[:, len(shear) :] @ shear
            right = np.append(right, given * (self._size / self._force))
        x, k = self._solved(right), len(branches.rows)
        return np.concatenate([branches.tractions(x[:k] / self._size, shear), x[k:]])

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
        points, branches, k = self.points, self.branches, len(self.branches.rows)
        p = np.zeros(len(points.scale))
        p[branches.rows] = x[:k] / self._size
        jumps = points.compliance @ branches.with_shear(p) - points.jump @ x[k:]
        return np.concatenate(
            [branches.of_rows(lambda rows: jumps[rows]), points.force @ p * (self._size / self._force)]
        )


def equations_of(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> ActiveEquations:
    """The equations of an active set, which may be those of `near`."""
    return near if near is not None and near.are_of(problem, active) else ActiveEquations(problem, active)


def solve_active(problem: ContactProblem, active: ActiveSet, near: ActiveEquations | None = None) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set, which may be those of `near`."""
    return equations_of(problem, active, near).solution(problem, active)
