"""Vectors of the plane."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats


def cross(a: Floats, b: Floats) -> Floats:
    """Cross product (...) of vectors a and b (..., 2): twice the area of the triangle on them, positive from a to the
    left to b."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def outward_normals(steps: Floats) -> Floats:
    """Unit vectors (n, 2) to the right of steps (n, 2) along outlines, which have the rock on their left.

    A step of no length has (0, 0).
    """
    across = np.stack([steps[:, 1], -steps[:, 0]], axis=1)
    return np.asarray(across / np.maximum(np.hypot(*steps.T), np.finfo(float).tiny)[:, None])


def across(stress: Floats, normal: Floats) -> Floats:
    """Stress vectors (n, 2) Pa of stresses (n, 3) on surfaces with unit normals (n, 2)."""
    xx, yy, xy = stress.T
    x, y = normal.T
    return np.stack([xx * x + xy * y, xy * x + yy * y], axis=1)
