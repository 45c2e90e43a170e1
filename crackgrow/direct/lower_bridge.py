"""Temporary."""

import numpy as np
from scipy.sparse import csc_array

from crackgrow.direct.assembly import HalfMatrix
from crackgrow.direct.matrix import Blocks, Part, SymmetricMatrix


def from_lower(start, column, block):
    n = len(start) - 1
    row = np.repeat(np.arange(n), np.diff(start))
    order = np.lexsort((row, column))
    first, second, b = column[order], row[order], block[order]
    b = b * np.where(first == second, 0.5, 1.0)[:, None, None]
    entries = np.ascontiguousarray(b.transpose(2, 0, 1))  # (component of first=column, pair, component of second=row)
    half = HalfMatrix(np.bincount(first, minlength=n), second.astype(np.int32), entries)
    return SymmetricMatrix((), csc_array((2 * n, 2 * n)), Blocks((Part(b"all", np.arange(n), half),)))
