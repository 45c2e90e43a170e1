"""Places on the map: what was computed from the origin of a case, brought back to the coordinates of its map."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any, Final, TypeVar

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.formula import CoordinateFormula
from crackgrow.case.model import Case

T = TypeVar("T")

PLACES: Final = ("points", "point", "lines", "place")
"""Fields of all frozen data, of cases and of results, that hold places (..., 2) m."""


def on_map(thing: T, origin: tuple[float, float]) -> T:
    """The same with all its places moved by an origin (m): of results, and of cases where these are drawn."""
    return _moved(thing, np.array(origin), "") if any(origin) else thing


def case_on_map(case: Case) -> Case:
    """The case as it is drawn over its results; it is not for computing: coordinates of a map lose digits."""
    return replace(on_map(case, case.origin), origin=(0.0, 0.0)) if any(case.origin) else case


def extent(case: Case) -> tuple[Floats, Floats]:
    """Lower left and upper right corner (2,) m of the box round all bodies, on the map."""
    outlines = np.concatenate([body.outline for body in case.bodies]) + case.origin
    return outlines.min(axis=0), outlines.max(axis=0)


def length_unit(case: Case) -> tuple[float, str]:
    """How many of the unit that suits the scene are a metre, and its name."""
    low, high = extent(case)
    return (1e3, "mm") if (high - low).max() < 1 else (1.0, "m")


def _moved(value: Any, by: Any, name: str) -> Any:
    if isinstance(value, CoordinateFormula):
        return replace(value, origin=(0.0, 0.0))
    if isinstance(value, np.ndarray):
        return value + by if name in PLACES else value
    if isinstance(value, tuple):
        if name == "place":
            return tuple((by + value).tolist())
        return tuple(_moved(item, by, name) for item in value)
    if not is_dataclass(value) or isinstance(value, type):
        return value
    parts = {part.name: _moved(getattr(value, part.name), by, part.name) for part in fields(value)}
    changed = {key: part for key, part in parts.items() if part is not getattr(value, key)}
    return replace(value, **changed) if changed else value
