"""The four tip functions sqrt(r) {cos t/2, sin t/2, cos 3t/2, sin 3t/2}, paper eq. (1), on kinked cracks.

Where the crack is no longer one line as seen from the tip they fade out with chi = (1 - (r/L)^2)^2, L = `TipView.fade`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.compiled import kernel
from crackgrow.cover.tips import TipView


def tip_table(tips: Sequence[TipView]) -> Floats:
    """What the kernels need of tips (t, 7): the point, the rotation row by row, the length L."""
    return np.array([[*tip.point, *tip.rotation.ravel(), tip.fade] for tip in tips]).reshape(-1, 7)


@kernel
def tip_functions(x: float, y: float, tip: Floats, side: float, f: Floats) -> None:
    """Put the four functions of a tip, a row of `tip_table`, at a point into f[0], and their derivatives into f[1:].

    f: (3, 4), per lattice spacing and by x and y; the point is on the side of the crack that has the angle `side`. At
    the tip itself the derivatives are infinite, and put at zero.
    """
    u, v = x - tip[0], y - tip[1]
    p, q = tip[2] * u + tip[3] * v, tip[4] * u + tip[5] * v
    r, t = math.hypot(p, q), math.atan2(q, p)
    t += 2.0 * math.pi * np.round((side - t) / (2.0 * math.pi))
    root = math.sqrt(r)
    per_root = 1.0 / root if r > 0.0 else 0.0
    chi, slope_of_chi = 1.0, 0.0
    if tip[6] < np.inf:
        rest = max(1.0 - (r / tip[6]) ** 2, 0.0)
        chi, slope_of_chi = rest * rest, -4.0 * rest * r / tip[6] ** 2
    cosine, sine = math.cos(t), math.sin(t)
    away_x, away_y = (
        cosine * tip[2] - sine * tip[3],
        cosine * tip[3] + sine * tip[2],
    )  # from the tip; along: turned left
    for pair in range(2):
        m = 0.5 + pair
        c, s = math.cos(m * t), math.sin(m * t)
        for k, angular, slope in ((2 * pair, c, -m * s), (2 * pair + 1, s, m * c)):
            by_r = angular * (0.5 * per_root * chi + root * slope_of_chi)
            by_t = per_root * slope * chi  # (1/r) d/dt
            f[0, k] = root * angular * chi
            f[1, k], f[2, k] = away_x * by_r - away_y * by_t, away_y * by_r + away_x * by_t
