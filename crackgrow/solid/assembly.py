"""The sum of element matrices of very different sizes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, csc_array, csr_array

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class MatrixSum:
    """A sum of element matrices, kept at the places that it can fill, which the elements' functions give beforehand.

    Near tips every entry is the sum of many terms: a list of all terms, summed at the end, is many times larger.
    """

    def __init__(self, start: Ints, ids: Ints, n_functions: int) -> None:
        """Element e has the functions `ids[start[e] : start[e + 1]]`."""
        self._n = n_functions
        shape = (len(start) - 1, n_functions)
        carries = csr_array((np.ones(len(ids), dtype=np.int32), ids, start), shape=shape)
        self._pattern = csr_array(carries.T @ carries)
        self._pattern.sort_indices()
        row = np.repeat(np.arange(n_functions), np.diff(self._pattern.indptr))
        self._places = row * n_functions + self._pattern.indices
        self._entries = np.zeros((len(self._places), 2, 2))

    def add(self, ids: Ints, matrix: Floats) -> None:
        """Add an element matrix (k, 2, k, 2) of the functions `ids` (k,), each of which occurs once."""
        at = np.searchsorted(self._places, ids[:, None] * self._n + ids)
        self._entries[at] += matrix.transpose(0, 2, 1, 3)

    def matrix(self) -> csc_array:
        """The sum (n_dofs, n_dofs): functions by components."""
        blocks = (self._entries, self._pattern.indices, self._pattern.indptr)
        return csc_array(bsr_array(blocks, shape=(2 * self._n, 2 * self._n)))
