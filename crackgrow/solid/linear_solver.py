"""The linear solve behind one interface: a symmetric positive definite matrix with a few linear constraints.

K u + C' m = f, C u = g. With constraints K alone may be singular, so K0 = K + C' rho C is factorized (the constraints
add the same amount to both sides, the answer does not depend on rho) and the few multipliers m are found from the
Schur complement C K0^-1 C'.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from crackgrow.errors import SolveError

Floats = NDArray[np.float64]

DEPENDENT = 1e-12
"""Constraints whose part of the Schur complement is smaller than this repeat others."""

INCONSISTENT = 1e-6
"""Repeated constraints that contradict each other by more than this fraction of the displacements are refused."""


def displacement_size(loads: Floats, u: Floats, given: Floats) -> float:
    """Size of a displacement field, m: the mean displacement along the loads, or the largest prescribed one.

    The coefficients u themselves can be far larger where tip functions nearly depend on each other.
    """
    total = np.abs(loads).sum()
    along_loads = float(abs(loads @ u) / total) if total > 0.0 else 0.0
    return max(along_loads, float(np.abs(given).max(initial=0.0)))


class Factorization:
    """A factorized symmetric positive definite matrix, scaled to a unit diagonal."""

    def __init__(self, matrix: csc_array) -> None:
        """Factorize `matrix` (n, n); raises SolveError where it is not finite, or singular in an obvious way."""
        diagonal = matrix.diagonal()
        if not np.isfinite(matrix.data).all():
            raise SolveError("the stiffness matrix has entries that are not finite")
        if not np.all(diagonal > 0.0):
            raise SolveError(f"{np.sum(diagonal <= 0.0)} of {len(diagonal)} unknowns have no stiffness")
        self.matrix = matrix
        self._scale = 1.0 / np.sqrt(diagonal)
        scaling = diags_array(self._scale)
        scaled = csc_array(scaling @ matrix @ scaling)
        try:
            self._lu = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SolveError(f"the stiffness matrix is singular ({error}): is a body free to move?") from error

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`, one refinement step included."""
        solution = self._solve(right)
        return solution + self._solve(right - self.matrix @ solution)

    def _solve(self, right: Floats) -> Floats:
        scale = self._scale if right.ndim == 1 else self._scale[:, None]
        return np.asarray(scale * self._lu.solve(scale * right))


class ConstrainedSystem:
    """K with constraints C u = g, factorized once for many loads."""

    def __init__(self, stiffness: csc_array, constraints: csr_array) -> None:
        """`stiffness` (n, n) Pa, `constraints` (m, n)."""
        self.stiffness = stiffness
        self.constraints = constraints
        share = abs(constraints)
        total = np.maximum(share.sum(axis=1), np.finfo(float).tiny)
        rho = share @ stiffness.diagonal() / total  # row by row, of the size of the entries it meets
        self._penalty = csr_array(diags_array(rho) @ constraints)
        self._rho = rho
        augmented = csc_array(stiffness + constraints.T @ self._penalty)
        self.factorization = Factorization(augmented)
        self._flexible = self.factorization.solve(constraints.T.toarray())  # K0^-1 C'
        schur = constraints @ self._flexible
        values, vectors = np.linalg.eigh(0.5 * (schur + schur.T)) if len(schur) else (np.empty(0), np.empty((0, 0)))
        independent = values > DEPENDENT * values.max(initial=0.0)
        self._independent = vectors[:, independent]
        self._inverse_values = 1.0 / values[independent]

    def solve(self, loads: Floats, given: Floats | None = None) -> tuple[Floats, Floats]:
        """Displacements (n,) or (n, k) and multipliers (m,) or (m, k) for loads (n,) or (n, k).

        `given` (m,) are the prescribed values g, zero if None. Raises SolveError where constraints contradict.
        """
        right = loads if given is None else loads + self._penalty.T @ given
        u = self.factorization.solve(right)
        missing = self.constraints @ u - (0.0 if given is None else given)
        in_basis = self._independent.T @ missing
        scaled = (self._inverse_values * in_basis.T).T
        multipliers = self._independent @ scaled
        u = u - self._flexible @ multipliers
        if given is not None:
            left = self.constraints @ u - given
            size = displacement_size(loads, u, given)
            if np.abs(left).max(initial=0.0) > INCONSISTENT * size:
                raise SolveError(f"the supports contradict each other by {np.abs(left).max():.3g} m")
            multipliers = multipliers - self._rho * left  # what the penalty carries
        return u, multipliers
