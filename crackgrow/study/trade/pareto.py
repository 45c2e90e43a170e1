"""The Pareto front: what nothing else beats in both cost and error."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats, Ints


def pareto_front(cost: Floats, error: Floats) -> Ints:
    """Numbers (k,) of the points (n,) on the front, in order of cost; points that are not finite are on none.

    A point is on it if no other has at most its cost and at most its error and less of one of them. Of equal points
    the first stands for all.
    """
    known = np.flatnonzero(np.isfinite(cost) & np.isfinite(error))
    order = known[np.lexsort((error[known], cost[known]))]
    best = np.minimum.accumulate(error[order])
    before = np.concatenate([[np.inf], best[:-1]])
    return np.asarray(order[error[order] < before], dtype=np.int64)
