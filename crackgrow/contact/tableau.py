"""The condensed tableau of Lemke's method with the lexicographic minimum ratio (Cottle, Pang, Stone, section 4.9)."""

from __future__ import annotations

from typing import Final

import numpy as np

from crackgrow.arrays import Floats, Ints

PIVOT: Final = 1e-11  # entries below this part of the largest of their column are round-off, not pivots
TIE: Final = 1e-12  # ratios closer than this part of the largest basic value are ties
BLOCK: Final = 48  # rank-1 updates collected before one matrix product applies them


class Tableau:
    """Condensed tableau x_B + T x_N = value, where variables 0..n-1 are w, n..2n-1 are z, and 2n is z0.

    T (n, n+1) is kept as base - U V, the product collecting the latest pivots. Columns of the inverse basis, which
    the lexicographic rule compares, are those of w where w is nonbasic, else unit vectors.
    """

    def __init__(self, M: Floats, q: Floats, d: Floats) -> None:
        n = q.size
        self.base = np.column_stack([-M, -d])
        self.value = q.copy()
        self.U, self.V = np.zeros((n, BLOCK)), np.zeros((BLOCK, n + 1))
        self.n_pending, self.n_pivots = 0, 0
        self.basic = np.arange(n)  # variable of each row
        self.nonbasic = np.arange(n, 2 * n + 1)  # variable of each column
        self.place = np.concatenate([np.arange(n), np.arange(n + 1)])  # row or column of each variable

    def first_row(self, d: Floats) -> int:
        """Row that leaves when z0 enters: the most negative q/d, the last one of ties (lexicographic)."""
        ratio = self.value / d
        return int(np.flatnonzero(ratio <= ratio.min() + TIE * np.abs(ratio).max())[-1])

    def leaving_row(self, column: int) -> int:
        """Row of the lexicographic minimum ratio for an entering column; -1 where it may grow without end (a ray)."""
        entries = self._column(column)
        rows = np.flatnonzero(entries > PIVOT * max(1.0, float(np.abs(entries).max())))
        if rows.size == 0:
            return -1
        ratio = np.maximum(self.value[rows], 0.0) / entries[rows]
        rows = rows[ratio <= ratio.min() + TIE * max(1.0, float(self.value.max()))]
        artificial = rows[self.basic[rows] == 2 * self.value.size]
        if artificial.size:
            return int(artificial[0])
        return int(rows[0]) if rows.size == 1 else self._lexicographic(rows, entries)

    def pivot(self, row: int, column: int) -> int:
        """Exchange the variables of a row and a column; return the variable that left the basis."""
        u, v = self._column(column), self._row(row)
        pivot = float(u[row])
        step = self.value[row] / pivot
        self.value -= step * u
        self.value[row] = step
        self.U[row], self.V[:, column] = 0.0, 0.0
        self.base[row], self.base[:, column] = v / pivot, -u / pivot
        self.base[row, column] = 1.0 / pivot
        u[row], v[column] = 0.0, 0.0
        self.U[:, self.n_pending], self.V[self.n_pending] = u, v / pivot
        self.n_pending += 1
        if self.n_pending == BLOCK:
            self._apply()
        entering, leaving = int(self.nonbasic[column]), int(self.basic[row])
        self.basic[row], self.nonbasic[column] = entering, leaving
        self.place[entering], self.place[leaving] = row, column
        self.n_pivots += 1
        return leaving

    def artificial(self) -> float:
        """Value of z0."""
        n = self.value.size
        return float(self.value[self.basic == 2 * n].sum())

    def point(self) -> tuple[Floats, Floats]:
        """z (n,) and w (n,) of the basis."""
        n = self.value.size
        x = np.zeros(2 * n + 1)
        x[self.basic] = np.maximum(self.value, 0.0)
        return x[n : 2 * n], x[:n]

    def _lexicographic(self, rows: Ints, entries: Floats) -> int:
        n = self.value.size
        for w in range(n):
            place = int(self.place[w])
            is_basic = place < n and self.basic[place] == w
            inverse = (rows == place).astype(np.float64) if is_basic else self._column(place, rows)
            ratio = inverse / entries[rows]
            rows = rows[ratio <= ratio.min() + TIE * max(1.0, float(np.abs(ratio).max()))]
            if rows.size == 1:
                break
        return int(rows[0])

    def _column(self, column: int, rows: Ints | slice = slice(None)) -> Floats:
        k = self.n_pending
        entries: Floats = self.base[rows, column] - self.U[rows, :k] @ self.V[:k, column]
        return entries

    def _row(self, row: int) -> Floats:
        k = self.n_pending
        entries: Floats = self.base[row] - self.U[row, :k] @ self.V[:k]
        return entries

    def _apply(self) -> None:
        self.base -= self.U @ self.V
        self.U[:], self.V[:], self.n_pending = 0.0, 0.0, 0
