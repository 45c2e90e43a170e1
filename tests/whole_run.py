"""A run driven to its end."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.run.loop import for_each, grow
from crackgrow.run.result import Checkpoint, RunEnd, StepResult


def whole_run(case: Case, checkpoint: Checkpoint | None = None) -> tuple[list[StepResult], RunEnd]:
    """The results of all steps, of those from a `checkpoint` on if there is one, and why the run ended."""
    results: list[StepResult] = []
    return results, for_each(grow(case, checkpoint), results.append)


def steps_of(text: str, *settings: str) -> list[StepResult]:
    """The steps of a case that is written out."""
    return whole_run(read_case(text, "scene", "scene", settings))[0]


def seen(results: Iterable[StepResult], column: str) -> Floats:
    """A column of history.csv, on the way of all steps."""
    told = [result.history for result in results]
    return np.concatenate([each.values[:, each.columns.index(column)] for each in told if each is not None])
