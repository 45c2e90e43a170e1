"""What goes into each front: elements, blocks, entries of the sparse rest, and what its children leave; and its key.

The key is a hash of all that in the front's own numbering: fronts with the same key have the same factors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from crackgrow.arrays import Floats, Ints
from crackgrow.direct.fronts import MULTIPLIER, Fronts
from crackgrow.direct.matrix import Blocks, EqualElements, SymmetricMatrix
from crackgrow.ragged import spans, starts_of

Int32s = NDArray[np.int32]

OUTSIDE = -1
"""In place of the number in a front of a function that it has nothing of."""

FAR_APART = "unknowns are coupled whose places are further apart than couplings reach"


@dataclass(frozen=True, slots=True, eq=False)
class _Elements:
    """Elements with equally many functions, sorted by the front of the function of theirs that is eliminated first."""

    positions: Ints  # (e, k) of the first unknown of each function
    kind: Ints  # (e,) which of the matrices
    starts: Ints  # (fronts + 1,)
    names: Ints  # (kinds, 4) hash of what each matrix was made from
    terms: Floats  # (2, kinds, q, 2) what the unknowns have in common of each pair of functions,
    first: Ints  # (q,) the first one
    second: Ints  # (q,) and the second


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """The pairs of functions of all blocks, by the front that eliminates the first of both."""

    starts: Ints  # (fronts + 1,)
    positions: Int32s  # (2, p) of the first unknown of each function
    entries: Floats  # (2, p, 2) of the half of the sum of all blocks, as in `HalfMatrix`


class Contents:
    """The contents of all fronts of a matrix."""

    def __init__(self, matrix: SymmetricMatrix, fronts: Fronts) -> None:
        """`matrix` (n, n) in the numbering of the unknowns, multipliers included."""
        self._fronts = fronts
        self._elements = _sorted(matrix.elements, fronts)
        self._columns = _lower_columns(matrix.rest, fronts)
        self._pairs = _at_fronts(matrix.blocks, fronts)
        self._rows, self._functions, self._of_pairs = self._numbered()
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
        start, end = self._fronts.starts[front : front + 2].tolist()
        p, b = end - start, len(self._fronts.boundary[front])
        pointers = self._columns.indptr[start : end + 1]
        places = [self._rows[front].astype(np.int64) * p + np.repeat(np.arange(p), np.diff(pointers))]
        terms = [self._columns.data[pointers[0] : pointers[-1]]]
        for part, functions in zip(self._elements, self._functions[front], strict=True):
            numbers = functions.astype(np.int64)
            places.append(_places(numbers[:, part.first], numbers[:, part.second], p, b).ravel())
            terms.append(part.terms[:, part.kind[part.starts[front] : part.starts[front + 1]]].ravel())
        one, other = self._of_pairs[front].astype(np.int64)
        of_pairs = self._entries(front).copy()
        of_pairs[:, one == other] *= 2.0  # a function with itself has both halves
        places.append(_places(one, other, p, b).ravel())
        terms.append(of_pairs.ravel())
        at, total = np.concatenate(places), np.zeros((p + b) * p + b * b)
        if len(at):  # else the sums would be whole numbers
            total = np.bincount(at, np.concatenate(terms), len(total)).astype(np.float64, copy=False)
        own = total[: (p + b) * p].reshape(p + b, p).copy()  # it is kept, the rest is not
        return own, total[(p + b) * p :].reshape(b, b)

    def _entries(self, front: int) -> Floats:
        """The entries (2, q, 2) of the pairs of a front."""
        return self._pairs.entries[:, slice(*self._pairs.starts[front : front + 2].tolist())]

    def keys(self) -> list[bytes]:
        """The key of every front."""
        fronts, columns = self._fronts, self._columns
        per_column = np.diff(columns.indptr)
        found: list[bytes] = []
        starts, pointers = fronts.starts.tolist(), columns.indptr[fronts.starts].tolist()
        shape = np.column_stack([np.diff(fronts.starts), fronts.n_early, fronts.n_placed])
        for front, (boundary, corner) in enumerate(zip(fronts.boundary, fronts.corner, strict=True)):
            own, begin, end = slice(starts[front], starts[front + 1]), pointers[front], pointers[front + 1]
            parts: list[NDArray[np.generic]] = [shape[front], self._relative(fronts.code[own], corner)]
            parts.append(self._relative(fronts.code[boundary], corner))
            digest = sha256()
            for part, functions in zip(self._elements, self._functions[front], strict=True):
                if len(functions):
                    parts += [part.names[part.kind[part.starts[front] : part.starts[front + 1]]], functions]
            parts += [self._of_pairs[front], self._entries(front)]
            if end > begin:
                parts += [per_column[own], self._rows[front], columns.data[begin:end]]
            for child in self._children[front]:
                digest.update(found[child])
                parts.append(fronts.corner[child] - corner)
                if self._constrained:
                    border = fronts.boundary[child]
                    parts.append(self.local(front, border[fronts.code[border] == MULTIPLIER]))
            for array in parts:
                digest.update(np.int64(array.size).tobytes() + array.tobytes())
            found.append(digest.digest())
        return found

    def _relative(self, codes: Ints, corner: int) -> Ints:
        """Codes of unknowns within a box; multipliers are not told apart."""
        return np.where(codes == MULTIPLIER, codes, codes - corner) if self._constrained else codes - corner

    def _numbered(self) -> tuple[list[Int32s], list[list[Int32s]], list[Int32s]]:
        """Front by front, the numbers in it of the rows of all entries, and of functions.

        These are those (e, k) of its elements, and those (2, q) of its pairs.
        """
        fronts, columns, pairs = self._fronts, self._columns, self._pairs
        number = np.full(len(fronts.order), OUTSIDE, dtype=np.int32)  # in one front at a time
        rows, functions, of_pairs = [], [], []
        starts, begins = fronts.starts.tolist(), pairs.starts.tolist()
        pointers = columns.indptr[fronts.starts].tolist()
        for front, boundary in enumerate(fronts.boundary):
            start, end = starts[front : front + 2]
            number[start:end] = np.arange(end - start)
            number[boundary] = np.arange(end - start, end - start + len(boundary))
            rows.append(number[columns.indices[pointers[front] : pointers[front + 1]]])
            functions.append([number[p.positions[p.starts[front] : p.starts[front + 1]]] for p in self._elements])
            of_pairs.append(number[pairs.positions[:, begins[front] : begins[front + 1]]])
            number[start:end], number[boundary] = OUTSIDE, OUTSIDE
            if min(numbers.min(initial=0) for numbers in (rows[-1], *functions[-1], of_pairs[-1])) < 0:
                raise ValueError(FAR_APART)
        return rows, functions, of_pairs


def _at_fronts(blocks: Blocks, fronts: Fronts) -> _Pairs:
    """The pairs of blocks at the fronts that eliminate the first of both functions."""
    first, second, entries = blocks.pairs
    positions = fronts.position.astype(np.int32)[2 * np.stack([first, second])]
    front = np.arange(fronts.n, dtype=np.min_scalar_type(fronts.n)).repeat(np.diff(fronts.starts))
    front = front[positions.min(axis=0)]
    order = np.argsort(front, kind="stable")  # short numbers: it takes no comparisons
    starts = np.searchsorted(front[order], np.arange(fronts.n + 1))
    return _Pairs(starts, positions.take(order, axis=1), entries.take(order, axis=1))


def _sorted(elements: Sequence[EqualElements], fronts: Fronts) -> list[_Elements]:
    """Elements in the order of their fronts."""
    found = []
    for n in sorted({part.functions.shape[1] for part in elements if part.functions.size}):
        alike = [part for part in elements if part.functions.shape[1] == n]
        positions = fronts.position[2 * np.concatenate([part.functions for part in alike])]
        kind = np.repeat(np.arange(len(alike)), [len(part.functions) for part in alike])
        front = np.searchsorted(fronts.starts, positions.min(axis=1), side="right") - 1
        order = np.argsort(front, kind="stable")
        starts = np.searchsorted(front[order], np.arange(fronts.n + 1))
        names = np.array([np.frombuffer(sha256(part.key).digest(), dtype=np.int64) for part in alike])
        first, second = np.tril_indices(n)
        matrices = np.stack([part.matrix.reshape(n, 2, n, 2) for part in alike])
        terms = np.stack([matrices[:, first, component, second] for component in (0, 1)])
        found.append(_Elements(positions[order], kind[order], starts, names, terms, first, second))
    return found


def _places(first: Ints, second: Ints, p: int, b: int) -> Ints:
    """Places (2, ..., 2) of the entries of pairs of functions in the two parts, (p + b, p) and (b, b), of a front.

    The first unknowns of the functions have the numbers `first` and `second` (...) in it. Of entries that mirror each
    other it is that in the lower triangle; a function with itself has both.
    """
    row, column = np.maximum(first, second), np.minimum(first, second)
    own = column < p
    width = np.where(own, p, b)
    at = row * width + column + np.where(own, 0, p * p - p)
    places = np.empty((2, *at.shape, 2), dtype=np.int64)
    by_first, by_second = np.where(first >= second, width, 1), np.where(first >= second, 1, width)
    for a in (0, 1):
        for c in (0, 1):
            places[a, ..., c] = at + a * by_first + c * by_second
    return places


def _lower_columns(matrix: csc_array, fronts: Fronts) -> csc_array:
    """The lower triangle (n, n) of a symmetric matrix in the order of elimination, the rows of a column ascending."""
    n_entries = np.diff(matrix.indptr)[fronts.order]
    entry = spans(matrix.indptr[fronts.order], n_entries)
    row, column = np.repeat(np.arange(len(n_entries)), n_entries), fronts.position[matrix.indices[entry]]
    lower = np.flatnonzero(column <= row)
    starts = np.searchsorted(lower, starts_of(n_entries))
    return csc_array(csr_array((matrix.data[entry[lower]], column[lower], starts), shape=matrix.shape))
