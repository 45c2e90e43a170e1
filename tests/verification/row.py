"""A row of the verification table: a quantity that the program computes beside what it should be."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

Kind = Literal["exact", "independent code", "published", "itself"]
"""Where a reference comes from; `itself`: another discretization of the same program, or a goal for a rate."""

Measure = Literal["relative", "absolute", "at most", "at least"]
"""How the error is taken: (value - reference)/reference, value - reference, or how far the bound is passed."""


@dataclass(frozen=True, slots=True)
class Row:
    """What is compared, with what, and how far apart the two may be."""

    case: str  # the case file, or what stands in for one
    quantity: str  # with its unit in brackets
    reference: float
    kind: Kind
    source: str  # file, paper or formula
    tolerance: float
    value: Callable[[], float]  # solves, or finds solved, what it needs
    error: Measure = "relative"
    known: str = ""  # why a row misses its tolerance: it is shown as missed, but does not fail the table


@dataclass(frozen=True, slots=True)
class Outcome:
    """A row with its result; nan where the value could not be computed."""

    case: str
    quantity: str
    reference: float
    kind: str
    source: str
    value: float
    error: float
    error_is: str
    tolerance: float
    within: bool
    known: str
    failure: str  # what was raised instead of a value
    seconds: float

    @property
    def failed(self) -> bool:
        """Whether the table fails because of this row."""
        return not self.within and (not self.known or math.isnan(self.error))

    @property
    def verdict(self) -> str:
        """What the table says under `pass`."""
        return "NO" if self.failed else "yes" if self.within else "missed, known"


def evaluate(row: Row) -> Outcome:
    """Compute a row; whatever it raises makes it fail, not the whole table."""
    started = time.perf_counter()
    value, error, failure = float("nan"), float("nan"), ""
    try:
        value = float(row.value())
        error = error_of(row, value)
    except Exception as fault:
        failure = f"{type(fault).__name__}: {fault}"
    within = abs(error) <= row.tolerance  # False for nan
    seconds = time.perf_counter() - started
    return Outcome(
        row.case, row.quantity, row.reference, row.kind, row.source, value, error, row.error, row.tolerance, within,
        row.known, failure, seconds,
    )  # fmt: skip


def error_of(row: Row, value: float) -> float:
    """Signed error of a value in the row's measure."""
    difference = value - row.reference
    match row.error:
        case "relative":
            return difference / abs(row.reference)
        case "absolute":
            return difference
        case "at most":
            return max(difference, 0.0)
        case "at least":
            return min(difference, 0.0)
