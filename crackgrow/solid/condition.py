"""How well conditioned a system is: for studies, a run does not need it.

The condition number of the stiffness K scaled to a unit diagonal, D^-1/2 K D^-1/2, on the displacements that the
constraints C u = 0 leave: the ratio of the ends of the spectrum of K u + C' m = lambda D u. Lanczos finds both ends,
the largest from products with K, the smallest from solves with the factorization that there is (Golub, Van Loan,
Matrix Computations, 10.1).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import LinearOperator, eigsh

from crackgrow.solid.linear_solver import ConstrainedSystem

Floats = NDArray[np.float64]

RELATIVE_ERROR = 1e-2
"""Of the ends of the spectrum: a condition number is wanted to its first digit."""


def condition_estimate(system: ConstrainedSystem) -> float:
    """Condition number of the scaled stiffness under the constraints, to a few percent.

    Where it is beyond the reciprocal of round-off, all that can be said is that it is.
    """
    scale = 1.0 / np.sqrt(system.stiffness.diagonal())
    scaled = csc_array(diags_array(scale) @ system.stiffness @ diags_array(scale))
    largest = _largest(LinearOperator(scaled.shape, matvec=scaled.__matmul__, dtype=np.float64))
    return largest * _largest(_inverse(system, scale))


def weakest_mode(system: ConstrainedSystem) -> tuple[float, Floats]:
    """The smallest eigenvalue of the scaled stiffness under the constraints, and its mode u (n_dofs,)."""
    scale = 1.0 / np.sqrt(system.stiffness.diagonal())
    values, vectors = _end_of_spectrum(_inverse(system, scale))
    return 1.0 / float(values[0]), scale * vectors[:, 0]


def _inverse(system: ConstrainedSystem, scale: Floats) -> LinearOperator:
    """D^1/2 G D^1/2, with u = G f the displacements under loads f that the constraints leave."""
    n = len(scale)
    return LinearOperator((n, n), matvec=lambda v: system.solve(v.ravel() / scale)[0] / scale, dtype=np.float64)


def _largest(operator: LinearOperator) -> float:
    return float(_end_of_spectrum(operator)[0][0])


def _end_of_spectrum(operator: LinearOperator) -> tuple[Floats, Floats]:
    """The largest eigenvalue (1,) of a positive semidefinite operator, and its vector (n, 1)."""
    start = np.random.default_rng(0).normal(size=operator.shape[0])
    values, vectors = eigsh(operator, k=1, which="LA", tol=RELATIVE_ERROR, v0=start)
    return np.asarray(values), np.asarray(vectors)
