"""The functions of nodes by moving least squares, and the four tip functions: closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.approximation.mls import mls
from crackgrow.cover.tips import TipView, seen_from_tip, tip_angle
from tests.unit.approximation.tip_values import at_polar
from tests.unit.cover_tables import regular_window


def functions_of(nodes: np.ndarray, point: np.ndarray, support: float) -> np.ndarray:
    """Values and derivatives (3, k) at a point (2,) of the functions of nodes (k, 2), all of one half width."""
    k = len(nodes)
    found, alone, work, per_half = np.empty((3, k)), np.empty((1, k)), np.empty((5, k)), np.full(k, 1.0 / support)
    at = np.ascontiguousarray(nodes.T, dtype=float)
    mls(*point, at, per_half, k, True, found, work)
    mls(*point, at, per_half, k, False, alone, work)
    np.testing.assert_array_equal(alone[0], found[0])
    return found


def regular_functions(local: np.ndarray, support: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values (n, w) and gradients (n, w, 2) at places in a cell (n, 2), in its sides, and the nodes (w, 2)."""
    nodes = regular_window(support)
    found = np.array([functions_of(nodes, point, support) for point in local])
    return found[:, 0], found[:, 1:].transpose(0, 2, 1), nodes


def test_weight_is_the_cubic_spline() -> None:
    """Two groups of nodes mirrored about the point: phi follow from ratios of w(q) = 4/3 ((1-q)^3 - 4 (1/2-q)^3)."""
    for a, b in ((0.2, 0.4), (0.3, 0.8), (0.6, 0.9)):
        nodes = np.array([(s * d, t) for d in (a, b) for s in (-1.0, 1.0) for t in (-0.1, 0.1)])
        phi = functions_of(nodes, np.zeros(2), 1.0)[0]
        w = [4 / 3 * ((1 - q) ** 3 - 4 * max(0.5 - q, 0.0) ** 3) for q in (a, b)]
        np.testing.assert_allclose(phi[:4], w[0] / (4.0 * (w[0] + w[1])), rtol=1e-13)
        np.testing.assert_allclose(phi[4:], w[1] / (4.0 * (w[0] + w[1])), rtol=1e-13)


@pytest.mark.parametrize("support", [1.2, 1.5, 1.75, 2.0, 2.5, 3.0])
def test_linear_fields_are_reproduced_and_no_more_with_the_symmetries_of_the_square(support: float) -> None:
    """What a node that covers a point has for values does not depend on nodes that do not."""
    local = np.random.default_rng(10).uniform(0, 1, (200, 2))
    phi, dphi, nodes = regular_functions(local, support)
    np.testing.assert_allclose(phi.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(dphi.sum(axis=1), 0.0, atol=1e-11)
    np.testing.assert_allclose(phi @ nodes, local, atol=1e-12)
    gradient = np.einsum("nwd,wc->ncd", dphi, nodes)
    np.testing.assert_allclose(gradient, np.broadcast_to(np.eye(2), gradient.shape), atol=1e-11)
    assert np.abs(phi @ nodes[:, 0] ** 2 - local[:, 0] ** 2).max() > 0.05
    side = int(np.sqrt(len(nodes)))
    mirrored = regular_functions(local * (-1, 1) + (1, 0), support)[0].reshape(-1, side, side)[:, ::-1]
    np.testing.assert_allclose(mirrored.reshape(phi.shape), phi, atol=1e-13)
    swapped = regular_functions(local[:, ::-1], support)[0].reshape(-1, side, side).transpose(0, 2, 1)
    np.testing.assert_allclose(swapped.reshape(phi.shape), phi, atol=1e-13)
    for at, values, slopes in zip(local[:20], phi, dphi, strict=False):
        seen = np.abs(nodes - at).max(axis=1) < support
        found = functions_of(nodes[seen], at, support)
        np.testing.assert_allclose(found[0], values[seen], atol=1e-14)
        np.testing.assert_allclose(found[1:].T, slopes[seen], atol=1e-13)


POINTS = np.array([[4.0, 3.0], [3.2, 2.9], [2.6, 2.3], [1.6, 2.5]])


def tip_with(fade: float) -> TipView:
    return replace(seen_from_tip(POINTS, 1.0, ends_inside=False), fade=fade)


def test_tip_functions_follow_the_closed_form_and_those_with_sines_jump_across_the_crack() -> None:
    r, t = np.array([0.25, 1.0, 4.0, 1.0, 1.0]), np.array([0.0, np.pi, -np.pi, np.pi / 2, -np.pi / 3])
    s = np.sqrt(0.5)
    expected = [[0.5, 0, 0.5, 0], [0, 1, 0, -1], [0, -2, 0, 2], [s, s, -s, s], [np.sqrt(3) / 2, -0.5, 0, -1]]
    np.testing.assert_allclose(at_polar(tip_with(np.inf), r, t)[0], expected, atol=1e-15)
    values, gradients = at_polar(tip_with(np.inf), np.zeros(1), np.zeros(1))
    assert np.all(values == 0.0)
    assert np.isfinite(gradients).all()


@pytest.mark.parametrize("fade", [np.inf, 2.0, 0.9])
def test_gradients_of_tip_functions_agree_with_differences(fade: float) -> None:
    """In lattice axes, on a kinked crack; the references stay on their side."""
    rng, step, tip = np.random.default_rng(18), 1e-6, tip_with(fade)
    angle = rng.uniform(0, 2 * np.pi, 300)
    points = POINTS[0] + (rng.uniform(0.05, 1.5, 300) * [np.cos(angle), np.sin(angle)]).T
    _, gradients = at_polar(tip, *tip_angle(tip, points, points))
    for axis in range(2):
        move = step * np.eye(2)[axis]
        ahead, behind = (at_polar(tip, *tip_angle(tip, points + s * move, points))[0] for s in (1, -1))
        # third derivative about r^-2.5 < 2000, times step^2; rounding 1e-16 / step; the third derivative of chi jumps
        np.testing.assert_allclose(gradients[:, :, axis], (ahead - behind) / (2 * step), atol=1e-8)


def test_fading_multiplies_by_chi_and_leaves_nothing_beyond() -> None:
    r, t = np.linspace(0.01, 3.0, 60), np.linspace(-3, 3, 60)
    (plain, _), (faded, slopes) = (at_polar(tip_with(fade), r, t) for fade in (np.inf, 2.0))
    chi = np.where(r < 2.0, (1 - (r / 2.0) ** 2) ** 2, 0.0)
    np.testing.assert_allclose(faded, chi[:, None] * plain, atol=1e-15)
    assert not faded[r >= 2.0].any()
    assert not slopes[r >= 2.0].any()
