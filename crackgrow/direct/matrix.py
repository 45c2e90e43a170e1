"""A symmetric matrix as the sum of equal element matrices at many places and of a sparse rest.

The elements away from cracks and outlines are alike: their sum is never formed. Products gather the unknowns of all
elements, multiply them by the one element matrix, and add up what comes out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_array, csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.direct.assembly import HalfMatrix, half, sum_of

AT_ONCE = 4_000_000
"""Numbers that a product or a sum holds at once."""


@dataclass(frozen=True, slots=True, eq=False)
class EqualElements:
    """Elements that have the same matrix."""

    functions: Ints  # (e, k) of each; the unknowns of function f are 2 f and 2 f + 1
    matrix: Floats  # (2 k, 2 k), symmetric, function by function
    key: bytes  # what the matrix was made from

    @property
    def half(self) -> HalfMatrix:
        """The half of the matrix."""
        k = self.functions.shape[1]
        by_component = self.matrix.reshape(k, 2, k, 2).transpose(1, 3, 0, 2).reshape(2, 2, -1)
        pairs = np.flatnonzero(np.triu(np.ones((k, k))))
        return half(k, pairs, by_component[:, :, pairs])


@dataclass(frozen=True, eq=False)
class SymmetricMatrix:
    """The sum (n, n) of `elements` and of a sparse `rest` (n, n)."""

    elements: tuple[EqualElements, ...]
    rest: csc_array

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return (self.rest.shape[0], self.rest.shape[1])

    def __matmul__(self, vectors: Floats) -> Floats:
        """The product with vectors (n,) or (n, m)."""
        total = np.asarray(self.rest @ vectors)
        if not self.elements:
            return total
        columns = total.reshape(len(total), -1)
        for k, vector in enumerate(vectors.reshape(len(total), -1).T):
            pairs, sums = vector.reshape(-1, 2), np.zeros((len(total) // 2, 2))
            for part in self.elements:
                step = max(1, AT_ONCE // len(part.matrix))
                for start in range(0, len(part.functions), step):
                    functions = part.functions[start : start + step]
                    forces = (pairs[functions].reshape(len(functions), -1) @ part.matrix).reshape(-1, 2)
                    for component in (0, 1):
                        sums[:, component] += np.bincount(functions.ravel(), forces[:, component], len(sums))
            columns[:, k] += sums.ravel()
        return columns.reshape(total.shape)

    def sizes(self, vectors: Floats) -> Floats:
        """The product of the absolute values of all terms with those of vectors (n,) or (n, m)."""
        return self._absolute @ np.abs(vectors)

    def diagonal(self) -> Floats:
        """The diagonal (n,)."""
        total = self.rest.diagonal()
        for part in self.elements:
            own = part.matrix.diagonal()
            for component in (0, 1):
                dofs, shares = 2 * part.functions.ravel() + component, np.tile(own[component::2], len(part.functions))
                total += np.bincount(dofs, shares, len(total))
        return np.asarray(total)

    def largest(self) -> float:
        """The largest absolute value of a term; nan where a value is none."""
        terms = [self.rest.data, *(part.matrix for part in self.elements)]
        return max((float(np.abs(values).max(initial=0.0)) for values in terms), key=lambda x: (np.isnan(x), x))

    def with_diagonal(self, places: Ints, values: Floats) -> SymmetricMatrix:
        """The sum with a diagonal matrix that has `values` (k,) at `places` (k,)."""
        more = csc_array((values, (places, places)), shape=self.shape)
        return SymmetricMatrix(self.elements, csc_array(self.rest + more))

    def tocsc(self) -> csc_array:
        """The sum as one sparse matrix."""
        total = self.rest
        for part in self.elements:
            own = part.half
            step = max(1, AT_ONCE // own.entries.size)
            for start in range(0, len(part.functions), step):
                some = sum_of([(part.functions[start : start + step], own)], (self.shape[0] + 1) // 2)
                some.resize(self.shape)  # there may be multipliers
                total = total + some
        return csc_array(total)

    @cached_property
    def _absolute(self) -> SymmetricMatrix:
        """The sum of the absolute values of all terms."""
        parts = tuple(replace(part, matrix=np.abs(part.matrix)) for part in self.elements)
        return SymmetricMatrix(parts, abs(self.rest))


def symmetric(matrix: csc_array | SymmetricMatrix) -> SymmetricMatrix:
    """A sparse matrix as a sum without elements; what is a sum already stays."""
    return matrix if isinstance(matrix, SymmetricMatrix) else SymmetricMatrix((), matrix)


def bordered(matrix: SymmetricMatrix, constraints: csr_array, rho: Floats, yielding: Floats) -> SymmetricMatrix:
    """[[K + C' rho C, C'], [C, -d]] (n + m, n + m) of K (n, n), constraints C (m, n), rho (m,) and d (m,).

    What is added to K is symmetric: its columns are the rows of C' [rho C, 1] and of [C, -d].
    """
    m, n = constraints.shape
    rest, ends, counts = matrix.rest, constraints.indptr[1:], np.diff(constraints.indptr)
    starts = constraints.indptr + np.arange(m + 1)
    indices = np.insert(constraints.indices, ends, n + np.arange(m))
    pushed = np.insert(np.repeat(rho, counts) * constraints.data, ends, 1.0)
    of_unknowns = csr_array(constraints.T) @ csr_array((pushed, indices, starts), shape=(m, n + m))
    of_multipliers = np.insert(constraints.data, ends, -yielding)
    data = np.concatenate([of_unknowns.data, of_multipliers])
    rows = np.concatenate([of_unknowns.indices, indices])
    pointers = np.concatenate([of_unknowns.indptr, of_unknowns.nnz + starts[1:]])
    added = csc_array((data, rows, pointers), shape=(n + m, n + m))
    held = csc_array((rest.data, rest.indices, np.append(rest.indptr, [rest.nnz] * m)), shape=added.shape)
    return SymmetricMatrix(matrix.elements, csc_array(held + added))
