"""A symmetric matrix as the sum of equal element matrices at many places, of blocks, and of a sparse rest.

The elements away from cracks and outlines are alike: their sum is never formed. Products gather the unknowns of all
elements, multiply them by the one element matrix, and add up what comes out. Blocks are the matrices of all others, of
some functions each; of their sum one half is formed, part by part: a part whose blocks are known is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, get_index_dtype

from crackgrow.arrays import Floats, Ints, key_of
from crackgrow.ragged import starts_of
from crackgrow.solid.halves import HalfMatrix, half, sum_of

Int32s = NDArray[np.int32]

AT_ONCE = 4_000_000
"""Numbers that a product or a sum holds at once."""

NONE = np.empty(0, dtype=np.int32)


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


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """The sum of some blocks."""

    key: bytes  # a hash of these blocks, and of which functions they have in common
    functions: Ints  # (k,)
    sum: HalfMatrix

    @property
    def dofs(self) -> Ints:
        """The unknowns (2 k,)."""
        return (2 * self.functions[:, None] + np.arange(2)).ravel()


@dataclass(frozen=True, eq=False)
class Blocks:
    """The sum of symmetric matrices of some functions each, in parts."""

    parts: tuple[Part, ...] = ()

    @cached_property
    def pairs(self) -> tuple[Int32s, Int32s, Floats]:
        """First and second functions (p,) of the halves of all parts, and their entries (2, p, 2)."""
        return (
            np.concatenate([NONE, *(functions.repeat(part.sum.counts) for part, functions in self._each)]),
            np.concatenate([NONE, *(functions[part.sum.second] for part, functions in self._each)]),
            np.concatenate([np.empty((2, 0, 2)), *(part.sum.entries for part in self.parts)], axis=1),
        )

    @property
    def _each(self) -> list[tuple[Part, Int32s]]:
        """The parts with their functions, in short numbers: sparse products read less."""
        return [(part, part.functions.astype(np.int32)) for part in self.parts]

    @cached_property
    def _rows(self) -> tuple[Int32s, csr_array]:
        """The unknown of each row (r,) of the halves of all parts, one below the other, and these (r, unknowns).

        With P (r, unknowns) that has a 1 at the unknown of each row, and these rows H, the sum is P' H + H' P.
        """
        _, second, entries = self.pairs
        first = 2 * np.concatenate([NONE, *(functions for _, functions in self._each)])
        dofs, columns = np.append(first, first + 1), np.tile((2 * second[:, None] + np.arange(2)).ravel(), 2)
        counts = np.tile(np.concatenate([NONE, *(part.sum.counts for part in self.parts)]), 2)
        starts = (2 * starts_of(counts)).astype(get_index_dtype(maxval=entries.size))
        shape = (len(dofs), int(dofs.max(initial=-1)) + 1)
        return dofs, csr_array((entries.ravel(), columns, starts), shape=shape)

    def __matmul__(self, vectors: Floats) -> Floats:
        """The product of the sum with vectors (n,) or (n, m)."""
        return _summed(*self._rows, vectors)

    def sizes(self, vectors: Floats) -> Floats:
        """The product of the absolute values with vectors (n,) or (n, m)."""
        dofs, rows = self._rows
        return _summed(dofs, csr_array((np.abs(rows.data), rows.indices, rows.indptr), shape=rows.shape), vectors)


def _summed(dofs: Int32s, rows: csr_array, vectors: Floats) -> Floats:
    """The product of P' H + H' P, as of `Blocks`, with vectors (n,) or (n, m)."""
    total, (r, n) = np.zeros(vectors.shape), rows.shape
    places = csr_array((np.ones(r), dofs, np.arange(r + 1, dtype=np.int32)), shape=(r, n))
    total[:n] = places.T @ (rows @ vectors[:n]) + rows.T @ vectors[dofs]
    return total


def blocks_of(
    functions: Sequence[Ints], halves: Sequence[HalfMatrix], group: Ints, before: Blocks | None = None
) -> Blocks:
    """The sum of the `halves` of matrices of some `functions` (k,) each, in parts: one for each `group` (blocks,).

    Parts that the blocks `before` had are taken over.
    """
    known = {} if before is None else {part.key: part.sum for part in before.parts}
    order = np.argsort(group, kind="stable")
    parts = []
    for some in np.split(order, np.flatnonzero(np.diff(group[order])) + 1) if len(group) else ():
        own = [functions[block] for block in some.tolist()]
        together, place = np.unique(np.concatenate(own), return_inverse=True)
        keys = [np.frombuffer(halves[block].key, dtype=np.uint8) for block in some.tolist()]
        key = key_of((place, *keys))
        total = known.get(key)
        if total is None:
            local = np.split(place[None], np.cumsum([len(ids) for ids in own])[:-1], axis=1)
            own_halves = (halves[block] for block in some.tolist())
            total = sum_of(zip(local, own_halves, strict=True), len(together))
        parts.append(Part(key, together, total))
    return Blocks(tuple(parts))


@dataclass(frozen=True, eq=False)
class Summed:
    """The sum (n, n) of `elements`, of a sparse `rest` (n, n), and of `blocks`."""

    elements: tuple[EqualElements, ...]
    rest: csc_array
    blocks: Blocks = Blocks()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return (self.rest.shape[0], self.rest.shape[1])

    def __matmul__(self, vectors: Floats) -> Floats:
        """The product with vectors (n,) or (n, m)."""
        return self.blocks @ vectors + _product(self.elements, self.rest, vectors)

    def sizes(self, vectors: Floats) -> Floats:
        """The product of the absolute values of all terms with those of vectors (n,) or (n, m)."""
        return self.blocks.sizes(np.abs(vectors)) + _product(*self._absolute, np.abs(vectors))

    def diagonal(self) -> Floats:
        """The diagonal (n,)."""
        total = self.rest.diagonal()
        for block in self.blocks.parts:
            total[block.dofs] += block.sum.diagonal
        for part in self.elements:
            own = part.matrix.diagonal()
            for component in (0, 1):
                dofs, shares = 2 * part.functions.ravel() + component, np.tile(own[component::2], len(part.functions))
                total += np.bincount(dofs, shares, len(total))
        return np.asarray(total)

    def largest(self) -> float:
        """The largest absolute value of a term; nan where a value is none."""
        terms = [self.rest.data, *(part.matrix for part in self.elements)]
        return _largest([*terms, np.array([block.sum.largest for block in self.blocks.parts])])

    def with_diagonal(self, places: Ints, values: Floats) -> Summed:
        """The sum with a diagonal matrix that has `values` (k,) at `places` (k,)."""
        more = csc_array((values, (places, places)), shape=self.shape)
        return replace(self, rest=csc_array(self.rest + more))

    def tocsc(self) -> csc_array:
        """The sum as one sparse matrix."""
        total = self.rest
        for block in self.blocks.parts:
            entries = block.sum.tocsc().tocoo()
            total = total + csc_array((entries.data, (block.dofs[entries.row], block.dofs[entries.col])), self.shape)
        for part in self.elements:
            own = part.half
            step = max(1, AT_ONCE // own.entries.size)
            for start in range(0, len(part.functions), step):
                some = sum_of([(part.functions[start : start + step], own)], (self.shape[0] + 1) // 2).tocsc()
                some.resize(self.shape)  # there may be multipliers
                total = total + some
        return csc_array(total)

    @cached_property
    def _absolute(self) -> tuple[tuple[EqualElements, ...], csc_array]:
        """Elements and rest with the absolute values of all terms."""
        return tuple(replace(part, matrix=np.abs(part.matrix)) for part in self.elements), abs(self.rest)


def _largest(terms: Iterable[Floats]) -> float:
    """The largest absolute value of some arrays; nan where a value is none."""
    return max((float(np.abs(values).max(initial=0.0)) for values in terms), key=lambda x: (np.isnan(x), x))


def _product(elements: Sequence[EqualElements], rest: csc_array, vectors: Floats) -> Floats:
    """The product of vectors (n,) or (n, m) with the sum of elements and of a rest."""
    total = np.asarray(rest @ vectors)
    if not elements:
        return total
    columns = total.reshape(len(total), -1)
    for k, vector in enumerate(vectors.reshape(len(total), -1).T):
        pairs, sums = vector[: len(total) // 2 * 2].reshape(-1, 2), np.zeros((len(total) // 2, 2))
        for part in elements:
            step = max(1, AT_ONCE // len(part.matrix))
            for start in range(0, len(part.functions), step):
                functions = part.functions[start : start + step]
                forces = (pairs[functions].reshape(len(functions), -1) @ part.matrix).reshape(-1, 2)
                for component in (0, 1):
                    sums[:, component] += np.bincount(functions.ravel(), forces[:, component], len(sums))
        columns[: sums.size, k] += sums.ravel()
    return columns.reshape(total.shape)
