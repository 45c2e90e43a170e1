"""The linear solve behind one interface: a symmetric positive definite matrix with a few linear constraints.

K u + C' m = f, C u = g. With constraints K alone may be singular, so K0 = K + C' rho C takes its place (the constraints
add the same amount to both sides, the answer does not depend on rho). The matrix [[K0, C'], [C, -d]] with a small d is
quasi-definite: it has a symmetric factorization without pivoting in any order (Vanderbei 1995), also where constraints
repeat each other. What C u then misses of g, as a right-hand side of its own, takes the effect of d away.

Constraints that act further than the couplings of K reach have no rho where fronts factorize: it would couple all that
they act on. Their multipliers are eliminated after a part of that and before the rest of it, and so stiffen the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.sparse import block_diag, csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu

from crackgrow.arrays import Floats
from crackgrow.direct.dissection import Places
from crackgrow.direct.fronts import Fronts, fronts_of
from crackgrow.direct.matrix import SymmetricMatrix, bordered, symmetric
from crackgrow.direct.multifrontal import Factor, Multifrontal, NotQuasiDefiniteError
from crackgrow.errors import SolveError

YIELDING = 1e-7
"""d times rho: constraints give way by this fraction, which each refinement takes away again."""

HARDENINGS = 2
"""Most corrections of which each reduces what constraints have given way by `YIELDING`."""

SMALLEST = float(np.finfo(float).eps)
"""What constraints give way by less than this fraction is round-off."""

REFINEMENTS = 3
"""Most corrections for round-off."""

STIFFENED = 1e-12
"""Of the diagonal, added to it where a factorization finds it indefinite: slivers of rock between a crack and an
outline, or many functions on little rock, which then depend on each other to round-off. Along what moves no rock the
solution stays small instead of arbitrary, and refinement takes the effect on all else away (after Strouboulis, Babuska,
Copps 2000). On such a wedge results are the same from 1e-13 to 1e-10; without, displacements are wrong by all they are.
"""

ROUND_OFF = 1e-14
"""Residuals below this fraction of the terms that they are sums of are round-off."""

FEW_CONSTRAINTS = 16
"""Up to so many constraints the responses to all of them cost less than the solves that they save."""

MANY = 8
"""Constraints per row from which elimination of all costs more than solves for the rows."""

AT_ONCE = 256
"""Right-hand sides that are solved for together."""

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
    """A factorized symmetric matrix, definite or quasi-definite."""

    factors: Mapping[bytes, Factor]
    """What another factorization may have in common with this one."""

    _solve: Callable[[Floats], Floats]

    _products: Callable[[csr_array], Floats] | None

    def __init__(
        self, matrix: SymmetricMatrix, fronts: Fronts | None = None, known: Mapping[bytes, Factor] | None = None
    ) -> None:
        """Factorize `matrix` (n, n) by `fronts`, taking over what is `known`; without fronts SuperLU factorizes.

        Raises NotQuasiDefiniteError where fronts can't factorize it, SolveError where it is not finite, or singular in
        an obvious way.
        """
        diagonal = matrix.diagonal()
        if not np.isfinite(matrix.largest()):
            raise SolveError("the stiffness matrix has entries that are not finite")
        if not np.all(diagonal != 0.0):
            raise SolveError(f"{np.sum(diagonal == 0.0)} of {len(diagonal)} unknowns have no stiffness")
        if fronts is None:
            self.factors, self._solve, self._products = {}, _by_superlu(matrix.tocsc(), diagonal), None
        else:
            by_fronts = Multifrontal(matrix, fronts, known)
            self.factors, self._solve, self._products = by_fronts.factors, by_fronts.solve, by_fronts.products

    def solve(self, right: Floats) -> Floats:
        """Solution (n,) or (n, m) for the right-hand sides `right`, unrefined."""
        return self._solve(right)

    def products(self, right: csr_array) -> Floats | None:
        """R' A^-1 R (k, k) of right-hand sides R (n, k), unrefined, for less than their solutions; None by SuperLU."""
        return None if self._products is None else self._products(right)


