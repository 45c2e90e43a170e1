"""A sparse symmetric matrix as its lower triangle of 2 x 2 blocks, one for each pair of functions that are coupled."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.compiled import kernel


@dataclass(frozen=True, slots=True, eq=False)
class SymmetricMatrix:
    """A matrix (2 n, 2 n) of n functions, with the unknowns 2 f and 2 f + 1 of function f."""

    start: Ints  # (n + 1,) of the blocks of each row
    column: Ints  # (q,) ascending in each row, the last one is the row itself
    block: Floats  # (q, 2, 2) component of the row, component of the column; whole on the diagonal

    @property
    def n_functions(self) -> int:
        """Number of functions."""
        return len(self.start) - 1

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return (2 * self.n_functions, 2 * self.n_functions)

    @property
    def row(self) -> Ints:
        """The row (q,) of each block."""
        return np.repeat(np.arange(self.n_functions), np.diff(self.start))

    def __matmul__(self, vectors: Floats) -> Floats:
        """The product with vectors (2 n,) or (2 n, k)."""
        rows = np.ascontiguousarray(vectors.reshape(len(vectors), -1).T, dtype=np.float64)
        total = np.zeros_like(rows)
        _add_product(self.start, self.column, self.block, rows, total)
        return np.ascontiguousarray(total.T).reshape(vectors.shape)

    def sizes(self, vectors: Floats) -> Floats:
        """The product of the absolute values with those of vectors (2 n,) or (2 n, k)."""
        return replace(self, block=np.abs(self.block)) @ np.abs(vectors)

    def diagonal(self) -> Floats:
        """The diagonal (2 n,)."""
        return np.ascontiguousarray(self.block[self.start[1:] - 1].diagonal(axis1=1, axis2=2)).ravel()

    def largest(self) -> float:
        """The largest absolute value; nan where a value is none."""
        return float(np.abs(self.block).max(initial=0.0))

    def with_diagonal(self, places: Ints, values: Floats) -> SymmetricMatrix:
        """The sum with a diagonal matrix that has `values` (k,) at the unknowns `places` (k,)."""
        block = self.block.copy()
        np.add.at(block, (self.start[places // 2 + 1] - 1, places % 2, places % 2), values)
        return replace(self, block=block)


@kernel
def _add_product(start: Ints, column: Ints, block: Floats, vectors: Floats, total: Floats) -> None:
    """Add the products with the rows of `vectors` (k, 2 n) to those of `total` (k, 2 n)."""
    for k in range(len(vectors)):
        u, f = vectors[k], total[k]
        for i in range(len(start) - 1):
            x, y, own_x, own_y = 0.0, 0.0, u[2 * i], u[2 * i + 1]
            last = start[i + 1] - 1
            for q in range(start[i], last):
                j = 2 * column[q]
                a, b, c, d = block[q, 0, 0], block[q, 0, 1], block[q, 1, 0], block[q, 1, 1]
                x += a * u[j] + b * u[j + 1]
                y += c * u[j] + d * u[j + 1]
                f[j] += a * own_x + c * own_y
                f[j + 1] += b * own_x + d * own_y
            f[2 * i] += x + block[last, 0, 0] * own_x + block[last, 0, 1] * own_y
            f[2 * i + 1] += y + block[last, 1, 0] * own_x + block[last, 1, 1] * own_y
