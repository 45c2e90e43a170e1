"""Principal stresses in the plane, for output."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats


def principal_stresses(stress: Floats) -> tuple[Floats, Floats]:
    """Major (most tensile) and minor principal stress in the plane, each (n,), of `stress` (n, 3): xx, yy, xy."""
    xx, yy, xy = stress.T
    centre = (xx + yy) / 2
    radius = np.hypot((xx - yy) / 2, xy)
    return centre + radius, centre - radius
