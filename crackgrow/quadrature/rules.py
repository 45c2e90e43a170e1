"""Quadrature rules. Every rule states what it integrates exactly, and a test holds it to that."""

from __future__ import annotations

from functools import cache

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.vectors import cross


@cache
def gauss(n: int) -> tuple[Floats, Floats]:
    """Gauss rule of n points on [0, 1]: points (n,), weights (n,). Exact to degree 2 n - 1."""
    x, w = np.polynomial.legendre.leggauss(n)
    return _frozen(0.5 * (x + 1.0)), _frozen(0.5 * w)


@cache
def square(n: int) -> tuple[Floats, Floats]:
    """n x n Gauss rule on the unit square: points (n^2, 2), weights (n^2,). Exact to degree 2 n - 1 per axis."""
    x, w = gauss(n)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    return _frozen(points), _frozen(np.outer(w, w).ravel())


@cache
def triangle(n: int) -> tuple[Floats, Floats]:
    """Conical product rule on the triangle (0, 0), (1, 0), (0, 1): points (n^2, 2), weights (n^2,), sum 1/2.

    Exact to degree 2 n - 1 (Stroud 1971, section 2.4): Gauss-Jacobi across, Gauss along. The rule across, of the weight
    1 - x, is that of the eigenvalues of its Jacobi matrix (Golub, Welsch 1969); loading SciPy for it takes 0.1 s.
    """
    k = np.arange(n, dtype=float)
    beside = np.sqrt(k[1:] * (k[1:] + 1.0)) / (2.0 * k[1:] + 1.0)
    x, vectors = np.linalg.eigh(np.diag(-1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0))) + np.diag(beside, -1))
    across, across_weight = 0.5 * (x + 1.0), 0.5 * vectors[0] ** 2
    along, along_weight = gauss(n)
    points = np.stack([np.repeat(across, n), np.outer(1.0 - across, along).ravel()], axis=1)
    return _frozen(points), _frozen(np.outer(across_weight, along_weight).ravel())


def on_triangles(corners: Floats, n: int) -> tuple[Floats, Floats]:
    """The conical rule on triangles (t, 3, 2): points (t, n^2, 2) and weights (t, n^2)."""
    local, weights = triangle(n)
    first, a, b = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    points = first[:, None] + local[None, :, :1] * a[:, None] + local[None, :, 1:] * b[:, None]
    return points, np.abs(cross(a, b))[:, None] * weights


def on_tip_triangles(corners: Floats, n: int) -> tuple[Floats, Floats]:
    """Rule on triangles (t, 3, 2) whose first corner is a crack tip: points (t, n^2, 2), weights (t, n^2).

    Collapsed at the tip with u = w^2, which makes any power of sqrt(r) a polynomial: r^(k/2 - 1) times a function of
    the angle is integrated exactly in r for k up to 2 n - 2. Along the far side, points are drawn to the foot of the
    tip's perpendicular by t = H sinh(eta), so that a tip close to that side costs no accuracy.
    """
    x, weight = gauss(n)
    tip, a, b = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    side = b - a
    length = np.hypot(side[:, 0], side[:, 1])
    unit = side / length[:, None]
    double_area = np.abs(cross(a, b))
    height = double_area / length
    start = np.sum(a * unit, axis=1)
    eta_0, eta_1 = np.arcsinh(start / height), np.arcsinh((start + length) / height)
    eta = eta_0[:, None] + (eta_1 - eta_0)[:, None] * x
    v = (height[:, None] * np.sinh(eta) - start[:, None]) / length[:, None]
    dv = (eta_1 - eta_0)[:, None] * weight * height[:, None] * np.cosh(eta) / length[:, None]
    far = a[:, None] + v[:, :, None] * side[:, None]  # (t, n, 2) points on the far side
    points = tip[:, None, None] + (x**2)[None, :, None, None] * far[:, None]
    weights = double_area[:, None, None] * (2.0 * x**3 * weight)[None, :, None] * dv[:, None, :]
    t = len(corners)
    return points.reshape(t, n * n, 2), weights.reshape(t, n * n)


def _frozen(array: Floats) -> Floats:
    array.flags.writeable = False
    return array


def on_edges(tip_at_start: Bools, tip_at_end: Bools, n: int) -> tuple[Floats, Floats]:
    """Points on edges (m,) by their position in [0, 1] (m, n), and weights (m, n) that sum to 1.

    They are Gauss points; on an edge that begins or ends at a tip, for functions of sqrt(distance) from there: exact
    for half powers to 2 n - 1. An edge with a tip at both ends uses x = sin^2(pi y / 2).
    """
    x, w = gauss(n)
    position, weights = np.tile(x, (len(tip_at_start), 1)), np.tile(w, (len(tip_at_start), 1))
    only_start, only_end, both = tip_at_start & ~tip_at_end, tip_at_end & ~tip_at_start, tip_at_start & tip_at_end
    position[only_start], weights[only_start] = x**2, 2.0 * x * w
    position[only_end], weights[only_end] = 1.0 - x**2, 2.0 * x * w
    position[both], weights[both] = np.sin(0.5 * np.pi * x) ** 2, 0.5 * np.pi * np.sin(np.pi * x) * w
    return position, weights
