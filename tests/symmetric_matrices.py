"""Symmetric matrices between plain and sparse ones and those by lower blocks; systems in one dense front."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array, csr_array, tril

from crackgrow.linear import ConstrainedSystem, SymmetricMatrix

Ints = NDArray[np.int64]


def symmetric(matrix: Any) -> SymmetricMatrix:
    """A symmetric matrix (2 n, 2 n), dense or sparse, by its lower blocks."""
    dense = matrix.toarray() if hasattr(matrix, "toarray") else np.asarray(matrix)
    n = len(dense) // 2
    row, column = np.tril_indices(n)
    block = dense.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)[row, column]
    kept = (row == column) | (block != 0.0).any(axis=(1, 2))
    return SymmetricMatrix(np.searchsorted(row[kept], np.arange(n + 1)), column[kept], block[kept])


def whole(matrix: SymmetricMatrix) -> csc_array:
    """All of a matrix."""
    lower = bsr_array((matrix.block, matrix.column, matrix.start), shape=matrix.shape).tocsr()
    total = csc_array(tril(lower) + tril(lower, -1).T)
    total.eliminate_zeros()
    return total


def one_front(n: int) -> tuple[Ints, Ints]:
    """Boxes of n functions that all overlap."""
    alike = np.zeros((n, 2), dtype=np.int64)
    return alike, alike + 1


def dense_system(matrix: Any, constraints: csr_array) -> ConstrainedSystem:
    """A matrix with constraints, factorized in one dense front."""
    return ConstrainedSystem(symmetric(matrix), constraints, one_front(matrix.shape[0] // 2))
