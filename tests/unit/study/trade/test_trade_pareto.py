"""The Pareto front: what its definition says, for any points."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from crackgrow.study.trade.picture import pareto_front


def beats(a: tuple[float, float], b: tuple[float, float]) -> bool:
    """Whether a is nowhere worse than b, and better in one of the two."""
    return a[0] <= b[0] and a[1] <= b[1] and a != b


@pytest.mark.parametrize("seed", range(30))
def test_front_is_what_nothing_beats(seed: int):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 60))
    points = rng.integers(0, 12, size=(n, 2)).astype(float)  # few values: many ties
    points[rng.random((n, 2)) < 0.1] = np.nan
    front = pareto_front(*points.T).tolist()
    whole = [i for i in range(n) if np.isfinite(points[i]).all()]
    pairs = {i: (points[i, 0], points[i, 1]) for i in whole}
    unbeaten = {pair for pair in pairs.values() if not any(beats(other, pair) for other in pairs.values())}
    assert {pairs[i] for i in front} == unbeaten
    assert len(front) == len(unbeaten)  # one of equal ones
    assert all(pairs[i][0] < pairs[j][0] and pairs[i][1] > pairs[j][1] for i, j in pairwise(front))


def test_front_of_nothing_is_empty():
    assert len(pareto_front(np.empty(0), np.empty(0))) == 0
    assert len(pareto_front(np.array([np.nan]), np.array([1.0]))) == 0
