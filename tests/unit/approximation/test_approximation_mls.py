"""Weight and moving least squares on the lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.unit.regular_functions import functions_of, regular_functions

SUPPORTS = (1.2, 1.5, 1.75, 2.0, 2.5, 3.0)


def points(seed: int, n: int = 200) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 1, (n, 2))


def test_weight_is_the_cubic_spline() -> None:
    """Two groups of nodes mirrored about the point: phi follow from ratios of w(q) = 4/3 ((1-q)^3 - 4 (1/2-q)^3)."""
    for a, b in ((0.2, 0.4), (0.3, 0.8), (0.6, 0.9)):
        nodes = np.array([(s * d, t) for d in (a, b) for s in (-1.0, 1.0) for t in (-0.1, 0.1)])
        phi = functions_of(nodes, np.zeros(2), 1.0)[0]
        w = [4 / 3 * ((1 - q) ** 3 - 4 * max(0.5 - q, 0.0) ** 3) for q in (a, b)]
        np.testing.assert_allclose(phi[:4], w[0] / (4.0 * (w[0] + w[1])), rtol=1e-13)
        np.testing.assert_allclose(phi[4:], w[1] / (4.0 * (w[0] + w[1])), rtol=1e-13)


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
    counts = set()
    for at, values, slopes in zip(local, phi, dphi, strict=True):
        seen = np.abs(nodes - at).max(axis=1) < support
        counts.add(int(seen.sum()))
        found = functions_of(nodes[seen], at, support)
        np.testing.assert_allclose(found[0], values[seen], atol=1e-14)
        np.testing.assert_allclose(found[1:].T, slopes[seen], atol=1e-13)
    assert len(counts) > 1
