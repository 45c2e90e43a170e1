"""Fields that are finite, and small enough that their products are: anything else is named, not passed on."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.errors import SolveError

LARGEST = 1e100
"""Forces and stiffnesses, in SI, beyond which energies may overflow."""

LARGEST_STRAIN = 1e60
"""Displacements over the spacing beyond which stresses and their squares may overflow."""


def check_magnitude(field: str, values: Floats, largest: float, unit: str) -> None:
    """Raise SolveError, naming the `field`, unless all values are finite and none is larger than `largest`."""
    size = float(np.abs(values).max(initial=0.0))
    if not size <= largest:  # false for what is not a number, too
        raise SolveError(
            f"{field}: a value is {size:.3g} {unit}, wanted: finite, at most {largest:g} {unit}; "
            "check the units and sizes of loads, lengths and moduli"
        )
