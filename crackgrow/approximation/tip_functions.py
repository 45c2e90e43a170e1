"""The four tip functions on kinked cracks, which span the displacement of all modes near a tip.

With z_j = x + s_j y in the tip's axes and the two roots s_j of the rock they are the real and imaginary parts of

    sqrt(z_1),    (sqrt(z_2) - sqrt(z_1)) / (s_2 - s_1) = y / (sqrt(z_1) + sqrt(z_2)),

of which Sih, Paris, Irwin 1965 have the sqrt(z_j) alone: those are alike where the roots are, as in isotropic rock, and
there these span sqrt(r) {cos t/2, sin t/2, cos 3t/2, sin 3t/2}, paper eq. (1). Where the crack is no longer one line as
seen from the tip they fade out with chi = (1 - (r/L)^2)^2, L = `TipView.fade`.
"""

from __future__ import annotations

import math

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.compiled import kernel


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
    if r == 0.0:
        f[:] = 0.0
        return
    chi, slope_of_chi = 1.0, 0.0
    if tip[6] < np.inf:
        rest = max(1.0 - (r / tip[6]) ** 2, 0.0)
        chi, slope_of_chi = rest * rest, -4.0 * rest / tip[6] ** 2  # the slope over r
    s_1, s_2, c, s = complex(tip[7], tip[8]), complex(tip[9], tip[10]), math.cos(0.5 * t), math.sin(0.5 * t)
    root_1 = _root(p + s_1.real * q, s_1.imag * q, c, s)
    root_2 = root_1 if s_2 == s_1 else _root(p + s_2.real * q, s_2.imag * q, c, s)
    per_1, per_2, per_both = _inverse(root_1), _inverse(root_2), _inverse(root_1 + root_2)
    for pair in range(2):
        if pair == 0:
            value, by_p, by_q = root_1, 0.5 * per_1, 0.5 * s_1 * per_1
        else:
            value, by_p = q * per_both, -0.5 * q * per_both * per_1 * per_2
            by_q = (1.0 - 0.5 * value * (s_1 * per_1 + s_2 * per_2)) * per_both
        a, a_p, a_q = value.real, by_p.real, by_q.real
        for k in (2 * pair, 2 * pair + 1):
            d_p, d_q = chi * a_p + slope_of_chi * p * a, chi * a_q + slope_of_chi * q * a
            f[0, k] = chi * a
            f[1, k], f[2, k] = tip[2] * d_p + tip[4] * d_q, tip[3] * d_p + tip[5] * d_q
            a, a_p, a_q = value.imag, by_p.imag, by_q.imag


@kernel
def _root(x: float, y: float, c: float, s: float) -> complex:
    """sqrt(x + i y) whose angle is nearer to that of c + i s: that of z is within pi of t, on whatever turn that is."""
    size = math.hypot(x, y)
    if x > 0.0:
        re = math.sqrt(0.5 * (size + x))
        im = 0.5 * y / re
    else:
        im = math.sqrt(0.5 * (size - x))
        re = 0.5 * y / im
    return complex(re, im) if re * c + im * s > 0.0 else complex(-re, -im)


@kernel
def _inverse(z: complex) -> complex:
    """1 / z, without the care for overflow that a division of complex numbers takes."""
    size = z.real * z.real + z.imag * z.imag
    return complex(z.real / size, -z.imag / size)
