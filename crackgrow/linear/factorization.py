"""The multifrontal L D L' factorization of K with constraints C u = g, which reuses fronts of the matrix before.

The matrix [[K + C' rho C, C'], [C, 0]] is factorized in the order of the fronts without pivoting: K + C' rho C is
definite if the constraints hold what K leaves free, and each multiplier is eliminated after all unknowns that it acts
on. The solution does not depend on rho, since C' rho g is added to the right-hand side.

Each factor has a key, a hash of the entries of its front and of the keys of the fronts below it. A front whose key has
not changed keeps its factor. Condensed right-hand sides of subtrees are reused in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Floats, Ints, key_of
from crackgrow.errors import SolveError
from crackgrow.linear import elimination as kernels
from crackgrow.linear.fronts import fronts_of
from crackgrow.linear.matrix import SymmetricMatrix

AT_ONCE = 256
"""Rows of a large matrix that are mirrored together."""

FEW_FRONTS = 15
"""A subtree of at most so many fronts keeps what it leaves to its parent only once something has grown there: before it
is made again from the factors when it is asked for. Of 50 flaws 43 MB are kept at first; all are 370 MB, twice the
factors."""


@dataclass(slots=True, eq=False)
class Factor:
    """The rows of L' that a front makes, and what it leaves to its parent."""

    U: Floats  # (p, p)
    V: Floats  # (p, b)
    left: Floats | None = None  # where it is kept, as `elimination.extend` takes it


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """What elimination in a subtree makes of the right-hand sides (c,) that are at work there."""

    product: Floats  # (c, c) Y' D Y of the rows of Y that are eliminated in it, the upper triangle
    left: Floats  # (b, c) what it leaves to the later unknowns that it is coupled to


