"""The weight of moving least squares: a cubic spline."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats


def cubic_spline(q: Floats) -> tuple[Floats, Floats]:
    """Cubic spline w(q) and its derivative dw/dq at q >= 0, zero from q = 1 on (Belytschko, Lu, Gu 1994, eq. 25)."""
    whole, inner = np.maximum(1.0 - q, 0.0), np.maximum(0.5 - q, 0.0)
    whole_squared, inner_squared = whole * whole, inner * inner
    whole *= whole_squared
    inner *= inner_squared
    inner *= 4.0
    whole -= inner
    whole *= 4.0 / 3.0
    inner_squared *= 4.0
    inner_squared -= whole_squared
    inner_squared *= 4.0
    return whole, inner_squared
