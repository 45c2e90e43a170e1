"""Vectors of the plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def cross(a: Floats, b: Floats) -> Floats:
    """Cross product (...) of vectors a and b (..., 2): twice the area of the triangle on them, positive from a to the
    left to b."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
