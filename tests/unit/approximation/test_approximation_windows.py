"""Functions across cells of several sizes: they add up to one, reproduce linear fields, and know their slopes."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at, values_at
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from tests.unit.cover_tables import gradient_rows

SIZE = (6, 5)
CRACK = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]
PLACES = [CRACK[0], CRACK[2], (5.6, 4.9)]
"""Where cells are small: at the tips, and at a place on the way to a corner of the body."""


def graded(build, support: float, levels: int):
    return build.block(SIZE, [build.crack(CRACK)], support, levels, PLACES)


def some_points(sample, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random points of the body, most of them near small cells, and their elements."""
    rng = np.random.default_rng(seed)
    places = sample.lattice.to_lattice(np.array(PLACES))
    near = places[rng.integers(len(places), size=1200)] + rng.choice([1.0, 0.3, 0.05], 1200)[:, None] * rng.normal(
        size=(1200, 2)
    )
    points = np.concatenate([rng.uniform(sample.region.bounds[:2], sample.region.bounds[2:], (300, 2)), near])
    elements = locate(sample.lattice, sample.cover.elements, points)
    return points[elements >= 0], elements[elements >= 0]


def plain(cover: Cover, components: list) -> list[np.ndarray]:
    """The columns of the functions that are no tip functions."""
    return [component[:, : len(cover.patches.nodes)] for component in components]


@pytest.mark.parametrize("levels", range(7))
@pytest.mark.parametrize("support", [1.25, 1.5, 2.0, 2.5])
def test_unity_and_linear_fields_through_changes_of_size(build, support: float, levels: int) -> None:
    sample = graded(build, support, levels if support > 1.25 else min(levels, 3))
    points, elements = some_points(sample, levels)
    cover, nodes = sample.cover, sample.cover.patches.nodes
    assert cover.sizes[elements].min() == 0.5 ** (levels if support > 1.25 else min(levels, 3))
    basis = basis_at(cover, points, elements)
    values, along_x, along_y = plain(cover, [basis.rows, *gradient_rows(basis)])
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(values @ nodes, points, rtol=1e-12)
    size = cover.sizes[elements]
    for slope, exact in ((along_x, (1.0, 0.0)), (along_y, (0.0, 1.0))):
        assert np.abs(slope.sum(axis=1) * size).max() < 1e-10
        assert np.abs((slope @ nodes - exact) * np.minimum(size, 1.0)[:, None]).max() < 1e-10
    alone = plain(cover, [values_at(cover, points, elements).rows])[0]
    assert np.abs(values - alone).max() < 1e-13


@pytest.mark.parametrize("levels", [1, 3, 6])
@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_slopes_agree_with_differences(build, support: float, levels: int) -> None:
    sample = graded(build, support, levels)
    cover = sample.cover
    points, elements = some_points(sample, levels + 20)
    tips = np.array([tip.point for tip in cover.tips])
    step = 1e-5 * cover.sizes[elements]
    far = np.hypot(*(points[:, None] - tips).transpose(2, 0, 1)).min(axis=1) > 0.1 * cover.sizes[elements]
    around = [points + 2.0 * step[:, None] * np.array(d) for d in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    inside = far & np.all([locate(sample.lattice, cover.elements, p) == elements for p in around], axis=0)
    points, elements, step = points[inside], elements[inside], step[inside]
    assert len(points) > 700
    gradients = gradient_rows(basis_at(cover, points, elements))
    for axis in range(2):
        move = step[:, None] * np.eye(2)[axis]
        ahead, behind = (values_at(cover, points + s * move, elements).rows for s in (1.0, -1.0))
        difference = (ahead - behind).toarray() / (2.0 * step[:, None])
        # per side of a cell: third derivatives of 300, at tips of 0.1^-2.5, times step^2; rounding 1e-16 / 1e-5
        assert (np.abs(gradients[axis].toarray() - difference).max(axis=1) * cover.sizes[elements]).max() < 3e-7


@pytest.mark.parametrize("levels", [1, 4])
@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_functions_are_continuous_where_sizes_change(build, support: float, levels: int) -> None:
    """On an edge in the rock the functions are the same from both of its sides, their slopes as well."""
    sample = graded(build, support, levels)
    cover, edges = sample.cover, sample.cover.elements.edges
    both = np.flatnonzero(cover.elements.passable)
    sizes = cover.sizes[edges.left[both]], cover.sizes[edges.right[both]]
    change = both[sizes[0] != sizes[1]]
    assert len(change) >= 10
    share = np.random.default_rng(levels).uniform(0.0, 1.0, (len(change), 1))
    a, b = (cover.elements.vertices[ends[change]] for ends in (edges.a, edges.b))
    points = a + share * (b - a)
    one, other = (basis_at(cover, points, side[change]) for side in (edges.left, edges.right))
    assert np.abs(one.rows - other.rows).max() < 1e-12
    for slope, beyond in zip(gradient_rows(one), gradient_rows(other), strict=True):
        assert np.abs((slope - beyond).toarray() * cover.sizes[edges.left[change], None]).max() < 1e-10


@pytest.mark.parametrize("support", [1.5, 2.0, 2.5])
def test_moments_are_as_well_conditioned_as_on_one_size(build, support: float) -> None:
    """The sum of the absolute values of all functions at a point bounds how far errors are blown up."""
    worst = []
    for levels in (0, 2, 6):
        sample = graded(build, support, levels)
        points, elements = some_points(sample, 5)
        values = plain(sample.cover, [values_at(sample.cover, points, elements).rows])[0]
        worst.append(np.abs(values).sum(axis=1).max())
    assert max(worst) < 1.5 * worst[0]
