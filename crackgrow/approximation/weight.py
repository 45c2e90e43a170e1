"""The weight of moving least squares: a cubic spline."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats


def cubic_spline(q: Floats) -> tuple[Floats, Floats]:
    """Cubic spline w(q) and its derivative dw/dq at q >= 0, zero from q = 1 on (Belytschko, Lu, Gu 1994, eq. 25)."""
    inner = q <= 0.5
    rest = np.maximum(1.0 - q, 0.0)
    w = np.where(inner, 2.0 / 3.0 - 4.0 * q**2 + 4.0 * q**3, 4.0 / 3.0 * rest**3)
    dw = np.where(inner, -8.0 * q + 12.0 * q**2, -4.0 * rest**2)
    return w, dw
