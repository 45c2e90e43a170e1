"""The singular fields of a crack tip in rock with the roots s_1, s_2 (Sih, Paris, Irwin 1965), in the tip's axes.

With z_j = x + s_j y, w_j = sqrt(z_j), p = a_11 s^2 + a_12 - a_16 s and q = a_12 s + a_22 / s - a_26, K = 1 has

    sqrt(2 / pi) Re (s_1 (p, q)_2 w_2 - s_2 (p, q)_1 w_1) / (s_1 - s_2),    mode I,
    sqrt(2 / pi) Re ((p, q)_2 w_2 - (p, q)_1 w_1) / (s_1 - s_2),            mode II,

as displacement. These are divided differences D f = (f_2 - f_1) / (s_2 - s_1), D w = y / (w_1 + w_2), and as such hold
in isotropic rock, too, where s_1 = s_2 = i (Williams 1957). The angle t may be counted so that it jumps on a kinked
crack (`cover.tips`): continued like that the fields are exact in the body slit along that crack, though free of
traction on the last straight segment only.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Complex, Floats
from crackgrow.cover.shapes import Roots
from crackgrow.solid.elasticity import PlaneElasticity

N_ANGLES = 256
"""Of the trapezoidal rule on a circle: to round-off where moduli differ by a factor of 10."""

EVERY_ANGLE: Floats = 2.0 * np.pi / N_ANGLES * np.arange(N_ANGLES, dtype=np.float64)


def near_tip_gradient(material: PlaneElasticity, r: Floats, t: Floats) -> Floats:
    """Displacement gradient du_c/dx_d (n, 2, 2, 2) [point, mode, c, d] of K_I = 1 and K_II = 1 at r, t (n,).

    In memory the points run last.
    """
    w, (s_1, s_2) = _roots_of_z(material.roots, r, t), material.roots
    (first, last), between = (0.5 / w[0], 0.5 / w[1]), _inverse_difference(w, r * np.sin(t))
    by_x = _of_modes(material, first, 0.5 * between, last)
    by_y = _of_modes(material, s_1 * first, 0.5 * s_1 * between + last, s_2 * last)
    return np.stack([by_x, by_y], axis=2).transpose(3, 0, 1, 2)


def near_tip_stress(roots: Roots, t: Floats) -> Floats:
    """Stress (n, 3, 2) [point, xx yy xy, mode] times sqrt(2 pi r) of K_I = 1 and K_II = 1 at angles t (n,)."""
    (s_1, s_2), w = roots, _roots_of_z(roots, np.ones(len(t)), t)
    zeroth = _inverse_difference(w, np.sin(t))  # D of 1 / w, s / w, s^2 / w, 1 / (s w)
    first = s_1 * zeroth + 1.0 / w[1]
    second, inverse = s_1 * first + s_2 / w[1], zeroth / s_1 - 1.0 / (s_1 * s_2 * w[1])
    opens = s_1 * s_2 * np.stack([-first, -inverse, zeroth])
    return np.asarray(np.stack([opens, np.stack([-second, -zeroth, first])]).real.transpose(2, 1, 0))


def point_force_gradient(material: PlaneElasticity, r: Floats, t: Floats) -> Floats:
    """Displacement gradient du_c/dx_d (n, 2, 2) of a force 1 / a_11 along x on the tip, at r, t (n,).

    Its stress is radial, (A cos t + B sin t) / (r a_rr), a_rr the compliance along r (Lekhnitskii 1963, section 19; in
    isotropic rock Kfouri 1986, eq. 8), leaves all faces through the tip free, and is the same on both sides of them.
    """
    compliance = np.linalg.inv(material.matrix)
    away, along = _along(EVERY_ANGLE)
    around = 2.0 * np.pi / N_ANGLES * away / np.sum(along * (compliance @ along), axis=0)
    A, B = np.linalg.solve(around @ away.T, [-1.0 / compliance[0, 0], 0.0])
    (c, s), along = _along(t)
    force, slope = A * c + B * s, B * c - A * s
    xx, yy, xy = compliance @ along * force / (np.sum(along * (compliance @ along), axis=0) * r)
    turn = slope / r - 0.5 * (2.0 * c * s * (yy - xx) + (c * c - s * s) * xy)
    return np.array([[xx, 0.5 * xy - turn], [0.5 * xy + turn, yy]]).transpose(2, 0, 1)


def _along(t: Floats) -> tuple[Floats, Floats]:
    """Unit directions (2, n) at angles t (n,), and the stresses (3, n) xx, yy, xy of 1 along them."""
    c, s = np.cos(t), np.sin(t)
    return np.stack([c, s]), np.stack([c * c, s * s, c * s])


def _roots_of_z(roots: Roots, r: Floats, t: Floats) -> tuple[Complex, Complex]:
    """sqrt(z_j) (n,) at r, t: the angle of z_j is within pi of t, on whatever turn that is."""
    c, s, half = np.cos(t), np.sin(t), np.exp(-0.5j * t)
    found = [np.sqrt(r * (c + root * s)) for root in dict.fromkeys(roots)]  # in isotropic rock they are one
    found = [np.where((w * half).real < 0.0, -w, w) for w in found]
    return found[0], found[-1]


def _inverse_difference(w: tuple[Complex, Complex], y: Floats) -> Complex:
    """D (1 / w) (n,)."""
    return np.asarray(-y / ((w[0] + w[1]) * w[0] * w[1]))


def _of_modes(material: PlaneElasticity, first: Complex, between: Complex, last: Complex) -> Floats:
    """What a function f (n,), which is the `first` and `last` for the two roots, gives in place of w in both modes.

    Returns (2, 2, n) [mode, component, point]; `between` is D f, and D (g f) = g_1 D f + (D g) f_2.
    """
    s_1, s_2 = material.roots
    product, total = s_1 * s_2, s_1 + s_2
    (a_11, a_12, a_16), (_, a_22, a_26), _ = np.linalg.inv(material.matrix)
    factors = (  # g_1 and D g of p / s, q / s, p and q
        (a_11 * s_1 + a_12 / s_1 - a_16, a_11 - a_12 / product),
        (a_12 + a_22 / s_1**2 - a_26 / s_1, a_26 / product - a_22 * total / product**2),
        (a_11 * s_1**2 + a_12 - a_16 * s_1, a_11 * total - a_16),
        (a_12 * s_1 + a_22 / s_1 - a_26, a_12 - a_22 / product),
    )
    found = np.array([-(g * between + slope * last) for g, slope in factors]).reshape(2, 2, -1)
    found[0] *= product
    return np.asarray(np.sqrt(2.0 / np.pi) * found.real)
