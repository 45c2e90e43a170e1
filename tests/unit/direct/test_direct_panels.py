"""Panels of matrices that are symmetric."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.direct.panels import PANEL, fill_upper, lower_panels

SIZES = (0, 1, PANEL - 1, PANEL, PANEL + 1, 2 * PANEL + 7)


@pytest.mark.parametrize("k", SIZES)
def test_panels_hold_the_lower_triangle_once(k: int) -> None:
    times = np.zeros((k, k))
    for panel in lower_panels(k):
        times[panel] += 1.0
    assert times.max(initial=0.0) <= 1.0
    assert (times[np.tril_indices(k)] == 1.0).all()


@pytest.mark.parametrize("k", SIZES)
def test_the_upper_triangle_is_that_below(k: int) -> None:
    values = np.random.default_rng(k).normal(size=(k, k))
    lower = values.copy()
    fill_upper(lower)
    np.testing.assert_array_equal(lower, np.tril(values) + np.tril(values, -1).T)
