"""Functions that depend on others, and are held.

Where cells of several sizes meet, patches of several sizes have corners and edges in common. Of the rock that a crack
cuts off there all of them see the same part, and some combination of them vanishes on it. So it is in a sliver of rock
between a crack and an outline: on what is thinner than some thousandth of a cell functions look alike but for what is
linear. All are small there, far smaller than the functions of whole patches, so they are told by the stiffness between
small functions alone. What depends on others takes part in no field that the others don't give: held at zero it changes
nothing. Left to the factorization it would be a pivot that is replaced, or is not, by the order of the unknowns, and
what bends the sliver would be stiffened with it.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg.lapack import dpstrf
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import connected_components

from crackgrow.arrays import Floats, Ints
from crackgrow.direct import SymmetricMatrix, mirrored
from crackgrow.ragged import starts_of

SMALL = 1e-3
"""Functions with less than this part of the largest stiffness of those that they meet see a corner of their patch
alone."""

DEPENDENT = 1e-11
"""Pivots below this part of the entry on the diagonal are those of functions that depend on others."""


def with_dependent_held(matrix: SymmetricMatrix) -> SymmetricMatrix:
    """The stiffness matrix with springs at unknowns that depend on others, each as stiff as its own entry.

    Only the blocks of the matrix are looked at: small functions are those of cut patches.
    """
    diagonal = matrix.diagonal()
    met = np.zeros(len(diagonal))
    for part in matrix.blocks.parts:
        met[part.dofs] = np.maximum(met[part.dofs], part.sum.met(diagonal[part.dofs], SMALL))
    small = np.flatnonzero(diagonal < SMALL * met)
    if len(small) == 0:
        return matrix
    scale = 1.0 / np.sqrt(np.maximum(diagonal[small], np.finfo(float).tiny))
    block = _among(matrix, small)
    held = small[_dependent(block, scale)]
    return matrix.with_diagonal(held, diagonal[held]) if len(held) else matrix


def _among(matrix: SymmetricMatrix, some: Ints) -> csc_array:
    """What the blocks of a matrix (n, n) have between some unknowns (k,): (k, k)."""
    number = np.full(matrix.shape[0], -1)
    number[some] = np.arange(len(some))
    entries, rows, columns = [np.empty(0)], [some[:0]], [some[:0]]
    for part in matrix.blocks.parts:
        mine = number[part.dofs]
        local = np.flatnonzero(mine >= 0)
        if len(local):
            found, row, column = part.sum.among(local)
            entries.append(found)
            rows.append(mine[local[row]])
            columns.append(mine[local[column]])
    places = (np.concatenate(rows), np.concatenate(columns))
    return mirrored(csr_array((np.concatenate(entries), places), shape=(len(some), len(some))))


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
