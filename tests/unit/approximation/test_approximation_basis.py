"""All functions at points: gradients, sides, unity, and no dependence on the cell."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at, fields_at, values_at
from crackgrow.cover.elements import locate
from crackgrow.cover.tips import tip_angle
from crackgrow.quadrature.elements import element_points
from tests.unit.approximation.tip_values import at_polar
from tests.unit.cover_tables import function_table, gradient_rows, patch_table
from tests.unit.regular_functions import regular_functions

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
    assert (basis.rows.count_nonzero(axis=0) > 0).sum() > 0.9 * n  # nearly all functions are seen
    step = 1e-6
    for axis in range(2):
        exact = gradient_rows(basis)[axis]
        move = step * np.eye(2)[axis]
        ahead, behind = (values_at(sample.cover, points + s * move, elements).rows for s in (1, -1))
        difference = (ahead - behind) / (2 * step * spacing)
        # step^2 times the third derivative r^-2.5 = 2e4 at r = 0.02: 2e-8; rounding 1e-16 / step
        assert np.abs(exact - difference).max() * spacing < 5e-8


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_plain_functions_sum_to_one_and_reproduce_positions_everywhere(build, support: float) -> None:
    """On both sides of the crack: constants and linear fields cross it, as if it were not there."""
    sample = kinked(build, support)
    points = element_points(sample.cover, 2)
    n = len(sample.cover.patches.nodes)
    values = values_at(sample.cover, points.points, points.element).rows[:, :n]
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(values @ sample.cover.patches.nodes, points.points, atol=1e-12)


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_values_differ_on_the_faces_only_by_pieces_and_sines(build, support: float) -> None:
    """At a crack point: phi is the same from both sides, but belongs to other pieces where the patch is cut."""
    sample = kinked(build, support)
    edges = sample.cover.elements.lines[0]
    middles = edges.points.mean(axis=1)
    plus, minus = (basis_at(sample.cover, middles, side) for side in (edges.plus, edges.minus))
    n_patches, of_patches = (
        len(sample.cover.patches.nodes),
        [basis.functions < len(sample.cover.patches.nodes) for basis in (plus, minus)],
    )
    np.testing.assert_array_equal(plus.start, minus.start)
    np.testing.assert_allclose(plus.values[0, of_patches[0]], minus.values[0, of_patches[1]], atol=1e-14)
    first, second = (basis.rows.toarray() for basis in (plus, minus))
    np.testing.assert_allclose((first - second)[:, :n_patches].sum(axis=1), 0.0, atol=1e-13)
    cut = np.repeat(np.arange(len(middles)), np.diff(plus.start))[plus.functions != minus.functions]
    assert len(np.unique(cut)) > 0.3 * len(middles)


def test_faces_next_to_a_tip_share_the_patches_and_open_by_the_sines(build) -> None:
    sample = build.block((6, 5), [build.crack([(1.7, 2.5), (4.2, 2.5)])], 2.0)
    edges = sample.cover.elements.lines[0]
    tip = sample.cover.tips[1]
    point = tip.point - (1e-3, 0.0)
    plus, minus = (
        values_at(sample.cover, point[None], side[-1:]).rows.toarray()[0] for side in (edges.plus, edges.minus)
    )
    singular, first = tip.patches, tip.functions
    phi = plus[: len(sample.cover.patches.nodes)]
    jump = plus - minus
    r = 1e-3
    chi = (1 - (r / 2.5) ** 2) ** 2
    four = jump[first[:, None] + np.arange(4)]
    np.testing.assert_allclose(four, np.outer(phi[singular], chi * np.sqrt(r) * np.array([0, 2, 0, -2])), atol=1e-13)
    assert phi[singular].sum() == pytest.approx(1.0, abs=1e-12)  # every patch round the tip is singular


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_every_uncut_cell_has_the_same_functions(build, support: float) -> None:
    sample = build.block((6, 5), support=support)
    cells = np.array([[2, 2], [4, 3], [5, 4]]) + sample.lattice.reach
    local = np.array([0.31, 0.17])
    points = cells + local
    basis = basis_at(sample.cover, points, locate(sample.lattice, sample.cover.elements, points))
    rows = np.stack([matrix.data.reshape(len(cells), -1) for matrix in (basis.rows, *gradient_rows(basis))])
    functions = basis.functions.reshape(len(cells), -1)
    for row in (1, 2):
        np.testing.assert_allclose(rows[:, row], rows[:, 0], atol=1e-13)
        moved = sample.cover.patches.nodes[functions[row]] - sample.cover.patches.nodes[functions[0]]
        np.testing.assert_array_equal(moved, np.broadcast_to(cells[row] - cells[0], moved.shape))


def test_evaluating_some_points_gives_the_same_as_evaluating_all(build) -> None:
    sample = kinked(build, 2.0)
    points, elements = inner_points(sample, 21, 100)
    together = values_at(sample.cover, points, elements).rows.toarray()
    for k in range(0, len(points), 10):
        alone = values_at(sample.cover, points[k : k + 1], elements[k : k + 1]).rows.toarray()
        np.testing.assert_allclose(alone[0], together[k], atol=1e-15)  # vector loops round differently


def one_tip_at_a_time(sample, points: np.ndarray, elements: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All functions (n, n_functions) and gradients (n, n_functions, 2): phi_i, and phi_i times each tip's functions."""
    cover, lattice = sample.cover, sample.lattice
    cell = np.floor(points)  # tiles are cells at support 2
    phi, dphi, _ = regular_functions(points - cell, lattice.support)
    values = np.zeros((len(points), cover.n_functions))
    gradients = np.zeros((len(points), cover.n_functions, 2))
    table = patch_table(cover)[elements]
    row, slot = np.nonzero(table >= 0)
    patch = table[row, slot]
    values[row, patch], gradients[row, patch] = phi[row, slot], dphi[row, slot]
    for tip, first in zip(cover.tips, function_table(cover), strict=True):
        f, df = at_polar(tip, *tip_angle(tip, points, cover.elements.reference[elements]))
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
    for found in (basis, values):
        np.testing.assert_allclose(found.rows.toarray(), expected, atol=1e-14)
    for axis, found in enumerate(gradient_rows(basis)):
        size = 1.0 + np.abs(expected_gradients[:, :, axis])
        assert (np.abs(found.toarray() - expected_gradients[:, :, axis]) / size).max() < 1e-13
    table = patch_table(cover)[elements]
    singular = np.array([(first >= 0)[table] & (table >= 0) for first in function_table(cover)])
    acting = singular.any(axis=2).sum(axis=0)
    assert len(cover.tips) == 32
    assert acting.max() <= len(cover.tips) // 4  # a point sees few of them
    needed = (table >= 0).sum(axis=1) + 4 * singular.sum(axis=(0, 2))
    np.testing.assert_array_equal(np.diff(basis.rows.indptr), needed)


