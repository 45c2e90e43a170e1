"""How far a run is: one live line on a terminal, otherwise a line a step."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from crackgrow.results.gathered import Gathered
from crackgrow.results.log import event_line, largest_K, length_words, load_words, step_label, told_line
from crackgrow.results.units import counted, duration

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.case.model import Case
    from crackgrow.run.result import Event, StepResult

BAR_WIDTH = 20
ROOM_FOR_BAR = 60  # columns: a narrower terminal has the words alone
MOST_WARNINGS = 8  # causes that are told at the end; run.log has all
RECENT = 5  # steps whose mean time tells what is left: later ones are larger than the first
CLEAR = "\x1b[K"  # the rest of a terminal's line


class Progress:
    """Tells of the steps through `say`, a function of a text and of its end; a live line is `width` characters long."""

    def __init__(
        self, case: Case, say: Callable[[str, str], None], *, width: int | None, first: int = 0, expected: str = ""
    ) -> None:
        """`width` is None where there is no terminal; `first` is the step with which the run begins.

        `expected` says what the run is about to take.
        """
        self._case = case
        self._last_step = case.last_step
        self._n_steps = case.growth.steps if case.growth else None
        self._say, self._width = say, width
        self._n_advances = 0
        self._times = [time.perf_counter()]  # at the end of every step
        self._warnings = Gathered()
        self._K_scale = 0.0  # Pa sqrt(m), largest K so far: lines of a run can be compared if K keeps its unit
        say(f"{case.name}: {case.title}", "\n")
        if expected:
            say(expected, "\n")
        if first:
            say(f"goes on with step {first}", "\n")
        self._show_live(first - 1, "")

    def show(self, result: StepResult) -> None:
        """Tell of a solved step."""
        self._n_advances += sum(tip.advanced for tip in result.tips)
        self._times.append(time.perf_counter())
        self._warnings.add(result.step, result.cautions)
        self._K_scale = max(self._K_scale, largest_K(result))
        if self._width is None:
            self._say(told_line(result, self._case, self._K_scale), "\n")
        advances = f", {counted(self._n_advances, 'tip advance')}" if self._n_steps is not None else ""
        what = [load_words(self._case, result.load_factor), *length_words(result)]
        self._show_live(result.step, f", {', '.join(what)}{advances}")
        self.tell(result.events)

    def tell(self, events: Sequence[Event]) -> None:
        """Tell of tips that have met something."""
        if events and self._width is not None:
            self._say("", "\n")  # the bar stays above, and a new one follows
        for event in events:
            self._say(event_line(event), "\n")

    def close(self) -> None:
        """Leave the live line and tell the warnings of the steps, each cause once."""
        if self._width is not None:
            self._say("", "\n")
        texts = self._warnings.sentences()
        for text in texts[:MOST_WARNINGS]:
            self._say(f"warning: {text}", "\n")
        if len(texts) > MOST_WARNINGS:
            self._say(f"and {len(texts) - MOST_WARNINGS} more warnings in run.log", "\n")

    def _show_live(self, step: int, what: str) -> None:
        """Replace the live line by one that says that a step, -1 for none, is done."""
        if self._width is None:
            return
        filled = round(BAR_WIDTH * max(step, 0) / self._last_step) if self._last_step else BAR_WIDTH * (step + 1)
        label = step_label(max(step, 0), self._last_step)
        passed = f"{self._times[-1] - self._times[0]:.1f} s"
        bar = f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] " if self._width >= ROOM_FOR_BAR else ""
        text = f"{bar}{label}{self._left(step)}{what}, {passed}"
        self._say(f"\r{text[: self._width]}{CLEAR}", "")

    def _left(self, step: int) -> str:
        """About how long the steps after one take, if nothing ends the run before."""
        recent = self._times[-RECENT - 1 :]
        n_left = self._last_step - step
        if len(recent) < 2 or n_left == 0:
            return ""
        return f", {duration(n_left * (recent[-1] - recent[0]) / (len(recent) - 1))} left"
