"""Cells of the tables of studies, as CSV has them."""

from __future__ import annotations

import math


def cell_text(value: str | float | int | None) -> str:
    """The value, a float to its last digit; empty where there is none."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(value) if isinstance(value, float) else str(value)
