"""Where a case and its parts lie, and what they are called, for words and drawings."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.formula import CoordinateFormula
from crackgrow.case.model import Case, Component
from crackgrow.results.units import STRESSES, stress_text

LONGEST = 60  # signs of a formula that are shown


def extent(case: Case) -> tuple[Floats, Floats]:
    """Lower left and upper right corner (2,) m of the box round all bodies, on the map."""
    outlines = np.concatenate([body.outline for body in case.bodies]) + case.origin
    return outlines.min(axis=0), outlines.max(axis=0)


def length_unit(case: Case) -> tuple[float, str]:
    """How many of the unit that suits the scene are a metre, and its name."""
    low, high = extent(case)
    return (1e3, "mm") if (high - low).max() < 1 else (1.0, "m")


def component_text(value: Component) -> str:
    """A stress (Pa), or the formula that it follows, with its begin alone where it is long."""
    if isinstance(value, CoordinateFormula):
        size, text = value.scaled
        unit = next((name for unit, name in STRESSES if unit == size), None)
        text, unit = (text, unit) if unit else (value.text, "Pa")
        return f"{text if len(text) <= LONGEST else f'{text[:LONGEST]}...'} [{unit}]"
    return "by a formula" if callable(value) else stress_text(value)