def _by_superlu(matrix: csc_array, diagonal: Floats) -> Callable[[Floats], Floats]:
    """What solves for right-hand sides (n,) or (n, m), by SuperLU with the matrix scaled to a diagonal of one."""
    scale = 1.0 / np.sqrt(np.abs(diagonal))
    across = np.repeat(scale, np.diff(matrix.indptr))
    scaled = csc_array((matrix.data * scale[matrix.indices] * across, matrix.indices, matrix.indptr))
    try:
        factors = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:
        raise SolveError(f"the stiffness matrix is singular ({error}): is a body free to move?") from error

    def solve(right: Floats) -> Floats:
        by_row = scale if right.ndim == 1 else scale[:, None]
        return np.asarray(by_row * factors.solve(by_row * right))

    return solve


class ConstrainedSystem:
    """K with constraints C u = g, factorized once for many loads."""

    note: str
    """Why not the multifrontal factorization but SuperLU was used where places are known; else empty."""

    def __init__(
        self,
        stiffness: csc_array | SymmetricMatrix,
        constraints: csr_array,
        places: Places | None = None,
        known: Mapping[bytes, Factor] | None = None,
    ) -> None:
        """`stiffness` (n, n) Pa, `constraints` (m, n), `places` of the n unknowns; without them SuperLU factorizes.

        `known` are the `factors` of another system, that may be in common with this one.
        """
        self.stiffness = symmetric(stiffness)
        self.constraints = constraints
        self._share = abs(constraints)
        total = np.maximum(self._share.sum(axis=1), np.finfo(float).tiny)
        size = self._share @ self.stiffness.diagonal() / total  # row by row, of the size of the entries it meets
        fronts, coupling = (None, np.ones(len(size), dtype=bool)) if places is None else fronts_of(places, constraints)
        self._rho = np.where(coupling, size, 0.0)
        self._yielding = YIELDING / size
        self.note = ""
        try:
            self._factorization = Factorization(self._held(), fronts, known)
        except NotQuasiDefiniteError as error:
            self.note = f"factorized by SuperLU: {error}"
            self._rho = size  # only the order of the fronts does without
            held, n = self._held(), self.stiffness.shape[0]
            self._factorization = Factorization(held.with_diagonal(np.arange(n), STIFFENED * held.diagonal()[:n]))
        self._responses: Floats | None = None  # (n + m, m) to the constraints, found when they pay

    @property
    def factors(self) -> Mapping[bytes, Factor]:
        """What another system may have in common with this one."""
        return self._factorization.factors

    def solve(self, loads: Floats, given: Floats | None = None) -> tuple[Floats, Floats]:
        """Displacements (n,) or (n, k) and multipliers (m,) or (m, k) for loads (n,) or (n, k).

        `given` (m,) or (m, k) are the prescribed values g, zero if None; (m,) are those of all loads. Raises SolveError
        where constraints contradict.
        """
        n, m = self.constraints.shape[1], self.constraints.shape[0]
        columns = loads.reshape(n, -1)
        each = np.zeros(m) if given is None else given
        wanted = np.broadcast_to(each[:, None] if each.ndim == 1 else each, (m, columns.shape[1]))
        u, multipliers = np.empty(columns.shape), np.empty((m, columns.shape[1]))
        for start in range(0, columns.shape[1], AT_ONCE):
            block = slice(start, start + AT_ONCE)
            u[:, block], multipliers[:, block] = self._refined(columns[:, block], wanted[:, block])
        if given is not None and m:
            left = np.abs(self.constraints @ u - wanted).max(axis=0, initial=0.0)
            round_off = ROUND_OFF * (self._share @ np.abs(u)).max(
                axis=0, initial=0.0
            )  # where loads act on what is held
            size = np.array([displacement_size(*column) for column in zip(columns.T, u.T, wanted.T, strict=True)])
            if np.any(left > np.maximum(INCONSISTENT * size, round_off)):
                raise SolveError(f"the supports contradict each other by {left.max():.3g} m")
        return u.reshape(loads.shape), multipliers.reshape(m, *loads.shape[1:])

    def compliance(self, rows: csr_array) -> Floats | None:
        """G u (k, k) of `rows` G (k, n), the displacements u by the loads G', unrefined; None where it is not cheap.

        Symmetric to the last bit. With R = [[G', 0], [0, 1]] the products R' A^-1 R are [[G u, M'], [M, P]], where M
        are multipliers, and P those of unit pulls: of C u they miss d M and add 1 + d P to it.
        """
        k, m = rows.shape[0], self.constraints.shape[0]
        if m > max(FEW_CONSTRAINTS, MANY * k):
            return None
        products = self._factorization.products(csr_array(block_diag([rows.T, eye_array(m)], format="csr")))
        if products is None:
            return None
        compliance, multipliers, of_pulls = products[:k, :k], products[k:, :k], products[k:, k:]
        pulls = np.zeros((m, k))
        for _ in range(HARDENINGS):
            pulls -= self._yielding[:, None] * (multipliers + of_pulls @ pulls) + pulls
        taken_away = multipliers.T @ pulls
        return np.asarray(compliance + 0.5 * (taken_away + taken_away.T))

    def _held(self) -> SymmetricMatrix:
        """The quasi-definite matrix (n + m, n + m), with constraints that yield."""
        if self.constraints.shape[0] == 0:
            return self.stiffness
        return bordered(self.stiffness, self.constraints, self._rho, self._yielding)

    def _refined(self, loads: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """Displacements (n, k) and multipliers (m, k) for loads (n, k) with C u = `wanted` (m, k).

        Refinement goes on until it finds nothing but round-off, seen on one sum of all columns with signs at random.
        """
        u, multipliers = self._step(loads, wanted)
        sign = np.ones(1) if loads.shape[1] == 1 else _signs(loads)
        last = np.inf
        for _ in range(REFINEMENTS):
            one_of_all = loads @ sign, u @ sign, multipliers @ sign
            force = self._residual(*one_of_all)
            error = self._backward_error(force, *one_of_all)
            if error <= ROUND_OFF or error > 0.5 * last:
                break
            last = error
            if loads.shape[1] > 1:
                force = self._residual(loads, u, multipliers)
            du, dm = self._step(force.reshape(loads.shape), wanted - self.constraints @ u)
            u, multipliers = u + du, multipliers + dm
        return u, multipliers

    def _residual(self, loads: Floats, u: Floats, multipliers: Floats) -> Floats:
        """Loads (n,) or (n, k) that nothing balances."""
        return np.asarray(loads - self.stiffness @ u - self.constraints.T @ multipliers)

    def _backward_error(self, residual: Floats, loads: Floats, u: Floats, multipliers: Floats) -> float:
        """The largest residual, row by row relative to the sum of the absolute terms (Oettli, Prager 1964)."""
        terms = np.abs(loads) + self.stiffness.sizes(u) + self._share.T @ np.abs(multipliers)
        return float(np.max(np.abs(residual[terms > 0.0]) / terms[terms > 0.0], initial=0.0))

    def _step(self, loads: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """As `_refined`, without refinement but for the yielding of the constraints."""
        n, m = self.constraints.shape[1], self.constraints.shape[0]
        push = loads + self.constraints.T @ (self._rho[:, None] * wanted)
        solution = self._factorization.solve(np.concatenate([push, wanted]) if m else push)
        if m == 0:
            return solution, solution[n:]
        if self._responses is None and m <= max(FEW_CONSTRAINTS, loads.shape[1]):  # else one solve each is cheaper
            self._responses = self._pulled(np.eye(m))
        responses = self._responses
        for _ in range(HARDENINGS):
            missing = wanted - self.constraints @ solution[:n]
            if np.all(np.abs(missing) <= SMALLEST * (self._share @ np.abs(solution[:n]) + np.abs(wanted))):
                break
            solution += self._pulled(missing) if responses is None else responses @ missing
        return solution[:n], solution[n:]

    def _pulled(self, missing: Floats) -> Floats:
        """Displacements and multipliers (n + m, k) that add `missing` (m, k) to C u but for the yielding."""
        return self._factorization.solve(
            np.concatenate([np.zeros((self.constraints.shape[1], missing.shape[1])), missing])
        )


def _signs(loads: Floats) -> Floats:
    """What weighs the columns of `loads` (n, k) alike in a sum of them all, with signs at random."""
    size = np.abs(loads).max(axis=0)
    sign = np.random.default_rng(0).choice([-1.0, 1.0], loads.shape[1])
    # nothing is left to refine of what is smaller
    return np.asarray(sign / np.where(size >= np.finfo(float).tiny, size, 1.0))
