"""The linear solve behind one interface: a symmetric positive definite matrix with a few linear constraints.

K u + C' m = f, C u = g. With constraints K alone may be singular, so K0 = K + C' rho C takes its place (the constraints
add the same amount to both sides, the answer does not depend on rho). The matrix [[K0, C'], [C, -d]] with a small d is
quasi-definite: it has a symmetric factorization without pivoting in any order (Vanderbei 1995), also where constraints
repeat each other. Refinement with d = 0 takes the effect of d away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from crackgrow.errors import SolveError

Floats = NDArray[np.float64]

YIELDING = 1e-7
"""d times rho: constraints give way by this fraction, which each refinement takes away again."""

REFINEMENTS = 3
"""Solves of which each reduces the error of the one before by `YIELDING` and round-off."""

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
    """A factorized symmetric matrix, definite or quasi-definite, scaled to a diagonal of plus or minus one."""

    def __init__(self, matrix: csc_array) -> None:
        """Factorize `matrix` (n, n); raises SolveError where it is not finite, or singular in an obvious way."""
        diagonal = matrix.diagonal()
        if not np.isfinite(matrix.data).all():
            raise SolveError("the stiffness matrix has entries that are not finite")
        if not np.all(diagonal != 0.0):
            raise SolveError(f"{np.sum(diagonal == 0.0)} of {len(diagonal)} unknowns have no stiffness")
        self._scale = 1.0 / np.sqrt(np.abs(diagonal))
        scaling = diags_array(self._scale)
        scaled = csc_array(scaling @ matrix @ scaling)
        try:
            self._lu = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise SolveError(f"the stiffness matrix is singular ({error}): is a body free to move?") from error

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`, unrefined."""
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
        self._rho = share @ stiffness.diagonal() / total  # row by row, of the size of the entries it meets
        held = csc_array(stiffness + constraints.T @ diags_array(self._rho) @ constraints)
        if len(self._rho):
            yielding = diags_array(-YIELDING / self._rho)
            held = csc_array(block_array([[held, constraints.T], [constraints, yielding]], format="csc"))
        self._factorization = Factorization(held)

    def solve(self, loads: Floats, given: Floats | None = None) -> tuple[Floats, Floats]:
        """Displacements (n,) or (n, k) and multipliers (m,) or (m, k) for loads (n,) or (n, k).

        `given` (m,) are the prescribed values g, zero if None. Raises SolveError where constraints contradict.
        """
        n, m = self.constraints.shape[1], self.constraints.shape[0]
        wanted = np.zeros((m, *loads.shape[1:])) if given is None else given
        if m == 0:
            u = self._factorization.solve(loads)
            return u + self._factorization.solve(loads - self.stiffness @ u), np.zeros_like(wanted)
        u, multipliers = np.zeros(loads.shape), np.zeros((m, *loads.shape[1:]))
        for _ in range(REFINEMENTS):
            missing = wanted - self.constraints @ u
            force = loads - self.stiffness @ u - self.constraints.T @ multipliers
            pushed = force + self.constraints.T @ (self._rho * missing.T).T
            step = self._factorization.solve(np.concatenate([pushed, missing]))
            u, multipliers = u + step[:n], multipliers + step[n:]
        if given is not None:
            left = np.abs(self.constraints @ u - given).max()
            if left > INCONSISTENT * displacement_size(loads, u, given):
                raise SolveError(f"the supports contradict each other by {left:.3g} m")
        return u, multipliers
