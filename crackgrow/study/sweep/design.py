"""How the values of the parameters are combined: a grid, a zip, or a Latin hypercube."""

from __future__ import annotations

import itertools

import numpy as np

from crackgrow.study.sweep.sweep_file import SweepFile

Combination = tuple[str, ...]
"""A value of each parameter, in the order of the file."""


def combinations(file: SweepFile) -> list[Combination]:
    """What is run: of a grid, the first parameter varies slowest."""
    if file.design == "latin_hypercube":
        assert file.samples is not None  # the reader has seen to it
        return _latin_hypercube(file, file.samples)
    columns = [values.texts for values in file.parameters.values()]
    return list(zip(*columns, strict=True)) if file.design == "zip" else list(itertools.product(*columns))


def _latin_hypercube(file: SweepFile, samples: int) -> list[Combination]:
    """As many runs as samples: of each parameter, every one of `samples` equal parts of its range is met once.

    McKay, Beckman, Conover 1979: parts in random order, a random place in each.
    """
    rng = np.random.default_rng(file.seed)
    columns = []
    for values in file.parameters.values():
        parts = (rng.permutation(samples) + rng.random(samples)) / samples
        columns.append(values.at(parts))
    return list(zip(*columns, strict=True))
