"""Estimate of the condition number of a constrained system, from its factorization.

With K scaled to a diagonal of one, K^ = D K D, D = diag(K)^-1/2, the constraints C u = 0 leave the displacements
u = D y with C D y = 0. On these K^ has the condition number

    cond = lambda_max(K^) / lambda_min(K^ on C D y = 0),

which neither units, nor the size of patches, nor the multipliers' scale enters. The solution operator of the system,
scaled the same way, is the inverse of K^ on that space and zero across it, so that its largest eigenvalue is
1 / lambda_min. Lanczos' method finds both from products and solves alone (Golub, Van Loan: Matrix Computations, 10.1;
scipy's ARPACK). lambda_max is that without constraints, an upper bound: few constraints change it little.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from crackgrow.arrays import Floats
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem

ACCURACY = 1e-2
"""Relative accuracy of the extreme eigenvalues: the order of magnitude is what is asked for."""

SMALL = 12
"""Systems with fewer unknowns are found densely: Lanczos' method needs room."""


def condition_estimate(system: ConstrainedSystem) -> float:
    """Condition number of the diagonally scaled stiffness on the displacements that satisfy the constraints.

    Beyond about 1 / round-off, 1e16, it is no more than a sign that the matrix is singular as far as can be told.
    Raises SolveError where Lanczos' method finds no extreme eigenvalue.
    """
    size = np.sqrt(system.stiffness.diagonal())
    if not np.all(size > 0.0):
        raise SolveError("unknowns without stiffness have no condition number")

    def scaled(y: Floats) -> Floats:
        y = y.ravel()
        return np.asarray((system.stiffness @ (y / size)) / size)

    def solved(x: Floats) -> Floats:
        return np.asarray(size * system.solve(size * x.ravel())[0])

    return _largest(scaled, len(size)) * _largest(solved, len(size))


def _largest(product: Callable[[Floats], Floats], n: int) -> float:
    """Largest absolute eigenvalue of a symmetric operator on vectors (n,)."""
    if n < SMALL:
        return float(np.abs(np.linalg.eigvalsh(np.array([product(row) for row in np.eye(n)]))).max())
    operator = LinearOperator((n, n), matvec=product, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(n)
    try:
        values = eigsh(operator, k=1, which="LM", v0=start, tol=ACCURACY, return_eigenvectors=False)
    except ArpackNoConvergence as error:
        raise SolveError(f"the condition number could not be estimated: {error}") from error
    return float(np.abs(values[0]))
