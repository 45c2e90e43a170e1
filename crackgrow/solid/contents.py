"""What goes into each front: elements, entries of the sparse rest, and what its children leave; and its key.

The key is a hash of all that in the front's own numbering: fronts with the same key have the same factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from crackgrow.solid.fronts import MULTIPLIER, Fronts
from crackgrow.solid.matrix import EqualElements, SymmetricMatrix

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class _Elements:
    """Equal elements sorted by the front of the function of theirs that is eliminated first."""

    alike: EqualElements
    positions: Ints  # (e, k) of the first unknown of each function
    starts: Ints  # (fronts + 1,)


class Contents:
    """The contents of all fronts of a matrix."""

    def __init__(self, matrix: SymmetricMatrix, fronts: Fronts) -> None:
        """`matrix` (n, n) in the numbering of the unknowns, multipliers included."""
        self._fronts = fronts
        self._elements = [_sorted(part, fronts) for part in matrix.elements]
        entries = coo_array(matrix.rest)
        position = fronts.position.astype(np.int32)
        row, column = position[entries.coords[0]], position[entries.coords[1]]
        lower = row >= column
        columns = csc_array((entries.data[lower], (row[lower], column[lower])), shape=matrix.shape)
        columns.sort_indices()
        self._columns = columns
        self._constrained = bool(np.any(fronts.code == MULTIPLIER))
        self._children: list[list[int]] = [[] for _ in range(fronts.n)]
        for child, parent in enumerate(fronts.parent.tolist()):
            if parent >= 0:
                self._children[parent].append(child)

    def children(self, front: int) -> list[int]:
        """The fronts whose updates go into a front."""
        return self._children[front]

    def local(self, front: int, positions: Ints) -> Ints:
        """Numbers within a front of the unknowns at `positions`: its own first, then its boundary."""
        start, end = self._fronts.starts[front : front + 2]
        on_boundary = end - start + np.searchsorted(self._fronts.boundary[front], positions)
        return np.asarray(np.where(positions < end, positions - start, on_boundary))

    def assembled(self, front: int) -> tuple[Floats, Floats]:
        """Lower triangle of a front without its children: own columns (p + b, p) and the rest (b, b)."""
        fronts = self._fronts
        p, b = int(fronts.starts[front + 1] - fronts.starts[front]), len(fronts.boundary[front])
        total = np.zeros((p + b) * p + b * b)
        for part in self._elements:
            mine = part.positions[part.starts[front] : part.starts[front + 1]]
            if not len(mine):
                continue
            dofs = (self.local(front, mine)[:, :, None] + np.arange(2)).reshape(len(mine), -1)
            first, second = np.tril_indices(dofs.shape[1])
            row, column = np.maximum(dofs[:, first], dofs[:, second]), np.minimum(dofs[:, first], dofs[:, second])
            at = np.where(column < p, row * p + column, (p + b) * p + (row - p) * b + column - p)
            terms = np.tile(part.alike.matrix[first, second], len(dofs))
            total += np.bincount(at.ravel(), terms, len(total))
        start = int(fronts.starts[front])
        pointers = self._columns.indptr[start : start + p + 1]
        entries = slice(pointers[0], pointers[-1])
        rows = self.local(front, self._columns.indices[entries])
        numbers = np.append(np.arange(start, start + p), fronts.boundary[front])
        if np.any(numbers.take(rows, mode="clip") != self._columns.indices[entries]):
            raise ValueError("unknowns are coupled whose places are further apart than couplings reach")
        total[rows * p + np.repeat(np.arange(p), np.diff(pointers))] += self._columns.data[entries]
        return total[: (p + b) * p].reshape(p + b, p), total[(p + b) * p :].reshape(b, b)

    def keys(self) -> list[bytes]:
        """The key of every front."""
        fronts, columns = self._fronts, self._columns
        per_column = np.diff(columns.indptr)
        entry = self._entry_codes()
        elements = [
            (part, fronts.code[part.positions] - np.repeat(fronts.corner, np.diff(part.starts))[:, None])
            for part in self._elements
        ]
        found: list[bytes] = []
        starts, pointers = fronts.starts.tolist(), columns.indptr[fronts.starts].tolist()
        shape = np.column_stack([np.diff(fronts.starts), fronts.n_early, fronts.n_placed])
        for front, (boundary, corner) in enumerate(zip(fronts.boundary, fronts.corner, strict=True)):
            own, begin, end = slice(starts[front], starts[front + 1]), pointers[front], pointers[front + 1]
            parts = [shape[front], self._relative(fronts.code[own], corner)]
            parts.append(self._relative(fronts.code[boundary], corner))
            digest = sha256()
            for element, codes in elements:
                first, last = element.starts[front : front + 2].tolist()
                if last > first:
                    digest.update(element.alike.key)
                    parts.append(codes[first:last])
            if end > begin:
                parts += [per_column[own], entry[begin:end], columns.data[begin:end]]
            for child in self._children[front]:
                digest.update(found[child])
                parts.append(fronts.corner[child] - corner)
                if self._constrained:
                    border = fronts.boundary[child]
                    parts.append(self.local(front, border[fronts.code[border] == MULTIPLIER]))
            for part in parts:
                digest.update(np.int64(part.size).tobytes() + part.tobytes())
            found.append(digest.digest())
        return found

    def _relative(self, codes: Ints, corner: int) -> Ints:
        """Codes of unknowns within a box; multipliers are not told apart."""
        return np.where(codes == MULTIPLIER, codes, codes - corner) if self._constrained else codes - corner

    def _entry_codes(self) -> Ints:
        """Codes of the rows of all entries of the rest, by front."""
        fronts, columns = self._fronts, self._columns
        front_of = np.repeat(np.arange(fronts.n), np.diff(columns.indptr[fronts.starts]))
        row = columns.indices
        entry = np.asarray(fronts.code[row] - fronts.corner[front_of])
        if self._constrained:
            column = np.repeat(np.arange(len(fronts.order)), np.diff(columns.indptr))
            of_multiplier = np.flatnonzero((fronts.code[row] == MULTIPLIER) | (fronts.code[column] == MULTIPLIER))
            front_of = front_of[of_multiplier]
            for front in np.unique(front_of).tolist():
                here = of_multiplier[front_of == front]
                entry[here] = MULTIPLIER + self.local(front, row[here])
        return entry


def _sorted(part: EqualElements, fronts: Fronts) -> _Elements:
    """Equal elements in the order of their fronts."""
    positions = fronts.position[2 * part.functions]
    front = np.searchsorted(fronts.starts, positions.min(axis=1, initial=len(fronts.order)), side="right") - 1
    order = np.argsort(front, kind="stable")
    return _Elements(part, positions[order], np.searchsorted(front[order], np.arange(fronts.n + 1)))
