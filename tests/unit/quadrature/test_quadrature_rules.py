"""Rules: each integrates exactly what it promises, and not the next degree; pieces of lines that they suffice on."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

from crackgrow.quadrature.rims import POINTS_PER_EDGE
from crackgrow.quadrature.rules import (
    gauss,
    on_edges,
    on_tip_triangles,
    on_triangles,
    square,
    triangle,
)
from crackgrow.quadrature.subdivision import MOST_LEVELS, SHARE, subdivided

POINTS = (1, 2, 3, 4, 6)


@pytest.mark.parametrize("n", POINTS)
def test_gauss_rules_of_lines_and_squares_are_exact_to_their_degree_and_no_further(n: int) -> None:
    (x, w), (points, weights), (position, lengths) = gauss(n), square(n), on_edges(*np.zeros((2, 3), dtype=bool), n)
    for i in range(2 * n):
        assert w @ x**i == pytest.approx(1 / (i + 1), rel=1e-13)
        np.testing.assert_allclose(np.sum(lengths * position**i, axis=1), np.full(3, 1 / (i + 1)), rtol=1e-13)
        for j in range(2 * n):
            value = weights @ (points[:, 0] ** i * points[:, 1] ** j)
            assert value == pytest.approx(1 / ((i + 1) * (j + 1)), rel=1e-13)
    # error of the degree 2 n: (n!)^4 / ((2 n + 1) (2 n)!^2)
    error = factorial(n) ** 4 / ((2 * n + 1) * factorial(2 * n) ** 2)
    for values, weight in ((x, w), (points[:, 0], weights), (points[:, 1], weights)):
        assert 1 / (2 * n + 1) - weight @ values ** (2 * n) == pytest.approx(error, rel=1e-5)


@pytest.mark.parametrize("n", POINTS)
def test_triangle_is_exact_to_its_degree_and_no_further(n: int) -> None:
    points, w = triangle(n)

    def error(i: int, j: int) -> float:
        exact = factorial(i) * factorial(j) / factorial(i + j + 2)
        return abs(w @ (points[:, 0] ** i * points[:, 1] ** j) / exact - 1)

    assert max(error(i, d - i) for d in range(2 * n) for i in range(d + 1)) < 1e-12
    assert max(error(i, 2 * n - i) for i in range(2 * n + 1)) > 1e-6
    assert points.min() > 0.0
    assert points.sum(axis=1).max() < 1.0


def test_mapped_triangles_keep_area_and_degree_in_both_orientations() -> None:
    corners = np.array([[[0.2, 0.1], [1.3, 0.4], [0.6, 1.7]]])
    for given in (corners, corners[:, ::-1]):
        points, w = on_triangles(given, 2)
        assert w.sum() == pytest.approx(0.5 * (1.1 * 1.6 - 0.3 * 0.4), rel=1e-14)
        # second moment of a triangle: area / 12 * (9 mean^2 + sum of squares)
        x = corners[0, :, 0]
        exact = w.sum() / 12 * (9 * x.mean() ** 2 + np.sum(x**2))
        assert w[0] @ points[0, :, 0] ** 2 == pytest.approx(exact, rel=1e-14)


def tip_integral(corners: np.ndarray, power: float, angular) -> float:
    """Integral of r^power angular(t), by polar coordinates and adaptive quadrature along the far side's angle."""
    tip, a, b = corners
    unit = (b - a) / np.hypot(*(b - a))
    normal = np.array([unit[1], -unit[0]])
    height = (a - tip) @ normal
    foot = np.arctan2(*(np.sign(height) * normal)[::-1])
    low, high = (np.arctan2((p - tip) @ unit, abs(height)) for p in (a, b))
    sense = np.sign(height)  # whether the angle grows along the side
    exact, _ = quad(
        lambda t: (abs(height) / np.cos(t)) ** (power + 2) / (power + 2) * angular(foot + sense * t),
        low, high, epsabs=0, epsrel=1e-12, limit=400,
    )  # fmt: skip
    return exact


