"""A coarser contact problem, each of whose points stands for two neighbours: where many points begin to look.

Points are numbered along the surfaces, so that neighbours in the problem are neighbours on a crack, but for its ends.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.problem import ContactProblem


def halved(problem: ContactProblem) -> ContactProblem | None:
    """The problem with equal tractions and mean jumps of every two points, None where these have no resistance."""
    A = _means(_sums(problem.compliance.T, 2).T, 2)
    if A.diagonal().min() <= 0.0:
        return None
    friction, cohesion, dilation, slipped = (
        _means(law, 1) for law in (problem.friction, problem.cohesion, problem.dilation, problem.slipped)
    )
    return ContactProblem(A, _means(problem.free, 2), friction, cohesion, dilation, slipped)


def doubled(problem: ContactProblem, p: Floats) -> Floats:
    """Tractions (2 n,) of a problem from those of its half."""
    n = problem.n_points
    return np.concatenate([np.repeat(block, 2)[:n] for block in p.reshape(-1, (n + 1) // 2)])


def _sums(values: Floats, blocks: int) -> Floats:
    """Sums of every two rows within each of as many `blocks`; the last row of a block may be left over."""
    n, m = len(values) // blocks, (len(values) // blocks + 1) // 2
    sums = np.empty((blocks * m, *values.shape[1:]))
    for block in range(blocks):
        there, those = sums[block * m : (block + 1) * m], values[block * n : (block + 1) * n]
        there[:] = those[::2]
        there[: n // 2] += those[1::2]
    return sums


def _means(values: Floats, blocks: int) -> Floats:
    """As `_sums`, divided by how many rows it is the sum of."""
    n = len(values) // blocks
    size = np.tile(np.where(np.arange(0, n, 2) + 1 < n, 2.0, 1.0), blocks)
    return np.asarray((_sums(values, blocks).T / size).T)
