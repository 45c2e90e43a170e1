"""Moving least squares on the uniform lattice, linear basis.

phi_i(x) = b(x) . p_i w_i with p_i = (1, xi_i, eta_i), (xi_i, eta_i) = x_i - x, A = sum w_i p_i p_i', A b = (1, 0, 0)
(Belytschko, Lu, Gu 1994, eqs. 5 to 14, with the basis moved to x). The weight is a tensor product, so the moments
in A are products of one-dimensional sums.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.weight import cubic_spline

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def mls(local: Floats, support: float, reach: int) -> tuple[Floats, Floats]:
    """Functions of the 2 reach x 2 reach nodes round points (n, 2) given by their position in the unit cell.

    Returns phi (n, w) and dphi (n, w, 2) per lattice spacing, w = (2 reach)^2, nodes ordered as `Lattice.offsets`.
    """
    distance, w, dw = _weights(local, support, reach)
    m0, m1, m2 = (np.sum(w * distance**a, axis=2) for a in range(3))
    d0, d1, d2 = (
        np.sum(dw, axis=2),
        np.sum(dw * distance - w, axis=2),
        np.sum((dw * distance - 2.0 * w) * distance, axis=2),
    )
    (x0, y0), (x1, y1), (x2, y2) = m0.T, m1.T, m2.T
    inverse = _inverse(x0 * y0, x1 * y0, x0 * y1, x2 * y0, x1 * y1, x0 * y2)
    b = inverse[:, :, 0]
    (dx0, dy0), (dx1, dy1), (dx2, dy2) = d0.T, d1.T, d2.T
    da_x = _symmetric(dx0 * y0, dx1 * y0, dx0 * y1, dx2 * y0, dx1 * y1, dx0 * y2)
    da_y = _symmetric(x0 * dy0, x1 * dy0, x0 * dy1, x2 * dy0, x1 * dy1, x0 * dy2)
    db_x, db_y = (-np.einsum("nij,njk,nk->ni", inverse, da, b) for da in (da_x, da_y))

    shape = (len(local), distance.shape[2] ** 2)
    wx, wy = w[:, 0, :, None], w[:, 1, None, :]
    dwx, dwy = dw[:, 0, :, None], dw[:, 1, None, :]
    xi, eta = distance[:, 0, :, None], distance[:, 1, None, :]

    def along(c: Floats) -> Floats:
        return np.asarray(c[:, 0, None, None] + c[:, 1, None, None] * xi + c[:, 2, None, None] * eta)

    weight, value = wx * wy, along(b)
    phi = (weight * value).reshape(shape)
    dphi_x = (along(db_x) - b[:, 1, None, None]) * weight + value * dwx * wy
    dphi_y = (along(db_y) - b[:, 2, None, None]) * weight + value * wx * dwy
    return phi, np.stack([dphi_x.reshape(shape), dphi_y.reshape(shape)], axis=2)


def mls_values(local: Floats, support: float, reach: int) -> Floats:
    """The values phi (n, w) of `mls` alone, at half the cost."""
    distance, w, _ = _weights(local, support, reach)
    (x0, y0), (x1, y1), (x2, y2) = (np.sum(w * distance**a, axis=2).T for a in range(3))
    a00, a01, a02, a11, a12, a22 = x0 * y0, x1 * y0, x0 * y1, x2 * y0, x1 * y1, x0 * y2
    cofactors = np.stack([a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11])
    determinant = a00 * cofactors[0] + a01 * cofactors[1] + a02 * cofactors[2]
    b0, b1, b2 = (cofactors / determinant)[:, :, None]
    value = (b0 + b1 * distance[:, 0])[:, :, None] + (b2 * distance[:, 1])[:, None, :]
    return np.asarray((w[:, 0, :, None] * w[:, 1, None, :] * value).reshape(len(local), distance.shape[2] ** 2))


def _weights(local: Floats, support: float, reach: int) -> tuple[Floats, Floats, Floats]:
    """Distances x_i - x, weights and their derivatives by x, per axis: each (n, 2, 2 reach)."""
    distance = np.arange(1 - reach, reach + 1, dtype=float) - local[:, :, None]
    w, dw = cubic_spline(np.abs(distance) / support)
    return distance, w, -dw * np.sign(distance) / support


def _symmetric(a00: Floats, a01: Floats, a02: Floats, a11: Floats, a12: Floats, a22: Floats) -> Floats:
    """Symmetric 3 x 3 matrices (n, 3, 3) from their entries (n,)."""
    return np.stack([a00, a01, a02, a01, a11, a12, a02, a12, a22], axis=-1).reshape(-1, 3, 3)


def _inverse(a00: Floats, a01: Floats, a02: Floats, a11: Floats, a12: Floats, a22: Floats) -> Floats:
    """Inverses (n, 3, 3) of symmetric 3 x 3 matrices, by cofactors."""
    c00, c01, c02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    c11, c12, c22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    determinant = a00 * c00 + a01 * c01 + a02 * c02
    return _symmetric(*(c / determinant for c in (c00, c01, c02, c11, c12, c22)))
