"""The types of arrays, whose shape and unit stand where they are used; constant arrays; a hash of what arrays hold."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]

KEY = 20
"""Bytes of a key."""


def frozen(values: object) -> Floats:
    """Return a float array that cannot be written to."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def key_of(parts: Iterable[NDArray[np.generic]]) -> bytes:
    """A key (KEY bytes) that tells what arrays hold, and how many numbers each has."""
    digest = sha256()  # processors have instructions for it
    for part in parts:
        digest.update(part.size.to_bytes(8, "little"))
        digest.update(np.ascontiguousarray(part).data)
    return digest.digest()[:KEY]