TRIANGLES = {
    "regular": [[0.3, 0.2], [1.3, 0.1], [0.9, 1.1]],
    "clockwise": [[0.3, 0.2], [0.9, 1.1], [1.3, 0.1]],
    "slender": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.02]],
    "far side at 1e-2": [[0.0, 0.0], [-0.4, -0.01], [0.6, -0.01]],
    "far side at 1e-4": [[0.0, 0.0], [-0.4, -1e-4], [0.6, -1e-4]],
    "foot outside": [[0.0, 0.0], [0.1, 0.05], [1.0, 0.05]],
}


def angular(t: np.ndarray) -> np.ndarray:
    return 1.2 + np.cos(t) + 0.3 * np.sin(2 * t)


def tip_rule(name: str, power: float, n: int) -> tuple[float, float]:
    """Value by the rule, and error, for r^power times the smooth function of the angle."""
    corners = np.array(TRIANGLES[name], dtype=float)
    points, w = on_tip_triangles(corners[None], n)
    local = points[0] - corners[0]
    value = w[0] @ (np.hypot(*local.T) ** power * angular(np.arctan2(local[:, 1], local[:, 0])))
    return value, value - tip_integral(corners, power, angular)


@pytest.mark.parametrize("power", [-1.0, -0.5, 0.0, 0.5])
@pytest.mark.parametrize("name", TRIANGLES)
def test_tip_rule_integrates_powers_of_the_distance_with_smooth_angles(name: str, power: float) -> None:
    """Products of two gradients go as 1/r, of a gradient and a constant as r^(-1/2).

    The rule converges exponentially, the slower the closer the far side: 2 asinh(1 / (2 distance)) is to be resolved.
    Six points, the default 4 + 2 MORE_POINTS, suffice relative to the disc of the same size.
    """
    value, error = tip_rule(name, power, 32)
    assert abs(error) < {"far side at 1e-2": 1e-8, "far side at 1e-4": 1e-4}.get(name, 1e-12) * value
    assert power > 0.0 or abs(tip_rule(name, power, 6)[1]) < 2e-4 * 2 * np.pi / (power + 2)


@pytest.mark.parametrize("name", TRIANGLES)
def test_tip_rule_is_exact_for_the_inverse_distance(name: str) -> None:
    """w / r is constant along eta, where the points are Gauss points: with one point already, whatever the triangle."""
    corners = np.array(TRIANGLES[name], dtype=float)
    exact = tip_integral(corners, -1.0, np.ones_like)
    for n in (1, 4, 16):
        points, w = on_tip_triangles(corners[None], n)
        assert np.sum(w[0] / np.hypot(*(points[0] - corners[0]).T)) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_tip_rule_is_exact_in_half_powers_of_r_to_its_degree_and_no_further(n: int) -> None:
    """Divided by the same angular integral: r^(k/2 - 1) for a function of x / y, with the tip at the origin."""
    corners = np.array([[0.0, 0.0], [1.0, -0.01], [1.0, 0.01]])  # r is x to 5e-5, powers of x stand for powers of r
    points, w = on_tip_triangles(corners[None], n)
    x = points[0, :, 0]
    for k in range(1, 2 * n - 1):  # weights carry w^3, r^(k/2 - 1) is w^(k - 2): degree k + 1 <= 2 n - 1
        exact = 0.02 / (0.5 * k + 1)  # integral of x^(k/2 - 1) 0.02 x
        # along the side, eta^2 terms of the weight 1e-4 wide: n = 2 is exact to 1e-8
        assert w[0] @ x ** (0.5 * k - 1) == pytest.approx(exact, rel=1e-8)
    k = 2 * n - 1
    assert abs(w[0] @ x ** (0.5 * k - 1) * (0.5 * k + 1) / 0.02 - 1) > 1e-6


