"""Fields at points: the sums that the table of all functions gives, round one tip, many tips and on crumbs."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.approximation.basis import basis_at
from crackgrow.approximation.field import field_gradients, field_values
from crackgrow.cover.elements import locate

ROUND_OFF = 1e-12


def scene(build, name: str):
    """A sample: a crack all inside, 32 tips, or two cracks that cut a crumb of a third of a spacing out."""
    if name == "tips":
        return build.field_of_cracks(4)
    if name == "one crack":
        return build.sample((0.5, 0.5), (6.5, 5.5), [build.crack([(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)])], support=1.5)
    cracks = [
        build.crack([(1.0, 2.5), (5.0, 2.5)], name="base"),
        build.crack([(3.0, 2.5), (3.2, 2.8), (3.4, 2.5)], (False, False), name="roof"),
    ]
    return build.sample((0.5, 0.5), (6.5, 5.5), cracks)


def places(sample, n: int, seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Random points, most of them near the middle, and their elements."""
    rng = np.random.default_rng(seed)
    low, high = np.array(sample.region.bounds).reshape(2, 2)
    points = np.concatenate([rng.uniform(low, high, (n, 2)), (0.5 * (low + high)) + rng.normal(0.0, 0.3, (n, 2))])
    elements = locate(sample.lattice, sample.cover.elements, points)
    return points[elements >= 0], elements[elements >= 0]


@pytest.mark.parametrize("name", ["one crack", "tips", "crumb"])
@pytest.mark.parametrize("n", [1, 300])
def test_fields_are_the_sums_of_all_functions(build, name: str, n: int) -> None:
    sample = scene(build, name)
    cover = sample.cover
    points, elements = places(sample, n)
    coefficients = np.random.default_rng(6).normal(size=(cover.n_functions, 3))
    basis = basis_at(cover, points, elements)
    with_none = np.concatenate([coefficients, np.zeros((1, 3))])[basis.ids]
    values = np.einsum("nk,nkm->nm", basis.values, with_none)
    gradients = np.einsum("nkd,nkm->nmd", basis.gradients, with_none)
    assert cover.crumbs.n == (name == "crumb")
    assert name != "crumb" or n == 1 or (cover.crumbs.of_element[elements] >= 0).any()
    np.testing.assert_allclose(field_values(cover, coefficients, points, elements), values, atol=ROUND_OFF)
    size = np.abs(gradients).max()
    np.testing.assert_allclose(field_gradients(cover, coefficients, points, elements), gradients, atol=ROUND_OFF * size)


def test_no_points_have_no_values(build) -> None:
    cover = scene(build, "one crack").cover
    none, coefficients = np.empty(0, dtype=np.int64), np.ones((cover.n_functions, 2))
    assert field_values(cover, coefficients, np.empty((0, 2)), none).shape == (0, 2)
    assert field_gradients(cover, coefficients, np.empty((0, 2)), none).shape == (0, 2, 2)
