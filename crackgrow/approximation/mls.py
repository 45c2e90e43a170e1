"""Moving least squares with a linear basis, round any nodes.

phi_i(x) = b(x) . p_i w_i with p_i = (1, xi_i, eta_i), (xi_i, eta_i) = x_i - x, A = sum w_i p_i p_i', A b = (1, 0, 0)
(Belytschko, Lu, Gu 1994, eqs. 5 to 14, with the basis moved to x). The weight is a tensor product.

Pairs of a point and a node over it follow each other, point by point: points may have differently many nodes, and
every operation is one long loop.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats, Ints


def mls(distance: Floats, half: Floats, start: Ints, derivatives: bool = True) -> Floats:
    """Functions (1, q), or with their derivatives (3, q), of q pairs of a point and a node over it.

    distance: (2, q) from the point to the node; half: (q,) half width of the node's patch, in the same unit of length;
    start: (n + 1,) where the pairs of each point begin; no point is without a node
    """
    first, point = start[:-1], np.repeat(np.arange(len(start) - 1), np.diff(start))
    by_half = 1.0 / half
    from_node = distance * by_half
    (wx, wy), slopes = cubic_spline(np.abs(from_node))
    weight = wx * wy
    moments = np.add.reduceat(_times_squares(weight, *distance), first, axis=1)
    inverse = _inverse(*moments)
    b = inverse[:3]
    value = _along(b.take(point, axis=1), *distance)
    found = np.empty((3 if derivatives else 1, len(point)))
    np.multiply(weight, value, out=found[0])
    if not derivatives:
        return found
    a00, a10, a01, *_ = moments
    slopes = np.copysign(slopes * by_half, from_node)  # by x: the weight falls away from the node
    for axis, other in enumerate((wy, wx)):
        change = np.multiply(slopes[axis], other, out=found[1 + axis])
        change *= value
        # -A,x b: the weights change, and so do the p_i, which move with x
        moved = -np.add.reduceat(np.stack([change, change * distance[0], change * distance[1]]), first, axis=1)
        moved[0] += a00 * b[1 + axis]
        moved[1 + axis] += a00 * b[0] + a10 * b[1] + a01 * b[2] + (a10, a01)[axis] * b[1 + axis]
        moved[2 - axis] += (a01, a10)[axis] * b[1 + axis]
        db = _times(inverse, moved)
        db[0] -= b[1 + axis]  # the basis moves with x as well
        of_basis = _along(db.take(point, axis=1), *distance)
        of_basis *= weight
        change += of_basis
    return found


def _times_squares(weight: Floats, xi: Floats, eta: Floats) -> Floats:
    """Weights (q,) times 1, xi, eta, xi^2, xi eta, eta^2 (6, q)."""
    found = np.empty((6, len(weight)))
    found[0] = weight
    for place, (factor, along) in enumerate(((0, xi), (0, eta), (1, xi), (1, eta), (2, eta)), start=1):
        np.multiply(found[factor], along, out=found[place])
    return found


def _along(c: Floats, xi: Floats, eta: Floats) -> Floats:
    """c_0 + c_1 xi + c_2 eta (q,) for c (3, q), which is overwritten."""
    value, by_xi, by_eta = c
    by_xi *= xi
    by_eta *= eta
    value += by_xi
    value += by_eta
    return np.asarray(value)


def _times(matrix: Floats, vector: Floats) -> Floats:
    """Products (3, n) of symmetric 3 x 3 matrices, six entries of (n,) each, and vectors (3, n)."""
    a00, a01, a02, a11, a12, a22 = matrix
    x, y, z = vector
    return np.stack([a00 * x + a01 * y + a02 * z, a01 * x + a11 * y + a12 * z, a02 * x + a12 * y + a22 * z])


def _inverse(a00: Floats, a01: Floats, a02: Floats, a11: Floats, a12: Floats, a22: Floats) -> Floats:
    """Inverses, as six entries (6, n), of symmetric 3 x 3 matrices, by cofactors."""
    c00, c01, c02 = a11 * a22 - a12 * a12, a02 * a12 - a01 * a22, a01 * a12 - a02 * a11
    c11, c12, c22 = a00 * a22 - a02 * a02, a01 * a02 - a00 * a12, a00 * a11 - a01 * a01
    return np.stack([c00, c01, c02, c11, c12, c22]) / (a00 * c00 + a01 * c01 + a02 * c02)


def cubic_spline(q: Floats) -> tuple[Floats, Floats]:
    """Cubic spline w(q) and its derivative dw/dq at q >= 0, zero from q = 1 on (Belytschko, Lu, Gu 1994, eq. 25)."""
    whole, inner = np.maximum(1.0 - q, 0.0), np.maximum(0.5 - q, 0.0)
    whole_squared, inner_squared = whole * whole, inner * inner
    whole *= whole_squared
    inner *= inner_squared
    inner *= 4.0
    whole -= inner
    whole *= 4.0 / 3.0
    inner_squared *= 4.0
    inner_squared -= whole_squared
    inner_squared *= 4.0
    return whole, inner_squared