@pytest.mark.parametrize("n", [2, 3, 5])
def test_edges_with_a_tip_are_exact_for_half_powers_to_their_degree_and_no_further(n: int) -> None:
    at_start, at_end = np.array([True, False, False]), np.array([False, True, False])
    position, w = on_edges(at_start, at_end, n)
    distance = np.stack([position[0], 1 - position[1]])
    for k in range(-1, 2 * n - 1):
        np.testing.assert_allclose(np.sum(w[:2] * distance ** (k / 2), axis=1), 1 / (k / 2 + 1), rtol=1e-13)
    k = 2 * n - 1
    assert np.abs(np.sum(w[:2] * distance ** (k / 2), axis=1) * (k / 2 + 1) - 1).min() > 1e-8
    np.testing.assert_allclose(w[2], gauss(n)[1], rtol=1e-15)


def test_edge_between_two_tips_integrates_the_opening_of_a_crack() -> None:
    """sqrt(x (1 - x)) -> pi / 8, and its inverse, the gradient -> pi; the inverse is exact with one point."""
    both = np.array([True])
    for n, tolerance in ((6, 1e-6), (12, 1e-13)):
        position, w = on_edges(both, both, n)
        root = np.sqrt(position * (1 - position))
        assert np.sum(w * root) == pytest.approx(np.pi / 8, rel=tolerance)
        assert np.sum(w / root) == pytest.approx(np.pi, rel=1e-13)


ENDS = np.array([[[0.0, 0.0], [3.0, 4.0]], [[3.0, 4.0], [3.0, 6.0]]])  # 5 and 2 long
LENGTHS = np.array([5.0, 2.0])


def integral(values, line: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Integral of the values with a Gauss rule on each piece."""
    x, w = gauss(POINTS_PER_EDGE)
    width = np.diff(limits, axis=1)
    at = limits[:, :1] + width * x
    places = ENDS[line, 0][:, None] + at[:, :, None] * (ENDS[line, 1] - ENDS[line, 0])[:, None]
    found = values(places.reshape(-1, 2), np.repeat(line, len(x))).reshape(len(line), len(x), -1)
    return np.einsum("mp,mpc->c", width * LENGTHS[line][:, None] * w, found)


def test_what_the_points_integrate_is_not_cut() -> None:
    line, limits = subdivided(ENDS, lambda at, line: np.stack([at[:, 0] ** 7, 1.0 + line], axis=1))
    assert line.tolist() == [0, 1]
    assert limits.tolist() == [[0.0, 1.0], [0.0, 1.0]]


@pytest.mark.parametrize("width", [1.0, 0.3, 0.05])
def test_a_peak_between_the_points_is_found(width: float) -> None:
    def peak(at: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.exp(-(((at[:, 1] - 4.7) / width) ** 2))[:, None]

    line, limits = subdivided(ENDS, peak)
    root = 0.5 * np.sqrt(np.pi) * width
    on_first = root * (erf((4.0 - 4.7) / width) - erf(-4.7 / width)) * 5.0 / 4.0
    exact = on_first + root * (erf(1.3 / width) - erf(-0.7 / width))
    assert integral(peak, line, limits) == pytest.approx(exact, rel=20.0 * SHARE)
    assert np.all(np.diff(line) >= 0)
    for number in (0, 1):  # the pieces follow each other without gaps
        low, high = limits[line == number].T
        assert (low[0], high[-1]) == (0.0, 1.0)
        np.testing.assert_array_equal(low[1:], high[:-1])


def test_a_kink_is_cut_out_and_no_singularity_is_followed_for_ever() -> None:
    def kinked(at: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.maximum(at[:, 1] - 4.9, 0.0)[:, None]

    line, limits = subdivided(ENDS, kinked)
    assert integral(kinked, line, limits) == pytest.approx(0.5 * 1.1**2, rel=20.0 * SHARE)
    line, limits = subdivided(ENDS, lambda at, _: (1.0 / np.abs(at[:, 1] - 5.0 + 1e-9))[:, None])
    assert np.diff(limits, axis=1).min() >= 0.5**MOST_LEVELS
    assert len(line) < 200
