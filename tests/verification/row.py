"""A row of the verification table: a quantity that the program computes beside what it should be."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import pytest

Measure = Literal["relative", "absolute", "at most", "at least"]
"""How the error is taken: (value - reference)/reference, value - reference, or how far the bound is passed."""

Record = Callable[[str, object], None]
"""Pytest's `record_property`."""


@dataclass(frozen=True, slots=True)
class Row:
    """What is compared, with what, and how far apart the two may be; a reference of zero: the value is an error."""

    scene: str  # the case file or what stands in for one, and what is set there
    quantity: str  # with its unit in brackets
    value: Callable[[], float]  # solves, or finds solved, what it needs
    reference: float
    source: str  # file, paper or formula
    tolerance: float
    measure: Measure = "relative"
    slow: bool = False  # takes a minute or more

    def error(self, value: float) -> float:
        """Signed error of a value in the row's measure."""
        difference = value - self.reference
        match self.measure:
            case "relative":
                return difference / abs(self.reference) if self.reference else difference
            case "absolute":
                return difference
            case "at most":
                return max(difference, 0.0)
            case "at least":
                return min(difference, 0.0)

    def check(self, record: Record) -> None:
        """Compute the row, record it for the table, and fail where its error is beyond the tolerance."""
        value = float(self.value())
        error = self.error(value)
        told = {
            "scene": self.scene,
            "quantity": self.quantity,
            "value": value,
            "reference": self.reference,
            "measure": self.measure,
            "error": error,
            "tolerance": self.tolerance,
            "source": self.source,
        }
        record("row", json.dumps(told))  # processes hand on texts, but no numbers of NumPy
        assert abs(error) <= self.tolerance, f"{value} in place of {self.reference}: {self.source}"


def parameters(*groups: Iterable[Row]) -> list[object]:
    """Rows as the parameters of a test."""
    return [
        pytest.param(row, id=f"{row.scene}, {row.quantity}", marks=[pytest.mark.slow] if row.slow else [])
        for row in chain(*groups)
    ]
