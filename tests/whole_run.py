"""A run driven to its end."""

from __future__ import annotations

from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.result import Checkpoint, RunEnd, StepResult


def whole_run(case: Case, checkpoint: Checkpoint | None = None) -> tuple[list[StepResult], RunEnd]:
    """The results of all steps, of those from a `checkpoint` on if there is one, and why the run ended."""
    results, steps = [], grow(case, checkpoint)
    while True:
        try:
            results.append(next(steps))
        except StopIteration as stop:
            return results, stop.value
