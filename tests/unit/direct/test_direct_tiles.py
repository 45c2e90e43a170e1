"""Tiles of matrices that are symmetric."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.direct.tiles import TILE, lower_tiles, mirror

SIZES = (0, 1, TILE - 1, TILE, TILE + 1, 2 * TILE + 7)


@pytest.mark.parametrize("k", SIZES)
def test_tiles_hold_the_lower_triangle_once(k: int) -> None:
    times = np.zeros((k, k))
    for tile in lower_tiles(k):
        times[tile] += 1.0
    assert times.max(initial=0.0) <= 1.0
    assert (times[np.tril_indices(k)] == 1.0).all()


@pytest.mark.parametrize("k", SIZES)
def test_what_is_mirrored_is_the_lower_triangle(k: int) -> None:
    values = np.random.default_rng(k).normal(size=(k, k))
    lower = values.copy()
    mirror(lower)
    np.testing.assert_array_equal(lower, np.tril(values) + np.tril(values, -1).T)
