"""A run of a study: solved and written as `crackgrow run` does, but it tells nobody."""

from __future__ import annotations

from collections.abc import Iterator

from crackgrow.results.writer import RunWriter
from crackgrow.run.result import RunEnd, StepResult


def write_run(writer: RunWriter, steps: Iterator[StepResult]) -> RunEnd:
    """Write each step as it comes, then the end, and return it; `writer` has begun.

    Whatever a step raises goes into the summary, keeps what was solved, and passes through.
    """
    try:
        while True:
            try:
                result = next(steps)
            except StopIteration as stop:
                end: RunEnd = stop.value
                writer.finish(end)
                return end
            writer.add(result)
    except Exception as error:
        writer.break_off(error)
        raise
