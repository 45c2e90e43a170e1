"""Moving least squares with a linear basis, round any nodes.

phi_i(x) = b(x) . p_i w_i with p_i = (1, xi_i, eta_i), (xi_i, eta_i) = x_i - x, A = sum w_i p_i p_i', A b = (1, 0, 0)
(Belytschko, Lu, Gu 1994, eqs. 5 to 14, with the basis moved to x). The weight is a tensor product of cubic splines,
w(q) = 4/3 ((1 - q)^3 - 4 (1/2 - q)^3) of the positive parts, zero from q = 1 on (their eq. 25).
"""

from __future__ import annotations

import math

from crackgrow.arrays import Floats
from crackgrow.compiled import kernel


@kernel
def mls(
    x: float, y: float, nodes: Floats, per_half: Floats, k: int, derivatives: bool, f: Floats, work: Floats
) -> None:
    """Put the functions of k nodes at a point into f[0, :k], and their derivatives into f[1:, :k].

    nodes: (2, k or more); per_half: (k or more,) inverse half widths of the nodes' patches; work: (5, k or more)
    """
    xi, eta, weight, slope_x, slope_y = work[0], work[1], work[2], work[3], work[4]
    a = b = c = d = e = g = 0.0  # A = [[a, b, c], [b, d, e], [c, e, g]]
    for i in range(k):
        u, v, per = nodes[0, i] - x, nodes[1, i] - y, per_half[i]
        p, q = abs(u) * per, abs(v) * per
        p1, p2, q1, q2 = max(1.0 - p, 0.0), max(0.5 - p, 0.0), max(1.0 - q, 0.0), max(0.5 - q, 0.0)
        wx = 4.0 / 3.0 * (p1 * p1 * p1 - 4.0 * p2 * p2 * p2)
        wy = 4.0 / 3.0 * (q1 * q1 * q1 - 4.0 * q2 * q2 * q2)
        w = wx * wy
        xi[i], eta[i], weight[i] = u, v, w
        if derivatives:  # by x: the weight falls away from the node
            slope_x[i] = math.copysign(4.0 * (p1 * p1 - 4.0 * p2 * p2) * per, u) * wy
            slope_y[i] = math.copysign(4.0 * (q1 * q1 - 4.0 * q2 * q2) * per, v) * wx
        a += w
        b += w * u
        c += w * v
        d += w * u * u
        e += w * u * v
        g += w * v * v
    i00, i01, i02 = d * g - e * e, c * e - b * g, b * e - c * d
    i11, i12, i22 = a * g - c * c, b * c - a * e, a * d - b * b
    per = 1.0 / (a * i00 + b * i01 + c * i02)
    b0, b1, b2, i11, i12, i22 = i00 * per, i01 * per, i02 * per, i11 * per, i12 * per, i22 * per
    x0 = x1 = x2 = y0 = y1 = y2 = 0.0
    for i in range(k):
        value = b0 + b1 * xi[i] + b2 * eta[i]
        f[0, i] = weight[i] * value
        if derivatives:
            s, t = slope_x[i] * value, slope_y[i] * value
            f[1, i], f[2, i] = s, t
            x0 += s
            x1 += s * xi[i]
            x2 += s * eta[i]
            y0 += t
            y1 += t * xi[i]
            y2 += t * eta[i]
    if not derivatives:
        return
    # b,x = -A^-1 A,x b: the weights change, and so do the p_i, which move with x
    x0, x1, x2 = a * b1 - x0, a * b0 + 2.0 * b * b1 + c * b2 - x1, c * b1 - x2
    y0, y1, y2 = a * b2 - y0, b * b2 - y1, a * b0 + b * b1 + 2.0 * c * b2 - y2
    u0, u1, u2 = b0 * x0 + b1 * x1 + b2 * x2 - b1, b1 * x0 + i11 * x1 + i12 * x2, b2 * x0 + i12 * x1 + i22 * x2
    v0, v1, v2 = b0 * y0 + b1 * y1 + b2 * y2 - b2, b1 * y0 + i11 * y1 + i12 * y2, b2 * y0 + i12 * y1 + i22 * y2
    for i in range(k):
        f[1, i] += weight[i] * (u0 + u1 * xi[i] + u2 * eta[i])
        f[2, i] += weight[i] * (v0 + v1 * xi[i] + v2 * eta[i])
