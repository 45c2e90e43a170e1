"""The singular fields of a crack tip (Williams 1957) in the tip's axes: x outward, y to the left.

u = sqrt(r / 2 pi) g(t) / (2 shear modulus) with K = 1. The angle t may be counted so that it jumps on a kinked crack
(`cover.tips`): continued like that the fields are exact in the body slit along that crack, though free of traction on
the last straight segment only.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.solid.elasticity import PlaneElasticity

RATES = np.array([0.5, 1.5, 0.5, 1.5])
"""Of the angles t/2 and 3t/2."""


def williams_gradient(material: PlaneElasticity, r: Floats, t: Floats) -> Floats:
    """Displacement gradient du_c/dx_d (n, 2, 2, 2) [point, mode, c, d] of K_I = 1 and K_II = 1 at r, t (n,).

    In memory the points run last.
    """
    shape, slope = _shapes(material, t)
    over_root = 1.0 / np.sqrt(r)
    by_r, by_t = 0.5 * over_root * shape, over_root * slope  # d/dr and (1/r) d/dt
    c, s = np.cos(t), np.sin(t)
    return np.stack([c * by_r - s * by_t, s * by_r + c * by_t], axis=2).transpose(3, 0, 1, 2)


def point_force_gradient(material: PlaneElasticity, r: Floats, t: Floats) -> Floats:
    """Displacement gradient du_c/dx_d (n, 2, 2) of a force E' along x on the tip, at r, t (n,).

    Its stress is radial, -E' cos t / (pi r) (Kfouri 1986, eq. 8), leaves all faces through the tip free, and is the
    same on both sides of them.
    """
    c, s = np.cos(t), np.sin(t)
    radial, around, turn = -c, material.c12 / material.c11 * c, s  # strains and rotation times pi r
    xx, yy = radial * c**2 + around * s**2, radial * s**2 + around * c**2
    xy = (radial - around) * c * s
    gradient = np.array([[xx, xy - turn], [xy + turn, yy]]) / (np.pi * r)
    return gradient.transpose(2, 0, 1)


def singular_stress(t: Floats, direction: float) -> Floats:
    """Stress (n, 3, 2) [point, xx yy xy, mode] times sqrt(2 pi r) of K_I = 1 and K_II = 1 at angles t (n,).

    In axes that those of the tip are turned from by `direction` (rad).
    """
    c, s, c3, s3 = np.cos(0.5 * t), np.sin(0.5 * t), np.cos(1.5 * t), np.sin(1.5 * t)
    xx = np.stack([c * (1.0 - s * s3), -s * (2.0 + c * c3)])
    yy = np.stack([c * (1.0 + s * s3), s * c * c3])
    xy = np.stack([s * c * c3, c * (1.0 - s * s3)])
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    cos, sin = np.cos(2.0 * direction), np.sin(2.0 * direction)
    along, across = half * cos - xy * sin, half * sin + xy * cos
    return np.stack([mean + along, mean - along, across], axis=1).transpose(2, 1, 0)


def _shapes(material: PlaneElasticity, t: Floats) -> tuple[Floats, Floats]:
    """g(t) / (2 shear modulus sqrt(2 pi)) and its derivative, (2, 2, n) [mode, component, point] each."""
    kappa = 8.0 * material.c33 / material.young_prime - 1.0
    arguments = np.stack([0.5 * t, 1.5 * t])
    cos, sin = np.cos(arguments), np.sin(arguments)
    functions, rates = np.concatenate([cos, sin]), np.concatenate([-sin, cos]) * RATES[:, None]
    coefficients = np.array(  # of cos t/2, cos 3t/2, sin t/2, sin 3t/2
        [
            [[kappa - 0.5, -0.5, 0.0, 0.0], [0.0, 0.0, kappa + 0.5, -0.5]],
            [[0.0, 0.0, kappa + 1.5, 0.5], [1.5 - kappa, -0.5, 0.0, 0.0]],
        ]
    ) / (2.0 * material.c33 * np.sqrt(2.0 * np.pi))
    return coefficients @ functions, coefficients @ rates
