"""The factor of a front, and where its unknowns are."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dtpttr

from crackgrow.arrays import Floats, Ints


@dataclass(slots=True, eq=False)
class Factor:
    """Columns of L that a front eliminates, and what it leaves to its parent."""

    diagonal: Floats  # (p, p) lower triangle
    below: Floats  # (b, p)
    packed: Floats | None  # (b (b + 1) / 2,) rows of the lower triangle of `update`; None until it is asked for again
    sizes: Floats  # (b,) what the front and those below it have put on the diagonal

    @property
    def update(self) -> Floats:
        """What the front leaves to its parent, (b, b) lower triangle, where it is kept."""
        return np.asarray(dtpttr(len(self.sizes), self.packed, uplo="U")[0].T)


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """The factor of a front and the places of its unknowns."""

    factor: Factor
    key: bytes  # of the factor
    start: int
    end: int
    signs: list[tuple[int, int]]  # the ranges of unknowns with D = -1
    coupled: Ints  # (b,) the later unknowns that it is coupled to
    boundary: list[tuple[int, int, int]]  # runs of it: the first unknown, begin and end in `below`


def runs(at: Ints, cut: int) -> list[tuple[int, int, int]]:
    """Runs without gaps of ascending numbers `at` (b,): first number, begin and end in `at`; split at `cut`."""
    breaks = np.flatnonzero((np.diff(at) != 1) | (at[1:] == cut)) + 1
    ends = [0, *breaks.tolist(), len(at)]
    return [(int(at[a]), a, b) for a, b in pairwise(ends)] if len(at) else []
