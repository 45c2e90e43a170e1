"""run.log, and the line that tells of a step."""

from __future__ import annotations

import re
import time
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from crackgrow.results.atomic import append_text, write_text

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.run.result import Event, StepResult


FIRST_LINE = re.compile(rb" *\d+\.\d\d s  crackgrow \S+, case ")


def is_log(path: Path) -> bool:
    """Whether a file begins as the log of a run does."""
    try:
        with path.open("rb") as file:
            return FIRST_LINE.match(file.read(200)) is not None
    except OSError:
        return False


class RunLog:
    """Lines with the seconds since the log began; the file is complete after every line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._began = time.perf_counter()
        self._lines: list[str] = []

    def begin(self, text: str) -> None:
        """Write the first line, with date and time; raises OutputError."""
        self.write(f"{text}, {datetime.now().astimezone().isoformat(timespec='seconds')}")

    def go_on(self, text: str, seconds: float) -> None:
        """Write a line below those of a run that was broken off `seconds` after it began; raises OutputError."""
        if self.path.is_file():
            lines = self.path.read_text(encoding="utf-8", errors="replace").splitlines()
            self._lines = [f"{line}\n" for line in lines]  # the last one may have been cut off
            write_text(self.path, "".join(self._lines))
        self._began -= seconds
        self.begin(text)

    def write(self, text: str) -> None:
        """Append a line; raises OutputError."""
        line = f"{self.seconds:10.2f} s  {text}\n"
        self._lines.append(line)
        if len(self._lines) == 1 or not append_text(self.path, line):
            write_text(self.path, "".join(self._lines))

    @property
    def seconds(self) -> float:
        """Seconds since the log began."""
        return time.perf_counter() - self._began


def step_label(step: int, n_steps: int | None) -> str:
    """Name a step: "step 3/22", or "step 3" where the number of growth steps isn't known."""
    return f"step {step}" if n_steps is None else f"step {step}/{n_steps}"


def counted(n: object, thing: str) -> str:
    """A number of things in words: "1 run", "2 runs"."""
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"


def step_line(result: StepResult, n_steps: int | None) -> str:
    """One line on a solved step: dofs, contact iterations, tips that advanced and by which branch, seconds."""
    moved = [f"{tip.crack} {tip.tip} ({tip.criterion})" for tip in result.tips if tip.advanced]
    return ", ".join(
        [
            step_label(result.step, n_steps),
            f"{result.n_dofs} dofs",
            counted(result.contact_iterations, "contact iteration"),
            f"advanced: {', '.join(moved)}" if moved else "no tip advanced",
            f"{sum(result.seconds.values()):.2f} s",
        ]
    )


def event_line(event: Event) -> str:
    """One line on what a tip has met, and where (m)."""
    x, y = event.point
    tip = f"crack '{event.crack}' ({event.tip})"
    return f"step {event.step}, {event.kind}: {tip} reached {event.met} at ({x:.6g}, {y:.6g}) m"