class Factorization:
    """A factorized matrix K (n, n) with constraints C (m, n)."""

    def __init__(
        self,
        matrix: SymmetricMatrix,
        constraints: csr_array,
        boxes: tuple[Ints, Ints] | None = None,
        before: Factorization | None = None,
        keep: bool = True,
    ) -> None:
        """Factorize K, positive semidefinite, whose functions have `boxes`: lower left, upper right corners (n / 2, 2).

        Without boxes all unknowns are in one dense front. `before` is one that may have subtrees in common with this;
        `keep` what the next one may have in common with this, twice the factors.
        Raises SolveError where entries are not finite, or unknowns have no stiffness.
        """
        self._keep = keep
        self._constraints, squares = constraints, constraints.multiply(constraints)
        self._rho = _stiffness(matrix, constraints) / np.maximum(squares.sum(axis=1), np.finfo(float).tiny)
        alike = np.zeros((matrix.n_functions, 2), dtype=np.int64)
        self._fronts = fronts_of(matrix, constraints, *(boxes or (alike, alike + 1)))
        diagonal = matrix.diagonal() + squares.T @ self._rho
        if not np.all(diagonal != 0.0):
            raise SolveError(f"{np.sum(diagonal == 0.0)} of {len(diagonal)} unknowns have no stiffness")
        self._sizes = np.append(diagonal, np.zeros(len(self._rho)))[self._fronts.order]
        self._blocks = kernels.ordered(matrix.block, self._fronts.block, self._fronts.turned)
        self._starts, self._borders = (each.tolist() for each in (self._fronts.starts, self._fronts.border_start))
        self._children: list[list[int]] = [[] for _ in range(self._fronts.n)]
        for front, parent in enumerate(self._fronts.parent[:-1].tolist()):
            self._children[parent].append(front)
        self._keys = self._found_keys()
        self.reduced: dict[bytes, Reduced] = {} if before is None else before.reduced
        self.n_fronts, self.n_eliminated = self._fronts.n, 0
        self.factors = self._found_factors(before)
        self._placed: list[tuple[Factor, int, int, Ints]] | None = [
            (self.factors[key], n_placed, start, self._border(front))
            for front, (key, n_placed, start) in enumerate(
                zip(self._keys, self._fronts.n_placed.tolist(), self._starts[:-1], strict=True)
            )
        ]
        del self._blocks  # factors have it now

    def hand_over(self) -> None:
        """Solve no more: the factorization that comes next is the last to need the factors, and lets go of others."""
        self._placed = None

    def solve(self, loads: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """Displacements (n, k) and multipliers (m, k) for loads (n, k) with C u = `wanted` (m, k), unrefined."""
        push = loads + self._constraints.T @ (self._rho[:, None] * wanted) if wanted.any() else loads
        x = np.ascontiguousarray(np.concatenate([push, wanted])[self._fronts.order])
        for factor, n_placed, start, border in self._in_order:
            kernels.forward(factor.U, factor.V, n_placed, start, border, x)
        for factor, _, start, border in reversed(self._in_order):
            kernels.backward(factor.U, factor.V, start, border, x)
        solution = np.empty_like(x)
        solution[self._fronts.order] = x
        return solution[: len(loads)], solution[len(loads) :]

    def compliance(self, rows: csr_array) -> Floats:
        """G u (k, k) of `rows` G (k, n), the displacements u by the loads G', unrefined; symmetric to the last bit.

        In a front only those columns of Y = L^-1 G' are at work that have entries in its subtree, and what it takes off
        later ones goes to its parent: Y is never held as a whole.
        """
        k, (m, n) = rows.shape[0], self._constraints.shape
        right = csr_array((rows.data, rows.indices, rows.indptr), shape=(k, n + m)).T.tocsr()[self._fronts.order]
        right.sum_duplicates()
        kept: dict[bytes, Reduced] = {}
        below: dict[int, tuple[bytes, Ints]] = {}  # of fronts: the key of what is reduced, and its columns
        total = np.zeros((k, k))
        for front, (factor, n_placed, start, border) in enumerate(self._in_order):
            pointers = right.indptr[start : start + len(factor.U) + 1]
            own = slice(pointers[0], pointers[-1])
            children = [child for child in self._children[front] if child in below]
            parts = [right.indices[own], *(below[child][1] for child in children)]
            columns = np.unique(np.concatenate(parts)).astype(np.int64)
            if not len(columns):
                continue
            at = [np.searchsorted(columns, part) for part in parts]
            keys = [np.frombuffer(key, np.uint8) for key in (self._keys[front], *(below[c][0] for c in children))]
            numbers = np.array([self._children[front].index(child) for child in children], dtype=np.int64)
            key = key_of([np.diff(pointers), right.data[own], *at, numbers, *keys])
            reduced = kept.get(key) or self.reduced.get(key)
            if reduced is None:
                y, left = np.zeros((len(factor.U), len(columns))), np.zeros((len(border), len(columns)))
                y[np.repeat(np.arange(len(y)), np.diff(pointers)), at[0]] = right.data[own]
                product = np.zeros((len(columns), len(columns)))
                for child, places in zip(children, at[1:], strict=True):
                    some = kept[below[child][0]]
                    kernels.gather(some.left, some.product, self._into(child), places, y, left, product)
                kernels.reduce(factor.U, factor.V, n_placed, y, left, product)
                reduced = Reduced(product, left)
            if len(border):
                kept[key], below[front] = reduced, (key, columns)
            else:  # nothing later is coupled to it: the end of a tree, which is new wherever anything in it is
                total[np.ix_(columns, columns)] += reduced.product
            for child in () if self._keep else children:  # unless an equal subtree waits for its parent, too
                done, _ = below.pop(child)
                if all(done != waits for waits, _ in below.values()):
                    kept.pop(done, None)
        self.reduced = kept
        for n in range(0, k, AT_ONCE):  # mirrored in blocks: it is large
            block = slice(n, n + AT_ONCE)
            upper = np.triu(total[block, block])
            total[block, block] = upper + np.triu(upper, 1).T
            total[block, :n] = total[:n, block].T
        return total

    @property
    def _in_order(self) -> list[tuple[Factor, int, int, Ints]]:
        """Of each front: the factor, how many of its unknowns are of functions, its first place, and its border."""
        if self._placed is None:
            raise RuntimeError("the factors are handed over: nothing can be solved with them any more")
        return self._placed

    def _border(self, front: int) -> Ints:
        return self._fronts.border[self._borders[front] : self._borders[front + 1]]

    def _into(self, front: int) -> Ints:
        return self._fronts.into[self._borders[front] : self._borders[front + 1]]

    def _entries(self, front: int) -> tuple[Ints, Ints, Floats]:
        """What `kernels.enter` takes of a front."""
        fronts = self._fronts
        starts = fronts.block_start[fronts.row_start[front] : fronts.row_start[front + 1] + 1]
        own = slice(starts[0], starts[-1])
        return starts, fronts.block_column[own], self._blocks[own]

    def _held(self, front: int) -> tuple[Ints, Ints, Floats, Ints, Floats] | None:
        """What `kernels.hold` takes of a front, if constraints begin there."""
        fronts, indptr = self._fronts, self._constraints.indptr
        held = fronts.held[fronts.held_start[front] : fronts.held_start[front + 1]]
        if not len(held):
            return None
        starts = np.append(0, np.cumsum(np.diff(indptr)[held]))
        own = np.concatenate([np.arange(indptr[r], indptr[r + 1]) for r in held.tolist()])
        columns, values = fronts.held_column[own], self._constraints.data[own]
        return starts, columns, values, fronts.multiplier_column[held], self._rho[held]

    def _found_keys(self) -> list[bytes]:
        """The key of each front."""
        keys: list[bytes] = []
        for front in range(self._fronts.n):
            start, end = self._starts[front], self._starts[front + 1]
            counts = np.array([end - start, self._fronts.n_placed[front], len(self._border(front))])
            starts, columns, blocks = self._entries(front)
            parts = [counts, np.diff(starts), columns, blocks, self._sizes[start:end], *(self._held(front) or ())]
            for child in self._children[front]:
                parts += [np.frombuffer(keys[child], np.uint8), self._into(child)]
            keys.append(key_of(parts))
        return keys

    def _found_factors(self, before: Factorization | None) -> dict[bytes, Factor]:
        """The factors by their keys: those that are known, and those that are made."""
        known = {} if before is None else before.factors
        if before is not None and before._placed is None:
            for key in known.keys() - set(self._keys):
                del known[key]
        found: dict[bytes, Factor] = {}
        n_below = [1] * self._fronts.n  # fronts of each subtree
        for front, key in enumerate(self._keys):
            n_below[front] += sum(n_below[child] for child in self._children[front])
            factor = found.get(key) or known.get(key)
            found[key] = self._eliminated(front, found) if factor is None else factor
            for child in self._children[front]:  # it will be asked for again as the same tip grows on
                below = found[self._keys[child]]
                drop = not self._keep or (n_below[child] <= FEW_FRONTS and not known)
                below.left = None if drop or below.left is None else kernels.packed(below.left, below.V.shape[1])
        return found

    def _assembled(self, front: int, found: dict[bytes, Factor]) -> tuple[Floats, Floats, Floats]:
        """The blocks U, V, C of a front before its elimination."""
        p, b = self._starts[front + 1] - self._starts[front], self._borders[front + 1] - self._borders[front]
        U, V, C = np.zeros((p, p)), np.zeros((p, b)), np.zeros((b, b))
        kernels.enter(*self._entries(front), U, V)
        held = self._held(front)
        if held is not None:
            kernels.hold(*held, U, V, C)
        for child in self._children[front]:
            kernels.extend(self._left(child, found), self._into(child), U, V, C)
        return U, V, C

    def _eliminated(self, front: int, found: dict[bytes, Factor]) -> Factor:
        """The factor of a front, whose children are `found`."""
        n_placed, size = int(self._fronts.n_placed[front]), self._sizes[self._starts[front] : self._starts[front + 1]]
        U, V, C = self._assembled(front, found)
        if not kernels.eliminate(U, V, C, size, n_placed, False):
            U, V, C = self._assembled(front, found)
            if not kernels.eliminate(U, V, C, size, n_placed, True):
                raise SolveError("the stiffness matrix is not positive definite: the system is too ill conditioned")
        self.n_eliminated += 1
        return Factor(U, V, C.ravel())

    def _left(self, front: int, found: dict[bytes, Factor]) -> Floats:
        """What a front leaves to its parent, made again where it is not kept."""
        factor = found[self._keys[front]]
        if factor.left is None:
            _, _, C = self._assembled(front, found)
            kernels.take_off(factor.V, C, int(self._fronts.n_placed[front]))
            factor.left = C.ravel()
        return factor.left


def _stiffness(matrix: SymmetricMatrix, constraints: csr_array) -> Floats:
    """The mean stiffness (m,) that each constraint meets. Raises SolveError where entries are not finite."""
    if not (np.isfinite(matrix.largest()) and np.isfinite(constraints.data).all()):
        raise SolveError("the stiffness matrix has entries that are not finite")
    share = abs(constraints)
    return np.asarray(share @ matrix.diagonal() / np.maximum(share.sum(axis=1), np.finfo(float).tiny))
