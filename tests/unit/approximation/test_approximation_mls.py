"""Weight and moving least squares on the lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crackgrow.approximation.mls import cubic_spline, mls
from tests.unit.regular_functions import regular_functions

SUPPORTS = (1.2, 1.5, 1.75, 2.0, 2.5, 3.0)


def points(seed: int, n: int = 200) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 1, (n, 2))


def test_weight_at_known_places() -> None:
    w, dw = cubic_spline(np.array([0.0, 0.5, 1.0, 1.7]))
    np.testing.assert_allclose(w, [2 / 3, 1 / 6, 0, 0], rtol=1e-15)
    np.testing.assert_allclose(dw, [0, -1, 0, 0], rtol=1e-15)


def test_weight_integrates_to_a_half_over_its_half_width() -> None:
    """The cubic spline is the B-spline of four unit hats: 2 integral w dq = 1/2 scaled; both halves are cubic."""
    x, weight = np.polynomial.legendre.leggauss(2)  # exact for cubics
    total = sum(0.25 * weight @ cubic_spline(middle + 0.25 * x)[0] for middle in (0.25, 0.75))
    assert total == pytest.approx(0.25, rel=1e-15)


def test_weight_derivative_agrees_with_differences() -> None:
    q = np.linspace(0.0, 1.4, 200)[1:]
    step = 1e-5
    difference = (cubic_spline(q + step)[0] - cubic_spline(q - step)[0]) / (2 * step)
    # second-order differences: third derivative 24, which jumps at 0.5 and 1
    np.testing.assert_allclose(cubic_spline(q)[1], difference, atol=24 * step**2 + 1e-10)


def test_weight_derivative_is_continuous_where_the_pieces_meet() -> None:
    for q in (0.5, 1.0):
        below, above = (cubic_spline(np.array([q + s * 1e-9])) for s in (-1, 1))
        np.testing.assert_allclose(below, above, atol=1e-8)


@pytest.mark.parametrize("support", SUPPORTS)
def test_functions_sum_to_one_and_gradients_to_zero(support: float) -> None:
    phi, dphi, _ = regular_functions(points(10), support)
    np.testing.assert_allclose(phi.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(dphi.sum(axis=1), 0.0, atol=1e-11)


@pytest.mark.parametrize("support", SUPPORTS)
def test_linear_fields_are_reproduced_with_their_gradients(support: float) -> None:
    local = points(11)
    phi, dphi, nodes = regular_functions(local, support)
    np.testing.assert_allclose(phi @ nodes, local, atol=1e-12)
    gradient = np.einsum("nwd,wc->ncd", dphi, nodes)
    np.testing.assert_allclose(gradient, np.broadcast_to(np.eye(2), gradient.shape), atol=1e-11)


@pytest.mark.parametrize("support", SUPPORTS)
def test_quadratic_fields_are_not_reproduced(support: float) -> None:
    local = points(12)
    phi, _, nodes = regular_functions(local, support)
    assert np.abs(phi @ nodes[:, 0] ** 2 - local[:, 0] ** 2).max() > 0.05


@pytest.mark.parametrize("support", SUPPORTS)
def test_gradients_agree_with_differences(support: float) -> None:
    local = 0.01 + 0.98 * points(13)
    step = 1e-5
    _, dphi, _ = regular_functions(local, support)
    for axis in range(2):
        move = step * np.eye(2)[axis]
        difference = (regular_functions(local + move, support)[0] - regular_functions(local - move, support)[0]) / (
            2 * step
        )
        # truncation 1e-10 times the third derivative, at most 300 (support 1.2); rounding 1e-16 / step = 1e-11
        np.testing.assert_allclose(dphi[:, :, axis], difference, atol=5e-8)


@pytest.mark.parametrize("support", SUPPORTS)
def test_functions_are_continuous_from_cell_to_cell(support: float) -> None:
    """A node keeps its values and gradients across a cell's border: the window moves by one."""
    y = points(14)[:, 1]
    reach = math.ceil(support)
    right, left = (regular_functions(np.stack([np.full_like(y, x), y], axis=1), support)[:2] for x in (1.0, 0.0))
    for before, after in zip(right, left, strict=True):
        before, after = (a.reshape(len(y), 2 * reach, 2 * reach, -1) for a in (before, after))
        np.testing.assert_allclose(before[:, 1:], after[:, :-1], atol=1e-11)
        np.testing.assert_allclose(before[:, 0], 0.0, atol=1e-11)


@pytest.mark.parametrize("support", SUPPORTS)
def test_functions_have_the_symmetries_of_the_square(support: float) -> None:
    local = points(15)
    phi, _, nodes = regular_functions(local, support)
    side = 2 * math.ceil(support)
    mirrored = regular_functions(local * (-1, 1) + (1, 0), support)[0].reshape(-1, side, side)[:, ::-1]
    np.testing.assert_allclose(mirrored.reshape(phi.shape), phi, atol=1e-13)
    swapped = regular_functions(local[:, ::-1], support)[0].reshape(-1, side, side).transpose(0, 2, 1)
    np.testing.assert_allclose(swapped.reshape(phi.shape), phi, atol=1e-13)
    assert nodes.shape == (side**2, 2)


def test_nodes_without_weight_change_nothing() -> None:
    """Points may have differently many nodes: those that a point lies outside of need not be among its own."""
    local, support = points(18, 40), 1.75
    phi, dphi, nodes = regular_functions(local, support)
    point, node = np.nonzero(np.abs(nodes - local[:, None]).max(axis=2) < support)
    start = np.searchsorted(point, np.arange(len(local) + 1))
    assert len(set(np.diff(start))) > 1
    found = mls((nodes[node] - local[point]).T, np.full(len(node), support), start)
    np.testing.assert_allclose(found[0], phi[point, node], atol=1e-14)
    np.testing.assert_allclose(found[1:].T, dphi[point, node], atol=1e-13)


@pytest.mark.parametrize("support", SUPPORTS)
def test_functions_vanish_outside_of_their_patches(support: float) -> None:
    local = np.concatenate([points(16), [[0.0, 0.4], [0.3, 1.0]]])  # whole supports end on the cell's border only
    phi, dphi, nodes = regular_functions(local, support)
    outside = np.abs(nodes[None] - local[:, None]).max(axis=2) >= support
    assert outside.any()
    assert np.all(phi[outside] == 0.0)
    assert np.all(dphi[outside] == 0.0)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_functions_agree_with_a_least_squares_fit(support: float) -> None:
    """phi_i(x) is the value at x of the linear fit to a unit datum at node i, weighted round x."""
    local = points(17, 10)
    phi, _, nodes = regular_functions(local, support)
    for x, row in zip(local, phi, strict=True):
        w = np.prod(cubic_spline(np.abs(nodes - x) / support)[0], axis=1)
        design = np.column_stack([np.ones(len(nodes)), nodes - x])
        fit = np.linalg.lstsq(np.sqrt(w)[:, None] * design, np.diag(np.sqrt(w)), rcond=None)[0]
        np.testing.assert_allclose(row, fit[0], atol=1e-12)
