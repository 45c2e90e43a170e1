"""The multifrontal L D L' factorization of K with constraints C u = g, and ties T u - B t = h.

The matrix [[K + C' rho C, C', T'], [C, 0, 0], [T, 0, -B]] is factorized in the order of the fronts without pivoting:
K + C' rho C is definite if the constraints hold what K leaves free, and each multiplier is eliminated after all
unknowns that it acts on. The solution does not depend on rho, since C' rho g is added to the right-hand side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.errors import SolveError
from crackgrow.linear import elimination as kernels
from crackgrow.linear.fronts import Fronts, fronts_of
from crackgrow.linear.matrix import SymmetricMatrix

AT_ONCE = 256
"""Right-hand sides that are solved for together."""


@dataclass(frozen=True, slots=True, eq=False)
class Factor:
    """The rows [U, V] of L' that a front makes."""

    U: Floats  # (p, p)
    V: Floats  # (p, b)
    start: int  # place of the front's first unknown
    n_placed: int  # of its unknowns, those of functions
    border: Ints  # (b,) places of the later unknowns that it is coupled to
    into: Ints  # (b,) what their numbers are in the parent
    children: list[int]


class Factorization:
    """A factorized matrix K (n, n) with constraints C (m, n) and ties T (t, n)."""

    def __init__(
        self,
        matrix: SymmetricMatrix,
        constraints: csr_array,
        boxes: tuple[Ints, Ints],
        ties: csr_array | None = None,
        softness: Floats | None = None,
    ) -> None:
        """Factorize K, positive semidefinite, whose functions have `boxes`: lower left, upper right corners (n / 2, 2).

        `softness` (t,) is the diagonal of B. Each tie acts on something. Raises SolveError where entries are not
        finite, or unknowns have no stiffness.
        """
        self._constraints, squares = constraints, constraints.multiply(constraints)
        self._rho = _stiffness(matrix, constraints) / np.maximum(squares.sum(axis=1), np.finfo(float).tiny)
        self._n_ties = 0 if ties is None else ties.shape[0]
        blocks = (csr_array((0, matrix.shape[0])) if ties is None else ties).tobsr((1, 2))
        self._tie_values = blocks.data.reshape(-1, 2)
        of_ties = (blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64))
        fronts = fronts_of(matrix, constraints, of_ties, boxes)
        self._softness = np.append(np.zeros(len(fronts.order) - self._n_ties), () if softness is None else softness)[
            fronts.order
        ]
        diagonal = matrix.diagonal() + squares.T @ self._rho
        if not np.all(diagonal != 0.0):
            raise SolveError(f"{np.sum(diagonal == 0.0)} of {len(diagonal)} unknowns have no stiffness")
        self._order = fronts.order
        sizes = np.append(diagonal, np.zeros(len(self._rho) + self._n_ties))[fronts.order]
        self.factors: list[Factor] = []
        left: dict[int, Floats] = {}  # what fronts leave to their parents, until these are eliminated
        for front in range(fronts.n):
            factor, left[front] = self._eliminated(fronts, front, matrix.block, sizes, left)
            self.factors.append(factor)
            for child in factor.children:
                del left[child]

    def _eliminated(
        self, fronts: Fronts, front: int, blocks: Floats, sizes: Floats, left: dict[int, Floats]
    ) -> tuple[Factor, Floats]:
        """The factor of a front of a matrix with these `blocks` and the `sizes` of its diagonal, and what it leaves."""
        start, end = fronts.starts[front : front + 2].tolist()
        own = slice(*fronts.border_start[front : front + 2].tolist())
        border, into, n_placed = fronts.border[own], fronts.into[own], int(fronts.n_placed[front])
        children = fronts.children.of(front).tolist()
        p, b, constraints = end - start, len(border), self._constraints
        rows = slice(fronts.row_start[front], fronts.row_start[front + 1] + 1)
        starts, tied = fronts.block_start[rows], fronts.tie_start[rows]
        held = fronts.held[fronts.held_start[front] : fronts.held_start[front + 1]]
        for careful in (False, True):
            U, V, C = np.zeros((p, p)), np.zeros((p, b)), np.zeros((b, b))
            kernels.enter(starts, fronts.block, fronts.turned, fronts.block_column, blocks, U, V)
            kernels.hold(
                held, constraints.indptr, fronts.held_column, constraints.data, fronts.multiplier_column, self._rho,
                U, V, C,
            )  # fmt: skip
            kernels.tie(tied, fronts.tie, fronts.tie_column, self._tie_values, self._softness[start:end], U, V)
            for child in children:
                kernels.extend(left[child], self.factors[child].into, U, V, C)
            if kernels.eliminate(U, V, C, sizes[start:end], n_placed, careful):
                return Factor(U, V, start, n_placed, border, into, children), C
        raise SolveError("the stiffness matrix is not positive definite: the system is too ill conditioned")

    def solve(self, loads: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """Displacements (n, k) and multipliers (m + t, k) for loads (n, k) and `wanted` g, h (m + t, k), unrefined."""
        push = loads + self._constraints.T @ (self._rho[:, None] * wanted[: len(self._rho)]) if wanted.any() else loads
        x = np.ascontiguousarray(np.concatenate([push, wanted])[self._order])
        for each in self.factors:
            kernels.forward(each.U, each.V, each.n_placed, each.start, each.border, x)
        for each in reversed(self.factors):
            kernels.backward(each.U, each.V, each.start, each.border, x)
        solution = np.empty_like(x)
        solution[self._order] = x
        return solution[: len(loads)], solution[len(loads) :]

    def compliance(self, rows: csr_array) -> Floats:
        """G x (k, k) of `rows` G (k, n), the displacements x by the loads G', unrefined; symmetric to the last bit.

        G may have columns of multipliers (m + t) besides, those of ties: x has these then, too. It is Y' D Y with
        Y = L^-1 G'. In a front only those columns of Y are at work that have entries in its subtree, and what it takes
        off later rows goes to its parent: Y is never held as a whole.
        """
        k = rows.shape[0]
        right = csr_array((rows.data, rows.indices, rows.indptr), shape=(k, len(self._order))).T.tocsr()[self._order]
        right.sum_duplicates()
        below: dict[int, tuple[Ints, Floats]] = {}  # columns, and what is taken off later rows, until parents have it
        total, used, place = np.zeros((k, k)), np.zeros(k, dtype=bool), np.empty(k, dtype=np.int64)
        for front, factor in enumerate(self.factors):
            pointers = right.indptr[factor.start : factor.start + len(factor.U) + 1]
            own = slice(pointers[0], pointers[-1])
            children = [(self.factors[child].into, *below.pop(child)) for child in factor.children if child in below]
            for some in (right.indices[own], *(part[1] for part in children)):
                used[some] = True
            columns = np.flatnonzero(used)
            if not len(columns):
                continue
            used[columns], place[columns] = False, np.arange(len(columns))
            y, left = np.zeros((len(factor.U), len(columns))), np.zeros((len(factor.border), len(columns)))
            y[np.repeat(np.arange(len(y)), np.diff(pointers)), place[right.indices[own]]] = right.data[own]
            for into, some, taken_off in children:
                kernels.gather(taken_off, into, place[some], y, left)
            kernels.reduce(factor.U, factor.V, factor.n_placed, y, left, columns, total)
            if len(factor.border):  # else nothing later is coupled to it
                below[front] = (columns, left)
        kernels.mirror(total)
        return total


def _stiffness(matrix: SymmetricMatrix, constraints: csr_array) -> Floats:
    """The mean stiffness (m,) that each constraint meets. Raises SolveError where entries are not finite."""
    if not (np.isfinite(matrix.largest()) and np.isfinite(constraints.data).all()):
        raise SolveError("the stiffness matrix has entries that are not finite")
    share = abs(constraints)
    return np.asarray(share @ matrix.diagonal() / np.maximum(share.sum(axis=1), np.finfo(float).tiny))
