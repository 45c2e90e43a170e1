"""Where lines are cut so that Gauss points on the pieces integrate what varies along them.

Points along edges are as many as the functions of the cells ask for. A load by a formula knows nothing of the cells: a
peak narrower than a cell would fall between the points, on cells of all sizes that are tried alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.quadrature.rims import POINTS_PER_EDGE
from crackgrow.quadrature.rules import gauss

SHARE = 1e-6
"""Of the integral of the absolute value along all lines: a piece that is off by less is not halved."""

PARTS = 32
"""A piece is held against so many parts of it: what is narrower than about a sixtieth of it can be missed."""

MOST_LEVELS = 12
"""Pieces are not halved more often: beside a kink of a formula the rest is 1e-7 of what it was."""


def subdivided(ends: Floats, values: Callable[[Floats, Ints], Floats]) -> tuple[Ints, Floats]:
    """Pieces of lines with ends (n, 2, 2): the line (k,) of each, sorted, and the fractions (k, 2) it lies between.

    `values` gives what is integrated (m, c) at places (m, 2) on the lines (m,). Without need each line is one piece.
    """
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)

    def integrals(line: Ints, low: Floats, high: Floats, parts: int) -> tuple[Floats, Floats]:
        """Integrals (m, c) over pieces of lines (m,), and of the absolute value (m, c)."""
        x, w = gauss(POINTS_PER_EDGE)
        at = ((np.arange(parts)[:, None] + x) / parts).ravel()
        fraction = low[:, None] + (high - low)[:, None] * at
        places = ends[line, 0][:, None] + fraction[:, :, None] * (ends[line, 1] - ends[line, 0])[:, None]
        found = values(places.reshape(-1, 2), np.repeat(line, len(at))).reshape(len(line), len(at), -1)
        weights = ((high - low) * length[line])[:, None] * np.tile(w / parts, parts)
        return np.einsum("mp,mpc->mc", weights, found), np.einsum("mp,mpc->mc", weights, np.abs(found))

    line, low, high = np.arange(len(ends)), np.zeros(len(ends)), np.ones(len(ends))
    done: list[tuple[Ints, Floats, Floats]] = []
    enough = np.inf
    for level in range(MOST_LEVELS + 1):
        fine, size = integrals(line, low, high, PARTS)
        enough = SHARE * float(size.sum()) if level == 0 else enough
        off = np.abs(fine - integrals(line, low, high, 1)[0]).max(axis=1, initial=0.0) > enough
        off &= level < MOST_LEVELS
        done.append((line[~off], low[~off], high[~off]))
        middle = 0.5 * (low + high)[off]
        line = np.concatenate([line[off], line[off]])
        low, high = np.concatenate([low[off], middle]), np.concatenate([middle, high[off]])
        if len(line) == 0:
            break
    line, low, high = (np.concatenate(arrays) for arrays in zip(*done, strict=True))
    order = np.lexsort([low, line])
    return line[order], np.stack([low, high], axis=1)[order]
