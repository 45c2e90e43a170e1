"""The four tip functions sqrt(r) {cos t/2, sin t/2, cos 3t/2, sin 3t/2}, paper eq. (1), on kinked cracks.

Where the crack is no longer one line as seen from the tip they fade out with chi = (1 - (r/L)^2)^2, L = `TipView.fade`.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.cover.tips import TipView


def tip_functions(tip: TipView, r: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Values (n, 4) and gradients (n, 4, 2), per lattice spacing and in lattice axes, at polar coordinates r, t (n,).

    At r = 0 the gradients are infinite; zero is returned there. Inside, and in memory, the points run last.
    """
    root = np.sqrt(r)
    cosines, sines, angular = _angular(t)
    slope = np.stack([-0.5 * sines[0], 0.5 * cosines[0], -1.5 * sines[1], 1.5 * cosines[1]])
    value = root * angular
    over_root = np.divide(1.0, root, out=np.zeros_like(root), where=root > 0.0)
    by_r = 0.5 * over_root * angular
    by_t = over_root * slope  # (1/r) d/dt
    if np.isfinite(tip.fade):
        rest = np.maximum(1.0 - (r / tip.fade) ** 2, 0.0)
        chi, dchi = rest**2, -4.0 * rest * r / tip.fade**2
        by_r = by_r * chi + value * dchi
        by_t = by_t * chi
        value = value * chi
    (away_x, away_y), (along_x, along_y) = _axes(tip, t)
    gradient = np.stack([away_x * by_r + along_x * by_t, away_y * by_r + along_y * by_t])
    return value.T, gradient.transpose(2, 1, 0)


def tip_values(tip: TipView, r: Floats, t: Floats) -> Floats:
    """The values (n, 4) of `tip_functions` alone."""
    fade = np.maximum(1.0 - (r / tip.fade) ** 2, 0.0) ** 2
    return np.asarray((np.sqrt(r) * fade * _angular(t)[2]).T)


def _angular(t: Floats) -> tuple[Floats, Floats, Floats]:
    """Cosines and sines (2, n) of t/2 and 3t/2, and both (4, n) in the order of the functions."""
    arguments = np.stack([0.5 * t, 1.5 * t])
    cosines, sines = np.cos(arguments), np.sin(arguments)
    return cosines, sines, np.stack([cosines[0], sines[0], cosines[1], sines[1]])


def _axes(tip: TipView, t: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Unit vectors, by their components (n,) in lattice axes, of growing r and of growing t."""
    (x, y), c, s = tip.rotation[0], np.cos(t), np.sin(t)
    away_x, away_y = c * x - s * y, c * y + s * x
    return (away_x, away_y), (-away_y, away_x)
