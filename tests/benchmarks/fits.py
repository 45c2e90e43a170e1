"""How seconds and memory grow with the number of unknowns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tests.benchmarks.record import Measurement

FEWEST = 3
"""Sizes from which on an exponent is fitted."""


def exponent(sizes: ArrayLike, values: ArrayLike) -> float:
    """Slope of log(values) over log(sizes) by least squares. Raises ValueError unless all are positive."""
    x, y = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    if not ((x > 0.0).all() and (y > 0.0).all()):
        raise ValueError("an exponent needs positive sizes and values")
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def same_program(measurements: Sequence[Measurement]) -> list[Measurement]:
    """The sizes measured with the commit of the last one, by unknowns."""
    sizes = [measured for measured in measurements if measured.part == "sizes"]
    same = [measured for measured in sizes if measured.environment.commit == sizes[-1].environment.commit]
    return sorted(same, key=lambda measured: measured.n_dofs)


def exponents(sizes: Sequence[Measurement]) -> dict[str, float]:
    """Of the whole step, of parts of it, and of memory; empty for fewer than `FEWEST` sizes."""
    if len(sizes) < FEWEST:
        return {}
    found = {
        "step": [m.step for m in sizes],
        "first step": [m.first for m in sizes],
        "step without factorization": [m.step - m.factorize for m in sizes],
        **{phase: [getattr(m, phase) for m in sizes] for phase in ("cover", "assembly", "factorize", "contact")},
        "bare factorization": [m.floor_factorize for m in sizes],
        "memory": [m.peak_MB for m in sizes],
    }
    return {name: exponent([m.n_dofs for m in sizes], values) for name, values in found.items()}
