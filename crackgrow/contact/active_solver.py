"""The linear solves of the contact problem: tractions under the equations of one active set after another.

Unknown are p_n of closed and p_t of sticking points, whose jumps vanish; elsewhere p_n = 0 and p_t = slip (cohesion -
friction p_n). Written for all rows M p = r, two active sets differ in the rows D of few points, so that with the
factors of the one before the next costs no factorization but a correction of rank |D| (Sherman, Morrison, Woodbury):

    M' = M + E_D (M'_D - M_D),    M'^-1 r = y - Z (M'_D Z)^-1 (M'_D y - r_D),    y = M^-1 r,    Z = M^-1 E_D.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from crackgrow.contact.coulomb import ActiveSet, Bools, ContactProblem, Floats, Ints

FEW_ROWS: Final = 100
"""Up to so many unknown rows a factorization costs less than what goes with corrections ..."""

FEW_OF_ALL: Final = 1 / 3
"""... and so it does up to this part of all rows, which corrections multiply by."""

MOST_CHANGED: Final = 0.2
"""Part of the unknown rows: where more change the equations are factorized anew."""

CORRECTIONS: Final = 2
"""The second one takes away the round-off of the first."""

ROUND_OFF: Final = 1e-13
"""Of the terms of a row: what a corrected solution may leave; else the equations are factorized."""


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """(m,) Pa: tractions with the equations of one active set.

    A singular system (rigid contact, more points than the displacement can follow) gets its least-squares solution.
    """
    return ActiveSolver(problem).solve(active)


@dataclass(frozen=True, slots=True, eq=False)
class _Equations:
    """The rows of an active set: A p = free where the traction is unknown, p_n = 0 or p_t + slope p_n = limit else."""

    unknown: Bools  # (m,)
    slope: Floats  # (n,) slip times friction; (0,) without tangential rows
    limit: Floats  # (n,) Pa, slip times cohesion; (0,) without tangential rows

    @classmethod
    def of(cls, problem: ContactProblem, active: ActiveSet) -> _Equations:
        """The equations of a set."""
        if problem.friction is None or problem.cohesion is None:
            return cls(active.closed, np.empty(0), np.empty(0))
        unknown = np.concatenate([active.closed, active.slip == 0])
        return cls(unknown, active.slip * problem.friction, active.slip * problem.cohesion)

    def right(self, problem: ContactProblem) -> Floats:
        """(m,) the right-hand sides of all rows."""
        return np.where(self.unknown, problem.free, np.append(np.zeros(problem.n_points), self.limit))

    def matrix(self, A: Floats, rows: Ints) -> Floats:
        """(k, k) of the unknown rows alone, the others eliminated."""
        K = A.take(rows, axis=0).take(rows, axis=1)
        if len(self.slope):
            n = len(self.slope)
            closed = rows[: np.searchsorted(rows, n)]
            sliding = np.flatnonzero(self.slope[closed])  # columns of K
            points = closed[sliding]
            K[:, sliding] -= A[np.ix_(rows, n + points)] * self.slope[points]
        return K

    def rows_of(self, p: Floats, rows: Ints | slice, Ap: Floats) -> Floats:
        """The left-hand sides of some `rows` for tractions p (m,) or (m, k), with those rows of A p."""
        tied = p.copy()
        tied[len(p) - len(self.slope) :] += (self.slope * p[: len(self.slope)].T).T
        return np.asarray(np.where(self.unknown[rows], Ap.T, tied[rows].T).T)

    def slide(self, p: Floats, right: Floats) -> None:
        """Set p_t (m,) or (m, k) where it is not unknown from p_n and the right-hand sides."""
        if len(self.slope):
            n = len(self.slope)
            known = np.flatnonzero(~self.unknown[n:])
            p[n + known] = right[n + known] - (self.slope[known] * p[known].T).T

    def changed(self, other: _Equations) -> Ints:
        """The rows (k,) that are others there."""
        n = len(self.unknown) - len(self.slope)
        changed = self.unknown != other.unknown
        changed[n:] |= ~self.unknown[n:] & (self.slope != other.slope)
        return np.flatnonzero(changed)


class ActiveSolver:
    """Solves the equations of active sets of one problem, with the factors of an earlier set where they are of use."""

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem
        self._factors: tuple[Floats, Ints] | None = None
        self._factorized = _Equations(np.empty(0, dtype=bool), np.empty(0), np.empty(0))
        self._rows = np.empty(0, dtype=np.int64)  # unknown ones of the set that was factorized
        self._responses: dict[int, Floats] = {}  # columns (m,) of Z
        self._last = np.empty(0)

    def solve(self, active: ActiveSet) -> Floats:
        """(m,) Pa: tractions with the equations of one active set, the least-squares ones where they are singular."""
        equations = _Equations.of(self._problem, active)
        p = self._corrected(equations) if self._factors is not None else None
        self._last = self._direct(equations) if p is None else p
        return self._last.copy()

    def _direct(self, equations: _Equations) -> Floats:
        """Tractions by a factorization."""
        A, rows = self._problem.compliance, np.flatnonzero(equations.unknown)
        p, right = np.zeros(len(A)), equations.right(self._problem)
        equations.slide(p, right)
        right_of_K = right[rows] - (A @ p)[rows]
        factors = _factors(equations.matrix(A, rows))
        p[rows] = _by(factors, right_of_K) if factors is not None else np.nan
        if not np.isfinite(p[rows]).all():
            factors, p[rows] = None, np.linalg.lstsq(equations.matrix(A, rows), right_of_K)[0]
        equations.slide(p, right)
        keep = factors if len(rows) > max(FEW_ROWS, FEW_OF_ALL * len(A)) else None
        self._factors, self._factorized, self._rows, self._responses = keep, equations, rows, {}
        return p

    def _corrected(self, equations: _Equations) -> Floats | None:
        """Tractions by the factors of an earlier set, None where too much has changed or round-off is left."""
        problem = self._problem
        changed = equations.changed(self._factorized)
        if len(changed) > MOST_CHANGED * len(self._rows):
            return None
        p, Z, A = self._last, self._responses_to(changed), problem.compliance[changed]
        between = _factors(equations.rows_of(Z, changed, A @ Z))
        if between is None:
            return None
        for _ in range(CORRECTIONS):
            residual = equations.right(problem) - equations.rows_of(p, slice(None), problem.compliance @ p)
            y = self._by_factors(residual)
            p = p + y - Z @ _by(between, equations.rows_of(y, changed, A @ y) - residual[changed])
        p[: problem.n_points][~equations.unknown[: problem.n_points]] = 0.0
        left = np.abs(equations.right(problem) - equations.rows_of(p, slice(None), problem.compliance @ p))
        terms = problem.reach * np.abs(p).max() + np.abs(problem.free)
        return p if np.all(left[equations.unknown] <= ROUND_OFF * terms[equations.unknown]) else None

    def _responses_to(self, rows: Ints) -> Floats:
        """Z (m, k): tractions with the equations that were factorized and right-hand sides of one in the rows (k,)."""
        new = [row for row in rows.tolist() if row not in self._responses]
        if new:
            ones = np.zeros((len(self._problem.free), len(new)))
            ones[new, np.arange(len(new))] = 1.0
            self._responses.update(zip(new, self._by_factors(ones).T, strict=True))
        found = [self._responses[row] for row in rows.tolist()]
        return np.stack(found, axis=1) if found else np.zeros((len(self._problem.free), 0))

    def _by_factors(self, right: Floats) -> Floats:
        """M^-1 times `right` (m,) or (m, k), of the equations that were factorized."""
        assert self._factors is not None
        equations, rows = self._factorized, self._rows
        y = right.copy()
        y[rows] = 0.0
        equations.slide(y, right)
        given = np.flatnonzero(y.any(axis=1) if y.ndim == 2 else y)
        y[rows] = _by(self._factors, right[rows] - (self._problem.compliance.take(given, axis=1) @ y[given])[rows])
        equations.slide(y, right)
        return y


def _factors(K: Floats) -> tuple[Floats, Ints] | None:
    """LU factors of the transpose of K (k, k), which is overwritten; None where it is singular."""
    if not K.size:
        return K, np.empty(0, dtype=np.int64)
    lu, pivots, info = dgetrf(K.T, overwrite_a=True)  # LAPACK wants columns: the rows of K are those of its transpose
    return None if info else (lu, pivots)


def _by(factors: tuple[Floats, Ints], right: Floats) -> Floats:
    """Solution (k,) or (k, l) of K x = `right`."""
    if not right.size:
        return right
    return np.asarray(dgetrs(*factors, right, trans=1)[0])
