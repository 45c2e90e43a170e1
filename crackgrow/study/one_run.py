"""A run of a study: solved and written as `crackgrow run` does, but it tells nobody."""

from __future__ import annotations

from collections.abc import Iterator

from crackgrow.errors import CrackgrowError
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
        writer.fail(reason_of(error))
        raise


def reason_of(error: BaseException) -> str:
    """Why a run broke off, in a line: what the program raises on purpose speaks for itself."""
    if isinstance(error, CrackgrowError):
        return " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return " ".join(f"out of memory: {error}".split())
    return " ".join(f"internal error: {type(error).__name__}: {error}".split())
