"""Moving least squares with a linear basis: round any nodes, and round those of a lattice with cells of one size.

phi_i(x) = b(x) . p_i w_i with p_i = (1, xi_i, eta_i), (xi_i, eta_i) = x_i - x, A = sum w_i p_i p_i', A b = (1, 0, 0)
(Belytschko, Lu, Gu 1994, eqs. 5 to 14, with the basis moved to x). The weight is a tensor product; on the lattice the
moments in A are products of one-dimensional sums as well.

Arrays inside run over the points last, so that every operation is one long loop; the results are views of such arrays.
"""

from __future__ import annotations

import numpy as np

from crackgrow.approximation.weight import cubic_spline
from crackgrow.arrays import Floats


def mls(local: Floats, support: float, reach: int) -> tuple[Floats, Floats]:
    """Functions of the 2 reach x 2 reach nodes round points (n, 2) given by their position in the unit cell.

    Returns phi (n, w) and dphi (n, w, 2) per lattice spacing, w = (2 reach)^2, nodes ordered as `regular_window`.
    """
    distance, w, dw = _weights(local, support, reach)
    (x0, y0), (x1, y1), (x2, y2) = _moments(distance, w)
    dx0, dy0 = np.sum(dw, axis=1)
    dx1, dy1 = np.sum(dw * distance - w, axis=1)
    dx2, dy2 = np.sum((dw * distance - 2.0 * w) * distance, axis=1)
    inverse = _inverse(x0 * y0, x1 * y0, x0 * y1, x2 * y0, x1 * y1, x0 * y2)
    b = inverse[:3]
    db_x = -_times(inverse, _times((dx0 * y0, dx1 * y0, dx0 * y1, dx2 * y0, dx1 * y1, dx0 * y2), b))
    db_y = -_times(inverse, _times((x0 * dy0, x1 * dy0, x0 * dy1, x2 * dy0, x1 * dy1, x0 * dy2), b))
    db_x[0] -= b[1]  # the basis moves with x
    db_y[0] -= b[2]

    wx, wy = w[0][:, None], w[1][None]
    weight, value = wx * wy, _along(b, distance)
    dphi = np.empty((2, *weight.shape))
    dphi[0] = _along(db_x, distance) * weight + value * (dw[0][:, None] * wy)
    dphi[1] = _along(db_y, distance) * weight + value * (wx * dw[1][None])
    return _by_point(weight * value), dphi.reshape(2, distance.shape[1] ** 2, len(local)).transpose(2, 1, 0)


def mls_values(local: Floats, support: float, reach: int) -> Floats:
    """The values phi (n, w) of `mls` alone, at half the cost."""
    distance, w, _ = _weights(local, support, reach)
    (x0, y0), (x1, y1), (x2, y2) = _moments(distance, w)
    b = _inverse(x0 * y0, x1 * y0, x0 * y1, x2 * y0, x1 * y1, x0 * y2)[:3]
    return _by_point(w[0][:, None] * w[1][None] * _along(b, distance))


def mls_round(local: Floats, nodes: Floats, half: Floats, derivatives: bool = True) -> Floats:
    """Functions (1, k, n), or with their derivatives (3, k, n), of k nodes for each of n points.

    local: points (n, 2); nodes: (2, k, n) with half widths (k, n), all in one unit of length
    """
    xi, eta = distance = nodes - local.T[:, None, :]
    (wx, wy), slopes = cubic_spline(np.abs(distance) / half)
    weight = wx * wy
    moments = _sums(weight, xi, eta)
    inverse = _inverse(*moments)
    b = inverse[:3]
    value = b[0] + b[1] * xi + b[2] * eta
    found = np.empty((3 if derivatives else 1, *weight.shape))
    np.multiply(weight, value, out=found[0])
    if not derivatives:
        return found
    a00, a10, a01, *_ = moments
    slopes *= np.sign(distance) / half
    for axis, other in enumerate((wy, wx)):
        change = slopes[axis] * other
        change *= value
        # -A,x b: the weights change, and so do the p_i, which move with x
        moved = np.stack([change.sum(axis=0), *(np.einsum("kn,kn->n", change, along) for along in distance)])
        moved[0] += a00 * b[1 + axis]
        moved[1 + axis] += a00 * b[0] + a10 * b[1] + a01 * b[2] + (a10, a01)[axis] * b[1 + axis]
        moved[2 - axis] += (a01, a10)[axis] * b[1 + axis]
        db = _times(inverse, moved)
        db[0] -= b[1 + axis]  # the basis moves with x as well
        np.multiply(weight, db[0] + db[1] * xi + db[2] * eta, out=found[1 + axis])
        found[1 + axis] -= change
    return found


def _sums(weight: Floats, xi: Floats, eta: Floats) -> tuple[Floats, ...]:
    """Sums (n,) over the nodes of weights (k, n) times 1, xi, eta, xi^2, xi eta, eta^2."""
    first, second = weight * xi, weight * eta
    return (
        weight.sum(axis=0),
        first.sum(axis=0),
        second.sum(axis=0),
        np.einsum("kn,kn->n", first, xi),
        np.einsum("kn,kn->n", first, eta),
        np.einsum("kn,kn->n", second, eta),
    )


def _weights(local: Floats, support: float, reach: int) -> tuple[Floats, Floats, Floats]:
    """Distances x_i - x, weights and their derivatives by x, per axis: each (2, 2 reach, n)."""
    distance = np.arange(1 - reach, reach + 1, dtype=float)[:, None] - local.T[:, None, :]
    w, dw = cubic_spline(np.abs(distance) / support)
    return distance, w, -dw * np.sign(distance) / support


def _moments(distance: Floats, w: Floats) -> tuple[Floats, Floats, Floats]:
    """Sums of the weights, per axis, times powers of the distances: three of (2, n)."""
    first = w * distance
    return np.sum(w, axis=1), np.sum(first, axis=1), np.sum(first * distance, axis=1)


def _along(c: Floats, distance: Floats) -> Floats:
    """c_0 + c_1 xi + c_2 eta (2 reach, 2 reach, n) at the nodes, for c (3, n)."""
    return np.asarray((c[0] + c[1] * distance[0])[:, None] + (c[2] * distance[1])[None])


def _by_point(values: Floats) -> Floats:
    """Values (n, w) at points from those at the nodes (2 reach, 2 reach, n)."""
    return values.reshape(values.shape[0] * values.shape[1], values.shape[2]).T


def _times(matrix: Floats | tuple[Floats, ...], vector: Floats) -> Floats:
    """Products (3, n) of symmetric 3 x 3 matrices, six entries of (n,) each, and vectors (3, n)."""
    a00, a01, a02, a11, a12, a22 = matrix
    x, y, z = vector
    return np.stack([a00 * x + a01 * y + a02 * z, a01 * x + a11 * y + a12 * z, a02 * x + a12 * y + a22 * z])


def _inverse(a00: Floats, a01: Floats, a02: Floats, a11: Floats, a12: Floats, a22: Floats) -> Floats:
    """Inverses, as six entries (6, n), of symmetric 3 x 3 matrices, by cofactors."""
    c00, c01, c02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    c11, c12, c22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    return np.stack([c00, c01, c02, c11, c12, c22]) / (a00 * c00 + a01 * c01 + a02 * c02)
