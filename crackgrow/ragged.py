"""Ragged lists: each of n rows has a list of numbers, of any length, and all of them stand in one array."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Ints

Number = TypeVar("Number", np.int64, np.complex128)


@dataclass(frozen=True, slots=True, eq=False)
class Ragged:
    """Row i has the values start[i] to start[i + 1]."""

    start: Ints  # (n + 1,)
    values: Ints  # (q,)

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self.start) - 1

    @property
    def counts(self) -> Ints:
        """Number of values of each row (n,)."""
        return np.diff(self.start)

    @property
    def row(self) -> Ints:
        """Row of each value (q,)."""
        return np.repeat(np.arange(self.n), self.counts)

    def of(self, row: int) -> Ints:
        """The values of one row."""
        return self.values[self.start[row] : self.start[row + 1]]

    def places(self, rows: Ints) -> tuple[Ints, Ints]:
        """All places in `values` of `rows` (m,), row after row.

        Returns which of the rows (p,), ascending, and the place (p,).
        """
        return places(self.start, rows)

    def taken(self, rows: Ints) -> Ragged:
        """The lists of `rows` (m,), in their order."""
        first, counts = self.start[rows], self.start[rows + 1] - self.start[rows]
        return Ragged(starts_of(counts), self.values[spans(first, counts)])

    def kept(self, which: Bools) -> Ragged:
        """The lists with those values alone that `which` (q,) marks."""
        return Ragged(np.append(0, np.cumsum(which))[self.start], self.values[which])


def starts_of(counts: Ints) -> Ints:
    """Starts (n + 1,) of lists of so many values (n,)."""
    start = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=start[1:])
    return start


def spans(first: Ints, counts: Ints) -> Ints:
    """The numbers first[i] to first[i] + counts[i] - 1 (p,), one span (n,) after the other."""
    start = starts_of(counts)
    return np.arange(start[-1]) + np.repeat(first - start[:-1], counts)


def distinct(values: NDArray[Number]) -> NDArray[Number]:
    """Return the different values among `values` (n,), ascending; sorting is faster than the hashing of np.unique."""
    ordered = np.sort(values)
    first = np.append(True, ordered[1:] != ordered[:-1])[: len(ordered)]
    return np.asarray(ordered[first])


def found_in(ascending: NDArray[Number], wanted: NDArray[Number]) -> Ints:
    """Places (m,) of `wanted` (m,) among some `ascending` numbers, each once; -1 for what is not there."""
    place = np.searchsorted(ascending, wanted)
    place[place == len(ascending)] = -1
    return np.where(ascending[place] == wanted, place, -1) if len(ascending) else place


def numbered(values: Ints, n: int) -> tuple[Ints, Ints]:
    """The distinct of values (m,) below n, ascending, and the place (m,) of each of them there; nothing is sorted."""
    seen, place = np.zeros(n, dtype=bool), np.empty(n, dtype=np.int64)
    seen[values] = True
    found = np.flatnonzero(seen)
    place[found] = np.arange(len(found))
    return found, place[values]


def places(start: Ints, rows: Ints) -> tuple[Ints, Ints]:
    """As `Ragged.places`, for lists of anything that begin at `start` (n + 1,)."""
    counts = start[rows + 1] - start[rows]
    return np.repeat(np.arange(len(rows)), counts), spans(start[rows], counts)


def by_row(row: Ints, values: Ints, n: int) -> Ragged:
    """The lists of n rows from the `row` (q,) of each value, ascending."""
    return Ragged(np.searchsorted(row, np.arange(n + 1)), values)
