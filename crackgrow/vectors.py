"""Vectors of the plane."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats


def cross(a: Floats, b: Floats) -> Floats:
    """Cross product (...) of vectors a and b (..., 2): twice the area of the triangle on them, positive from a to the
    left to b."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
