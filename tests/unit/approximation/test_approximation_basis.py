"""All functions at points: gradients, sides, unity, and no dependence on the cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at, functions_on, value_matrix, values_at
from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import tip_angle
from crackgrow.quadrature.elements import element_points

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]


def kinked(build, support: float, spacing: float = 1.0):
    crack = build.crack(np.array(KINKED) * spacing)
    return build.sample((0.5 * spacing,) * 2, (6.5 * spacing, 5.5 * spacing), [crack], spacing=spacing, support=support)


def inner_points(sample, seed: int, n: int = 400, radius: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Random points, half of them near the tips, with all points within `radius` in the same element."""
    rng = np.random.default_rng(seed)
    tips = np.array([tip.point for tip in sample.cover.tips])
    points = rng.uniform(sample.region.bounds[:2], sample.region.bounds[2:], (n, 2))
    points = np.concatenate([points, tips[rng.integers(len(tips), size=n)] + rng.normal(0, 0.2, (n, 2))])
    elements = locate(sample.lattice, sample.cover.elements, points)
    around = [points + radius * np.array(d) for d in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    same = [locate(sample.lattice, sample.cover.elements, p) == elements for p in around]
    far = np.hypot(*(points[:, None] - tips).transpose(2, 0, 1)).min(axis=1) > 0.02
    keep = np.all(same, axis=0) & (elements >= 0) & far
    return points[keep], elements[keep]


@pytest.mark.parametrize("spacing", [1.0, 1e-3])
@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_gradients_of_all_functions_agree_with_differences(build, support: float, spacing: float) -> None:
    sample = kinked(build, support, spacing)
    points, elements = inner_points(sample, 20)
    basis = basis_at(sample.cover, points, elements)
    n = sample.cover.n_functions
    assert len(points) > 400
    assert (value_matrix(basis, n).count_nonzero(axis=0) > 0).sum() > 0.9 * n  # nearly all functions are seen
    step = 1e-6
    for axis in range(2):
        exact = value_matrix(replace(basis, values=basis.gradients[:, :, axis]), n)
        move = step * np.eye(2)[axis]
        ahead, behind = (value_matrix(basis_at(sample.cover, points + s * move, elements), n) for s in (1, -1))
        difference = (ahead - behind) / (2 * step * spacing)
        # step^2 times the third derivative r^-2.5 = 2e4 at r = 0.02: 2e-8; rounding 1e-16 / step
        assert np.abs(exact - difference).max() * spacing < 5e-8


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_plain_functions_sum_to_one_and_reproduce_positions_everywhere(build, support: float) -> None:
    """On both sides of the crack: constants and linear fields cross it, as if it were not there."""
    sample = kinked(build, support)
    points = element_points(sample.cover, 2)
    n = len(sample.cover.patch_nodes)
    values = value_matrix(basis_at(sample.cover, points.points, points.element), sample.cover.n_functions)[:, :n]
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(values @ sample.cover.patch_nodes, points.points, atol=1e-12)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_values_differ_on_the_faces_only_by_pieces_and_sines(build, support: float) -> None:
    """At a crack point: phi is the same from both sides, but belongs to other pieces where the patch is cut."""
    sample = kinked(build, support)
    edges = sample.cover.elements.lines[0]
    middles = edges.points.mean(axis=1)
    plus, minus = (basis_at(sample.cover, middles, side) for side in (edges.plus, edges.minus))
    window = sample.lattice.window
    np.testing.assert_allclose(plus.values[:, :window], minus.values[:, :window], atol=1e-14)
    n_patches = len(sample.cover.patch_nodes)
    first, second = (value_matrix(basis, sample.cover.n_functions).toarray() for basis in (plus, minus))
    np.testing.assert_allclose((first - second)[:, :n_patches].sum(axis=1), 0.0, atol=1e-13)
    cut = plus.ids[:, :window] != minus.ids[:, :window]
    assert cut.any(axis=1).sum() > 0.3 * len(middles)


def test_faces_next_to_a_tip_share_the_patches_and_open_by_the_sines(build) -> None:
    sample = build.block((6, 5), [build.crack([(1.7, 2.5), (4.2, 2.5)])], 2.0)
    edges = sample.cover.elements.lines[0]
    tip = sample.cover.tips[1]
    point = tip.point - (1e-3, 0.0)
    plus, minus = (
        value_matrix(basis_at(sample.cover, point[None], side[-1:]), sample.cover.n_functions).toarray()[0]
        for side in (edges.plus, edges.minus)
    )
    first = sample.cover.tip_function_ids[1]
    phi = plus[: len(first)]
    jump = plus - minus
    singular = np.flatnonzero(first >= 0)
    r = 1e-3
    chi = (1 - (r / 2.5) ** 2) ** 2
    four = jump[first[singular][:, None] + np.arange(4)]
    np.testing.assert_allclose(four, np.outer(phi[singular], chi * np.sqrt(r) * np.array([0, 2, 0, -2])), atol=1e-13)
    assert phi[singular].sum() == pytest.approx(1.0, abs=1e-12)  # every patch round the tip is singular


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_every_uncut_cell_has_the_same_functions(build, support: float) -> None:
    sample = build.block((6, 5), support=support)
    cells = np.array([[2, 2], [4, 3], [5, 4]]) + sample.lattice.reach
    local = np.array([0.31, 0.17])
    points = cells + local
    basis = basis_at(sample.cover, points, locate(sample.lattice, sample.cover.elements, points))
    for row in (1, 2):
        np.testing.assert_allclose(basis.values[row], basis.values[0], atol=1e-14)
        np.testing.assert_allclose(basis.gradients[row], basis.gradients[0], atol=1e-13)
        moved = sample.cover.patch_nodes[basis.ids[row]] - sample.cover.patch_nodes[basis.ids[0]]
        used = basis.ids[0] >= 0
        np.testing.assert_array_equal(moved[used], np.broadcast_to(cells[row] - cells[0], moved[used].shape))


def test_evaluating_some_points_gives_the_same_as_evaluating_all(build) -> None:
    sample = kinked(build, 2.0)
    points, elements = inner_points(sample, 21, 100)
    n = sample.cover.n_functions
    together = value_matrix(basis_at(sample.cover, points, elements), n).toarray()
    for k in range(0, len(points), 10):
        alone = value_matrix(basis_at(sample.cover, points[k : k + 1], elements[k : k + 1]), n).toarray()
        np.testing.assert_allclose(alone[0], together[k], atol=1e-15)  # vector loops round differently


def one_tip_at_a_time(sample, points: np.ndarray, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All functions (n, n_functions) and gradients (n, n_functions, 2): phi_i, and phi_i times each tip's functions."""
    cover, lattice = sample.cover, sample.lattice
    cell = np.floor(points)  # tiles are cells at support 2
    phi, dphi = mls(points - cell, lattice.support, lattice.reach)
    values = np.zeros((len(points), cover.n_functions))
    gradients = np.zeros((len(points), cover.n_functions, 2))
    row, slot = np.nonzero(cover.functions[elements] >= 0)
    patch = cover.functions[elements][row, slot]
    values[row, patch], gradients[row, patch] = phi[row, slot], dphi[row, slot]
    for tip, first in zip(cover.tips, cover.tip_function_ids, strict=True):
        f, df = tip_functions(tip, *tip_angle(tip, points, cover.elements.reference[elements]))
        for p in np.flatnonzero(first >= 0):
            four = slice(first[p], first[p] + 4)
            values[:, four] = values[:, [p]] * f
            gradients[:, four] = gradients[:, [p]] * f[:, :, None] + values[:, [p], None] * df
    return values, gradients / lattice.spacing


def test_functions_of_many_tips_are_those_of_one_tip_at_a_time_in_few_columns(build) -> None:
    sample = build.field_of_cracks(4)
    cover = sample.cover
    points, elements = inner_points(sample, 23, 300)
    expected, expected_gradients = one_tip_at_a_time(sample, points, elements)
    basis, values = basis_at(cover, points, elements), values_at(cover, points, elements)
    dense = value_matrix(basis, cover.n_functions).toarray()
    np.testing.assert_allclose(dense, expected, atol=1e-14)
    np.testing.assert_allclose(value_matrix(values, cover.n_functions).toarray(), expected, atol=1e-14)
    for axis in range(2):
        found = value_matrix(replace(basis, values=basis.gradients[:, :, axis]), cover.n_functions).toarray()
        size = 1.0 + np.abs(expected_gradients[:, :, axis])
        assert (np.abs(found - expected_gradients[:, :, axis]) / size).max() < 1e-13
    singular = np.array([(first >= 0)[cover.functions[elements]] & (cover.functions[elements] >= 0)
                         for first in cover.tip_function_ids])  # fmt: skip
    acting = singular.any(axis=2).sum(axis=0)
    assert len(cover.tips) == 32
    assert acting.max() <= len(cover.tips) // 4  # a point sees few of them
    needed = singular.sum(axis=(0, 2)).max()
    assert basis.ids.shape[1] == sample.lattice.window + 4 * needed


def test_many_tips_leave_unity_and_derivatives_as_they_are(build) -> None:
    sample = build.field_of_cracks(4)
    points, elements = inner_points(sample, 24, 300)
    n = sample.cover.n_functions
    basis = basis_at(sample.cover, points, elements)
    n_patches = len(sample.cover.patch_nodes)
    np.testing.assert_allclose(value_matrix(basis, n)[:, :n_patches].sum(axis=1), 1.0, rtol=1e-12)
    step = 1e-6
    for axis in range(2):
        exact = value_matrix(replace(basis, values=basis.gradients[:, :, axis]), n)
        move = step * np.eye(2)[axis]
        ahead, behind = (value_matrix(basis_at(sample.cover, points + s * move, elements), n) for s in (1, -1))
        assert np.abs(exact - (ahead - behind) / (2 * step)).max() < 5e-8  # as for one crack


def test_functions_on_elements_are_the_columns_of_their_basis(build) -> None:
    cover = build.field_of_cracks(2).cover
    elements = np.arange(cover.elements.n)[::-1]
    start, ids = functions_on(cover, elements)
    columns = basis_at(cover, cover.elements.reference[elements], elements).ids
    for row, first, last in zip(columns, start[:-1], start[1:], strict=True):
        np.testing.assert_array_equal(np.sort(ids[first:last]), np.sort(row[row >= 0]))
        assert len(np.unique(ids[first:last])) == last - first