def test_many_tips_leave_unity_and_derivatives_as_they_are(build) -> None:
    sample = build.field_of_cracks(4)
    points, elements = inner_points(sample, 24, 300)
    basis = basis_at(sample.cover, points, elements)
    n_patches = len(sample.cover.patches.nodes)
    np.testing.assert_allclose(basis.rows[:, :n_patches].sum(axis=1), 1.0, rtol=1e-12)
    step = 1e-6
    for axis in range(2):
        exact = gradient_rows(basis)[axis]
        move = step * np.eye(2)[axis]
        ahead, behind = (values_at(sample.cover, points + s * move, elements).rows for s in (1, -1))
        assert np.abs(exact - (ahead - behind) / (2 * step)).max() < 5e-8  # as for one crack


def scene(build, name: str):
    """A sample: a crack all inside, 32 tips, or two cracks that cut a crumb of a third of a spacing out."""
    if name == "tips":
        return build.field_of_cracks(4)
    if name == "one crack":
        return kinked(build, 1.5)
    cracks = [
        build.crack([(1.0, 2.5), (5.0, 2.5)], name="base"),
        build.crack([(3.0, 2.5), (3.2, 2.8), (3.4, 2.5)], (False, False), name="roof"),
    ]
    return build.sample((0.5, 0.5), (6.5, 5.5), cracks)


@pytest.mark.parametrize("name", ["one crack", "tips", "crumb"])
@pytest.mark.parametrize("n", [0, 1, 300])
def test_fields_are_the_products_with_all_rows(build, name: str, n: int) -> None:
    sample = scene(build, name)
    cover = sample.cover
    middle = np.mean(np.array(sample.region.bounds).reshape(2, 2), axis=0)
    points = middle + np.random.default_rng(5).normal(0.0, 0.4, (n, 2))
    elements = locate(sample.lattice, cover.elements, points)
    points, elements = points[elements >= 0], elements[elements >= 0]
    coefficients = np.random.default_rng(6).normal(size=(cover.n_functions, 3))
    basis = basis_at(cover, points, elements)
    assert cover.patches.in_crumb.any() == (name == "crumb")
    assert name != "crumb" or n < 300 or cover.patches.in_crumb[elements].any()
    expected = [matrix @ coefficients for matrix in (basis.rows, *gradient_rows(basis))]
    for found, exact in zip(fields_at(cover, coefficients, points, elements), expected, strict=True):
        np.testing.assert_allclose(found, exact, atol=1e-12 * np.abs(exact).max(initial=1.0))
    (values,) = fields_at(cover, coefficients, points, elements, derivatives=False)
    np.testing.assert_allclose(values, expected[0], atol=1e-12)
