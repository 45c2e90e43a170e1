"""A scene at a value of an axis: what is solved, what it is held against, and what came of it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from crackgrow.errors import CrackgrowError
from tests.stability.condition import condition_estimate
from tests.stability.solved import Solved

Status = Literal["solved", "warned", "refused", "crashed"]
Verdict = Literal["yes", "said", "NO"]


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A row of the table before it is computed."""

    axis: str
    value: str
    compared: str  # what is held against what
    tolerance: float  # relative
    solve: Callable[[], Solved]
    deviation: Callable[[Solved], float]
    plain: Callable[[], Solved]  # the scene at its usual value: its warnings are no news
    refusable: bool = False  # whether the program may refuse it: it lies beyond what is promised


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table. `nan` where there is no number."""

    axis: str
    value: str
    compared: str
    deviation: float
    tolerance: float
    condition: float  # estimate, of the scaled stiffness
    iterations: int  # of the contact solver; -1 where nothing was solved
    residual: float  # relative equilibrium residual
    status: Status  # warned: the program told the user more than at the usual value
    refusable: bool
    reason: str  # why it was refused, what it warned of
    seconds: float

    @property
    def verdict(self) -> Verdict:
        """`said`: the result is no good or there is none, and the program says so. `NO`: it does not."""
        if self.deviation <= self.tolerance and self.status != "crashed":
            return "yes"
        told = self.status == "warned" or (self.status == "refused" and self.refusable)
        return "said" if told else "NO"


def evaluate(trial: Trial) -> Row:
    """Compute a row; whatever is raised on the way ends this row alone."""
    started = time.perf_counter()
    deviation, condition, iterations, residual = math.nan, math.nan, -1, math.nan
    status: Status
    try:
        solved = trial.solve()
        iterations, residual = solved.result.contact_iterations, solved.result.residual
        condition = condition_estimate(solved.solution.contact.system)
        usual = trial.plain().result.warnings
        news = [warning for warning in solved.result.warnings if warning not in usual]
        deviation = trial.deviation(solved)
        status, reason = ("warned" if news else "solved"), "; ".join(news)
    except CrackgrowError as error:
        status, reason = "refused", str(error)
    except Exception as error:
        status, reason = "crashed", f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - started
    return Row(
        trial.axis, trial.value, trial.compared, deviation, trial.tolerance, condition, iterations, residual, status,
        trial.refusable, " ".join(reason.split()), seconds,
    )  # fmt: skip


def line_of(row: Row) -> str:
    """A row on a line of the terminal."""
    return (
        f"{row.verdict:4}  {row.axis:20} {row.value:28} {row.status:8} deviation {number(row.deviation):8} "
        f"of {number(row.tolerance):8} condition {number(row.condition):8} {row.seconds:5.1f} s"
    ).rstrip()


def number(value: float) -> str:
    """Two digits; empty where there is no number."""
    return f"{value:.2g}" if math.isfinite(value) else ""
