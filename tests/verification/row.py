"""A row of the verification table: a quantity that the program computes beside what it should be."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

Measure = Literal["relative", "absolute", "at most", "at least"]
"""How the error is taken: (value - reference)/reference, value - reference, or how far the bound is passed."""


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


@dataclass(frozen=True, slots=True)
class Outcome:
    """A row with its value and its error; what was raised in place of them makes the row fail, not the whole table."""

    row: Row
    value: float
    error: float
    failure: str
    seconds: float

    @property
    def within(self) -> bool:
        """Whether the error is within its tolerance."""
        return abs(self.error) <= self.row.tolerance  # False for nan

    @property
    def share(self) -> float:
        """The error over its tolerance; for bounds that may not be passed 0 or infinite."""
        return abs(self.error) / self.row.tolerance if self.row.tolerance else (0.0 if self.within else float("inf"))


def gone() -> float:
    """What stands for the value's function in an outcome: processes cannot hand on all functions."""
    return float("nan")


def evaluate(row: Row) -> Outcome:
    """Compute a row."""
    started = time.perf_counter()
    value, error, failure = float("nan"), float("nan"), ""
    try:
        value = float(row.value())
        error = error_of(row, value)
    except Exception as fault:
        failure = f"{type(fault).__name__}: {fault}"
    return Outcome(replace(row, value=gone), value, error, failure, time.perf_counter() - started)


def error_of(row: Row, value: float) -> float:
    """Signed error of a value in the row's measure."""
    difference = value - row.reference
    match row.measure:
        case "relative":
            return difference / abs(row.reference) if row.reference else difference
        case "absolute":
            return difference
        case "at most":
            return max(difference, 0.0)
        case "at least":
            return min(difference, 0.0)
