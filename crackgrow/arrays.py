"""The types of arrays, whose shape and unit stand where they are used; and a hash of what arrays hold."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]

KEY = 20
"""Bytes of a key."""


def key_of(parts: Iterable[NDArray[np.generic]]) -> bytes:
    """A key (KEY bytes) that tells what arrays hold, and how many numbers each has."""
    digest = blake2b(digest_size=KEY)
    for part in parts:
        digest.update(np.int64(part.size).tobytes())
        digest.update(np.ascontiguousarray(part).data)
    return digest.digest()
