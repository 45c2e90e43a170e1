"""`crackgrow run` and `crackgrow check`."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.cli.case_file import load_case_file
from crackgrow.cli.console import EXIT_DONE, EXIT_UNSOLVED, complain, say
from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import OutputError
from crackgrow.results.log import event_line, step_label, step_line

if TYPE_CHECKING:
    from crackgrow.case.model import Case
    from crackgrow.results.writer import RunWriter
    from crackgrow.run.result import Event, RunEnd, StepResult

BAR_WIDTH = 20
MOST_WARNINGS = 5  # printed at the end; run.log has all


def run(arguments: argparse.Namespace) -> int:
    """`crackgrow run`: load, grow, write; what was solved is kept whatever ends the run."""
    case = load_case_file(arguments)
    folder = arguments.out or Path("outputs") / case.name
    steps = crackgrow.grow(case)  # starts with its first step
    writer = crackgrow.RunWriter(case, folder)
    progress = Progress(case, quiet=arguments.quiet)
    writer.begin()
    try:
        end = _write_steps(steps, writer, progress)
    except OutputError as error:
        with contextlib.suppress(OutputError):  # a small file may still fit
            writer.fail(str(error))
        raise
    except KeyboardInterrupt:
        _fail(writer, "interrupted")
        raise
    except CrackgrowError as error:
        _fail(writer, str(error))
        raise
    except Exception as error:
        _fail(writer, f"internal error: {type(error).__name__}: {error}")
        raise
    finally:
        progress.close()
    if writer.error_line and not arguments.quiet:
        say(writer.error_line)
    if end.status == "failed":
        complain(f"crackgrow: {end.reason}")
        return EXIT_UNSOLVED
    if not arguments.quiet:
        say(f"{end.status}: {end.reason}\nresults in {folder}")
    return EXIT_DONE


def check(arguments: argparse.Namespace) -> int:
    """`crackgrow check`: validate a case and say what it models."""
    say(crackgrow.overview(load_case_file(arguments)))
    return EXIT_DONE


class Progress:
    """How far a run is: one live line on a terminal, otherwise a line a step."""

    def __init__(self, case: Case, *, quiet: bool) -> None:
        self._n_steps = case.growth.steps if case.growth else None
        self._quiet = quiet
        self._live = not quiet and sys.stdout is not None and sys.stdout.isatty()
        self._n_advances = 0
        self._seconds = 0.0
        self._warnings: dict[str, None] = {}
        if not quiet:
            say(f"{case.name}: {case.title}")

    def show(self, result: StepResult) -> None:
        """Tell of a solved step."""
        self._n_advances += sum(tip.advanced for tip in result.tips)
        self._seconds += sum(result.seconds.values())
        self._warnings.update(dict.fromkeys(result.warnings))
        if self._live:
            width = shutil.get_terminal_size().columns - 1
            say(f"\r{self._bar(result)[:width]}\x1b[K", end="")
        elif not self._quiet:
            say(step_line(result, self._n_steps))
        self.tell(result.events)

    def tell(self, events: Sequence[Event]) -> None:
        """Tell of tips that have met something."""
        if events and self._live:
            say("")  # the bar stays above, and a new one follows
        for event in events if not self._quiet else ():
            say(event_line(event))

    def close(self) -> None:
        """Leave the live line and print the warnings of the steps, each once."""
        if self._live:
            say("")
        if not self._quiet:
            texts = list(self._warnings)
            for text in texts[:MOST_WARNINGS]:
                say(f"warning: {text}")
            if len(texts) > MOST_WARNINGS:
                say(f"and {len(texts) - MOST_WARNINGS} more warnings in run.log")

    def _bar(self, result: StepResult) -> str:
        done = result.step / self._n_steps if self._n_steps else 1.0
        filled = round(BAR_WIDTH * min(done, 1.0))
        return (
            f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] {step_label(result.step, self._n_steps)}, "
            f"{self._n_advances} tip advances, {result.contact_iterations} contact iterations, {self._seconds:.1f} s"
        )


def _write_steps(steps: Iterator[StepResult], writer: RunWriter, progress: Progress) -> RunEnd:
    """Write each step as it comes, then the end, and return it."""
    while True:
        try:
            result = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            break
        writer.add(result)
        progress.show(result)
    progress.tell(end.events)
    writer.finish(end)
    return end


def _fail(writer: RunWriter, reason: str) -> None:
    """Keep what was solved; a disk that refuses now doesn't hide the first error."""
    try:
        writer.fail(reason)
    except CrackgrowError as error:
        complain(f"crackgrow: {error}")
