"""The kernel of tip functions at many points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crackgrow.approximation.tip_functions import tip_functions, tip_table
from crackgrow.cover.tips import TipView


def at_polar(tip: TipView, r: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values (n, 4) and gradients (n, 4, 2) at polar coordinates (n,) round a tip, on the side that the angles say."""
    points = (r * np.array([np.cos(t), np.sin(t)])).T @ tip.rotation
    (row,), found = tip_table([replace(tip, point=np.zeros(2))]), np.empty((len(r), 3, 4))
    for point, side, f in zip(points, t, found, strict=True):
        tip_functions(*point, row, side, f)
    return found[:, 0], found[:, 1:].transpose(0, 2, 1)
