"""Large dense symmetric matrices, panel by panel of their lower triangle: each is small enough for the cache."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crackgrow.arrays import Floats

PANEL = 256
"""Rows and columns of a panel."""


def lower_panels(k: int) -> Iterator[tuple[slice, slice]]:
    """Rows and columns of the panels that the lower triangle of a matrix (k, k) has a part in."""
    for first in range(0, k, PANEL):
        for before in range(0, first + 1, PANEL):
            yield slice(first, first + PANEL), slice(before, before + PANEL)


def fill_upper(lower: Floats) -> None:
    """Copy the lower triangle of a matrix (k, k) to the upper one: it is symmetric to the last bit then."""
    for rows, columns in lower_panels(len(lower)):
        panel = lower[rows, columns]
        if rows == columns:
            panel[...] = np.tril(panel) + np.tril(panel, -1).T
        else:
            lower[columns, rows] = panel.T
