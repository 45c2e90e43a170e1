"""Functions that depend on others, and are held.

Where cells of several sizes meet, patches of several sizes have corners and edges in common. Of the rock that a crack
cuts off there all of them see the same part, and some combination of them vanishes on it. So it is in a sliver of rock
between a crack and an outline: on what is thinner than some thousandth of a cell functions look alike but for what is
linear. All are small there, far smaller than the functions of whole patches, so they are told by the stiffness between
small functions alone. What depends on others takes part in no field that the others don't give: held at zero it changes
nothing. Left to the factorization it would be held, or not, by the order of the unknowns.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dpstrf
from scipy.sparse import csc_array, csr_array, tril
from scipy.sparse.csgraph import connected_components

from crackgrow.arrays import Floats, Ints
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
    shape, component = (len(between), 2, 2), np.arange(2)
    row = np.broadcast_to(2 * first[between, None, None] + component[:, None], shape)
    column = np.broadcast_to(2 * second[between, None, None] + component, shape)
    kept = small.ravel()[row] & small.ravel()[column] & (column <= row)
    some, places = numbered(np.concatenate([row[kept], column[kept]]), small.size)
    lower = csr_array((matrix.block[between][kept], np.split(places, 2)), shape=(len(some), len(some)))
    block = csc_array(lower + tril(lower, -1).T)
    held = some[_dependent(block, 1.0 / np.sqrt(np.maximum(diagonal[some], np.finfo(float).tiny)))]
    return matrix.with_diagonal(held, diagonal[held]) if len(held) else matrix


def _dependent(block: csc_array, scale: Floats) -> Ints:
    """Which unknowns of a symmetric matrix (k, k) depend on others, times `scale` (k,) from both sides."""
    _, label = connected_components(block, directed=False)
    order = np.argsort(label, kind="stable")
    ordered, scale = block[order][:, order], scale[order]
    found = []
    for start, end in pairwise(starts_of(np.bincount(label)).tolist()):
        if end - start > 1:
            own = ordered[start:end, start:end].toarray() * np.outer(scale[start:end], scale[start:end])
            _, pivots, rank, _ = dpstrf(own, tol=DEPENDENT, lower=1)
            found.append(order[start:end][pivots[rank:] - 1])
    return np.sort(np.concatenate([np.empty(0, dtype=np.int64), *found]))
