"""What values on three sizes of cells tend to: observed order and Richardson's extrapolation.

With f = f0 + c h^p on cells of sides h_3 > h_2 > h_1 the order p follows from

    (f_3 - f_2) / (f_2 - f_1) = (h_3^p - h_2^p) / (h_2^p - h_1^p),

whatever the ratios of the sides (Celik and others 2008, Procedure for estimation and reporting of uncertainty due to
discretization, J. Fluids Eng. 130, 078001), and f0 = f_1 - (f_2 - f_1) / ((h_2 / h_1)^p - 1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from scipy.optimize import brentq

LEAST_ORDER: Final = 0.5
MOST_ORDER: Final = 2.0
"""Orders that are extrapolated with: with a larger one that is an accident the finest would seem to be exact."""

ORDERS: Final = (0.05, 12.0)
"""Orders that are looked for."""

SAME_SIZE: Final = 1.05
"""Sides of cells whose ratio is less are the same."""


@dataclass(frozen=True, slots=True)
class Limit:
    """What three values tend to."""

    value: float
    order: float  # nan where the values do not approach anything from one side
    rest: float  # what the finest value is off by


def limit_of(values: Sequence[float], sizes: Sequence[float]) -> Limit:
    """The limit of three values, of the coarsest cells first, on cells of these sizes.

    Values that do not approach it from one side tend to the finest, which is off by half of what they vary, or by the
    last change if that is more.
    """
    (_, f2, f1), order = values, order_of(values, sizes)
    if math.isnan(order):
        return Limit(f1, order, max(abs(f2 - f1), 0.5 * (max(values) - min(values))))
    ratio = sizes[1] / sizes[2]
    beyond = (f1 - f2) / (ratio ** min(max(order, LEAST_ORDER), MOST_ORDER) - 1.0)
    return Limit(f1 + beyond, order, abs(beyond))


def order_of(values: Sequence[float], sizes: Sequence[float]) -> float:
    """The observed order; nan where there is none."""
    (f3, f2, f1), (h3, h2, h1) = values, sizes
    if not distinct(sizes) or f2 == f1 or (f3 - f2) / (f2 - f1) <= 0.0:
        return math.nan
    wanted = math.log((f3 - f2) / (f2 - f1))

    def excess(p: float) -> float:
        return math.log((h3**p - h2**p) / (h2**p - h1**p)) - wanted

    low, high = ORDERS
    if excess(low) > 0.0:
        return math.nan  # the changes grow
    return high if excess(high) < 0.0 else float(brentq(excess, low, high))


def distinct(sizes: Sequence[float]) -> bool:
    """Whether each of three sides is smaller than the one before."""
    return min(sizes[0] / sizes[1], sizes[1] / sizes[2]) > SAME_SIZE
