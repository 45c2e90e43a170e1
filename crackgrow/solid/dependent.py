"""Functions that depend on others, and are held.

Where cells of several sizes meet, patches of several sizes have corners and edges in common. Of the rock that a crack
cuts off there all of them see the same part, and some combination of them vanishes on it. So it is in a sliver of rock
between a crack and an outline: on what is thinner than some thousandth of a cell functions look alike but for what is
linear. All are small there, far smaller than the functions of whole patches, so they are told by the stiffness between
small functions alone. What depends on others takes part in no field that the others don't give: held at zero it changes
nothing. Left to the factorization it would be held, or not, by the order of the unknowns.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import dependent_of, kernel
from crackgrow.geometry.arrangement import connected
from crackgrow.linear import DEPENDENT, SymmetricMatrix
from crackgrow.ragged import numbered, starts_of

SMALL = 1e-3
"""Functions with less than this part of the largest stiffness of those that they meet see a corner of their patch
alone."""


def with_dependent_held(matrix: SymmetricMatrix) -> SymmetricMatrix:
    """The stiffness matrix with springs at unknowns that depend on others, each as stiff as its own entry."""
    diagonal, first, second = matrix.diagonal(), matrix.row, matrix.column
    each = diagonal.reshape(-1, 2)
    least = each.min(axis=1) < SMALL * each.max(initial=0.0)  # the others are large whatever they meet
    met = np.zeros(len(each))
    for one, other in ((first, second), (second, first)):
        at = np.flatnonzero(least[one])
        np.maximum.at(met, one[at], each[other[at]].max(axis=1))
    small = each < SMALL * met[:, None]
    is_small = np.logical_or(*small.T)
    if not is_small.any():
        return matrix
    between = np.flatnonzero(is_small[first] & is_small[second])
    functions, place = numbered(np.concatenate([first[between], second[between]]), len(each))
    row, column = np.split(place, 2)
    label = connected(len(functions), row, column)
    group = np.argsort(label, kind="stable")
    limits = starts_of(np.bincount(label))
    of_block = np.argsort(label[row], kind="stable")
    found = _dependent(
        limits, group, starts_of(np.bincount(label[row])), row[of_block], column[of_block],
        matrix.block[between[of_block]], small[functions],
    )  # fmt: skip
    held = 2 * functions[found // 2] + found % 2
    return matrix.with_diagonal(held, diagonal[held]) if len(held) else matrix


@kernel
def _dependent(limits: Ints, group: Ints, at: Ints, row: Ints, column: Ints, block: Floats, small: Bools) -> Ints:
    """Give the small unknowns that depend on others of their group, each group scaled to a unit diagonal.

    Group g has the functions group[limits[g]:limits[g + 1]], and the blocks (q, 2, 2) from at[g] on, at `row` and
    `column`; `small` (functions, 2) are its unknowns that take part.
    """
    found, number, n_found = np.empty(small.size, np.int64), np.full(small.shape, -1), 0
    for g in range(len(limits) - 1):
        unknowns = [(f, c) for f in group[limits[g] : limits[g + 1]] for c in range(2) if small[f, c]]
        for k, (f, c) in enumerate(unknowns):
            number[f, c] = k
        own = np.zeros((len(unknowns), len(unknowns)))
        for q in range(at[g], at[g + 1]):
            for c in range(2):
                for d in range(2):
                    i, j = number[row[q], c], number[column[q], d]
                    if i >= 0 and j >= 0:
                        own[min(i, j), max(i, j)] = block[q, c, d]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(own), np.finfo(np.float64).tiny))
        for i in range(len(own)):
            for j in range(i, len(own)):
                own[i, j] *= scale[i] * scale[j]
        for k in dependent_of(own, DEPENDENT):
            found[n_found] = 2 * unknowns[k][0] + unknowns[k][1]
            n_found += 1
    return np.sort(found[:n_found])
