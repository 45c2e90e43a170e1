"""The door of the direct solver: factorize K, held by constraints C u = g, once for many loads.

With constraints K alone may be singular, so K0 = K + C' rho C takes its place (the constraints add the same amount to
both sides, the answer does not depend on rho). The matrix [[K0, C'], [C, -d]] with a small d is quasi-definite: it has
a symmetric factorization without pivoting in any order (Vanderbei 1995), also where constraints repeat each other. What
C u then misses of g, as a right-hand side of its own, takes the effect of d away.

Constraints that act further than the couplings of K reach have no rho: it would couple all that they act on. Their
multipliers are eliminated after a part of that and before the rest of it, and so stiffen the rest.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array

from crackgrow.arrays import Floats
from crackgrow.direct.dissection import Places
from crackgrow.direct.fronts import fronts_of
from crackgrow.direct.matrix import SymmetricMatrix, bordered
from crackgrow.direct.multifrontal import NOTHING, Kept, Multifrontal
from crackgrow.direct.panels import lower_panels
from crackgrow.errors import SolveError

YIELDING = 1e-7
"""d times the stiffness that a constraint meets: constraints give way by this fraction."""

HARDENINGS = 2
"""Most corrections, each of which reduces what constraints have given way by `YIELDING`."""

SMALLEST = float(np.finfo(float).eps)
"""What constraints give way by less than this fraction is round-off."""

FEW_CONSTRAINTS = 16
"""Up to so many constraints the responses to all of them cost less than the solves that they save."""

MANY = 8
"""Constraints per row from which elimination of all costs more than solves for the rows."""


class Factorization:
    """A factorized matrix K (n, n) with constraints C (m, n)."""

    def __init__(self, fronts: Multifrontal, constraints: csr_array, rho: Floats, yielding: Floats) -> None:
        """`fronts` of the quasi-definite matrix (n + m, n + m), `rho` (m,) and `yielding` d (m,)."""
        self._fronts, self._constraints = fronts, constraints
        self._rho, self._yielding = rho, yielding
        self._share = abs(constraints)
        self._responses: Floats | None = None  # (n + m, m) to unit pulls at the constraints, found when they pay

    @property
    def kept(self) -> Kept:
        """What another factorization may have in common with this one."""
        return self._fronts.kept

    def hand_over(self) -> None:
        """Solve no more: the factorization that comes next is the last to need what is kept."""
        self._fronts.hand_over()
        self._responses = None

    def solve(self, loads: Floats, wanted: Floats, with_pulls: bool = False) -> tuple[Floats, Floats]:
        """Displacements (n, k) and multipliers (m, k) for loads (n, k) with C u = `wanted` (m, k), unrefined.

        `with_pulls` finds the responses to unit pulls along with them, if they pay: factors are read once for both.
        """
        (n, k), m = loads.shape, len(wanted)
        if m == 0:
            return self._fronts.solve(loads), wanted
        push = loads + self._constraints.T @ (self._rho[:, None] * wanted)
        right, few = np.concatenate([push, wanted]), m <= max(FEW_CONSTRAINTS, k)
        if with_pulls and few and self._responses is None:
            both = self._fronts.solve(np.column_stack([right, self._pulls(np.eye(m))]))
            solution, self._responses = (np.ascontiguousarray(some) for some in np.split(both, [k], axis=1))
        else:
            solution = self._fronts.solve(right)
        responses = self._responses_of(m) if few else None  # else one solve each is cheaper, whatever is known already
        for _ in range(HARDENINGS):
            missing = wanted - self._constraints @ solution[:n]
            if np.all(np.abs(missing) <= SMALLEST * (self._share @ np.abs(solution[:n]) + np.abs(wanted))):
                break
            solution += self._pulled(missing) if responses is None else responses @ missing
        return solution[:n], solution[n:]

    def compliance(self, rows: csr_array) -> Floats | None:
        """G u (k, k) of `rows` G (k, n), the displacements u by the loads G', unrefined; None where it is not cheap.

        Symmetric to the last bit. With R = [[G', 0], [0, 1]] the products R' A^-1 R are [[G u, M'], [M, P]], where M
        are multipliers, and P those of unit pulls: of C u they miss d M and add 1 + d P to it.
        """
        k, m = rows.shape[0], self._constraints.shape[0]
        if m > max(FEW_CONSTRAINTS, MANY * k):
            return None
        products = self._fronts.products(csr_array(block_diag([rows.T, eye_array(m)], format="csr")))
        compliance, multipliers, of_pulls = products[:k, :k], products[k:, :k], products[k:, k:]
        pulls = np.zeros((m, k))
        for _ in range(HARDENINGS):
            pulls -= self._yielding[:, None] * (multipliers + of_pulls @ pulls) + pulls
        _add_symmetric_part(compliance, multipliers, pulls)
        return compliance

    def _responses_of(self, m: int) -> Floats:
        """Displacements and multipliers (n + m, m) to unit pulls at the constraints, found when they pay."""
        if self._responses is None:
            self._responses = self._pulled(np.eye(m))
        return self._responses

    def _pulled(self, missing: Floats) -> Floats:
        """Displacements and multipliers (n + m, k) that add `missing` (m, k) to C u but for the yielding."""
        return self._fronts.solve(self._pulls(missing))

    def _pulls(self, missing: Floats) -> Floats:
        """Right-hand sides (n + m, k) that pull at the constraints by `missing` (m, k)."""
        return np.concatenate([np.zeros((self._constraints.shape[1], missing.shape[1])), missing])


def _add_symmetric_part(compliance: Floats, multipliers: Floats, pulls: Floats) -> None:
    """Add the mean of M' P and its transpose to a matrix (k, k), M and P (m, k), that is symmetric to the last bit."""
    for rows, columns in lower_panels(len(compliance)):
        more = 0.5 * (multipliers[:, rows].T @ pulls[:, columns] + (multipliers[:, columns].T @ pulls[:, rows]).T)
        compliance[rows, columns] += more
        if rows != columns:
            compliance[columns, rows] += more.T


def factorize(
    matrix: SymmetricMatrix,
    constraints: csr_array,
    places: Places | None = None,
    known: Kept = NOTHING,
) -> Factorization:
    """Factorize `matrix` (n, n), positive semidefinite, with `constraints` (m, n); `places` of the n unknowns.

    `known` is what is `kept` of another one, which may be in common with this. Without places all unknowns are in one
    dense front. Raises SolveError where entries are not finite, or unknowns have no stiffness.
    """
    places = places or _at_one_place(matrix.shape[0])
    share = abs(constraints)
    met = share @ matrix.diagonal() / np.maximum(share.sum(axis=1), np.finfo(float).tiny)  # mean stiffness, row by row
    fronts, coupling = fronts_of(places, constraints)
    rho, yielding = np.where(coupling, met, 0.0), YIELDING / met
    held = bordered(matrix, constraints, rho, yielding) if len(met) else matrix
    diagonal = held.diagonal()
    if not np.isfinite(held.largest()):
        raise SolveError("the stiffness matrix has entries that are not finite")
    if not np.all(diagonal != 0.0):
        raise SolveError(f"{np.sum(diagonal == 0.0)} of {len(diagonal)} unknowns have no stiffness")
    return Factorization(Multifrontal(held, fronts, known), constraints, rho, yielding)


def _at_one_place(n: int) -> Places:
    """Places of n unknowns that may all be coupled."""
    low = np.zeros((n, 2), dtype=np.int64)
    return Places(low, low + 1, np.array([0, 0]), np.array([1, 1]), 1)
