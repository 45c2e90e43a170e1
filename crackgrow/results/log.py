"""run.log, and what tells of a run and of its steps: one live line on a terminal, otherwise a line a step."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from crackgrow.case.units import place_text
from crackgrow.results.atomic import GrowingFile
from crackgrow.results.gathered import Gathered
from crackgrow.results.units import INTENSITIES, LENGTHS, TIMES, counted, cut, duration, unit_of

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.case.model import Case
    from crackgrow.run.result import Event, InterfaceTipResult, StepResult, TipResult


MOST_TIPS = 3  # that a line tells of; run.log has all
FIRST_LINE = re.compile(rb" *\d+\.\d\d s  crackgrow \S+, case ")

BAR_WIDTH = 20
ROOM_FOR_BAR = 60  # columns: a narrower terminal has the words alone
MOST_WARNINGS = 8  # causes that are told at the end; run.log has all
RECENT = 5  # steps whose mean time tells what is left: later ones are larger than the first
CLEAR = "\x1b[K"  # the rest of a terminal's line


def is_log(path: Path) -> bool:
    """Whether a file begins as the log of a run does."""
    try:
        with path.open("rb") as file:
            return FIRST_LINE.match(file.read(200)) is not None
    except OSError:
        return False


class RunLog(GrowingFile):
    """Lines with the seconds since the log began; the file is complete after every line."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._began = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Seconds since the log began."""
        return time.perf_counter() - self._began

    def tell(self, text: str) -> None:
        """Append a line; raises OutputError."""
        self.lines.append(f"{self.seconds:10.2f} s  {text}")
        self.write()

    def begin(self, text: str) -> None:
        """Write the first line, with date and time; raises OutputError."""
        self.tell(f"{text}, {datetime.now().astimezone().isoformat(timespec='seconds')}")

    def go_on(self, text: str, seconds: float) -> None:
        """Write a line below those of a run that was broken off `seconds` after it began; raises OutputError."""
        if self.path.is_file():  # written anew: its last line may have been cut off
            self.lines = self.path.read_text(encoding="utf-8", errors="replace").splitlines()
        self._began -= seconds
        self.begin(text)


def step_label(step: int, n_steps: int | None) -> str:
    """Name a step: "step 3/22", or "step 3" where the number of growth steps isn't known."""
    return f"step {step}" if n_steps is None else f"step {step}/{n_steps}"


def load_words(case: Case, factor: float) -> str:
    """What loads a step: its load factor, or the stage that ends with it."""
    from crackgrow.case.model import Stages  # only now: it loads numpy

    if isinstance(case.loading, Stages) and factor in range(1, len(case.loading.stages) + 1):
        return f"stage '{case.loading.stages[round(factor) - 1].name}'"
    return f"load factor {factor:.4g}"


def step_line(result: StepResult, case: Case, K_scale: float = 0.0, *, logged: bool = False) -> str:
    """One line on a solved step: its load, how critical it is, the tips that advanced or else the largest K, length.

    K has at least the unit in which `K_scale` (Pa sqrt(m)) is read easily.

    logged: for run.log, which names all of those tips, says of every step if none has advanced, and what it took
    """
    n_steps = case.growth.steps if case.growth else None
    shown = [tip for tip in result.tips if tip.advanced]
    on_interfaces = [tip for tip in result.interface_tips if tip.advanced]
    words = [step_label(result.step, n_steps), load_words(case, result.load_factor), *criticality_words(result)]
    if not (shown or on_interfaces):
        if logged or (result.tips and n_steps is not None and result.step < n_steps):  # else none is to advance
            words.append("no tip advanced")
        if result.start is not None:
            at, start = place_text(result.start.point), result.start
            words.append(f"most critical start at {at} ({start.criterion}), criticality {start.criticality:.3g}")
        known = [tip for tip in result.tips if math.isfinite(tip.K_I + tip.K_II)]
        sizes = [0.0 if tip.sticks else float(f"{math.hypot(tip.K_I, tip.K_II):.6g}") for tip in known]  # not round-off
        shown = [known[sizes.index(max(sizes))]] if known else []
    told = [_tip_words(tip, K_scale) for tip in shown]
    told += [f"{tip.crack} {tip.tip} G {tip.G:.3g} J/m^2" for tip in on_interfaces]
    words += [*cut(told, len(told) if logged else MOST_TIPS, "{} more"), *length_words(result)]
    if math.isfinite(result.time):  # growth takes time
        size, unit = unit_of([result.time or 1.0], TIMES)
        words.append(f"at {result.time / size:.4g} {_ascii(unit)}")
    if math.isfinite(result.cycles):
        words.append(f"after {result.cycles:.6g} cycles")
    if logged:
        words += [f"{result.n_dofs} dofs", counted(result.contact_iterations, "contact iteration")]
        words.append(f"{sum(result.seconds.values()):.2f} s")
    return ", ".join(words)


def largest_K(result: StepResult) -> float:
    """The largest size of a K_I or K_II of a step, Pa sqrt(m); 0 where none is known."""
    sizes = [abs(K) for tip in result.tips if not tip.sticks for K in (tip.K_I, tip.K_II)]
    return max(filter(math.isfinite, sizes), default=0.0)


def _tip_words(tip: TipResult, K_scale: float) -> str:
    """A tip with its K in one unit, to three digits of the larger one, or that it sticks."""
    branch = f" ({tip.criterion})" if tip.advanced else ""
    if tip.sticks:
        return f"{tip.crack} {tip.tip}{branch} sticks"
    size, unit = unit_of((tip.K_I, tip.K_II, K_scale), INTENSITIES)
    largest = max((abs(K) / size for K in (tip.K_I, tip.K_II) if math.isfinite(K)), default=0.0)
    decimals = max(0, 2 - math.floor(math.log10(largest))) if largest >= 1.0 else 3
    values = (f"{round(K / size, decimals) + 0.0:.{decimals}f}" for K in (tip.K_I, tip.K_II))
    return f"{tip.crack} {tip.tip}{branch} K_I {' K_II '.join(values)} {_ascii(unit)}"


def criticality_words(result: StepResult) -> list[str]:
    """How critical the most critical tip is, of those that advance if any do, and the K at which it grows, if known.

    With a law of rate that is the K at which it is unstable.
    """
    tips: Sequence[TipResult | InterfaceTipResult] = (*result.tips, *result.interface_tips)
    moved = [tip for tip in tips if tip.advanced]
    known = [tip for tip in moved or tips if math.isfinite(tip.criticality)]
    if not known:
        return []
    most = max(known, key=lambda tip: tip.criticality)
    words = [f"criticality {most.criticality:.3g}"]
    for tip in result.tips:
        if tip is most and math.isfinite(tip.K_growth):
            size, unit = unit_of([tip.K_growth], INTENSITIES)
            at_rate = math.isfinite(tip.velocity) or math.isfinite(tip.growth_per_cycle)
            words.append(f"{'unstable' if at_rate else 'grows'} at K {tip.K_growth / size:.3g} {_ascii(unit)}")
    return words


def length_words(result: StepResult) -> list[str]:
    """How long the cracks are; empty where there are none."""
    if not result.cracks:
        return []
    size, unit = unit_of([result.crack_length], LENGTHS)
    return [f"cracks {result.crack_length / size:.4g} {_ascii(unit)} long"]


def _ascii(unit: str) -> str:
    """The name of a unit in letters that every terminal has."""
    return unit.replace("√m", " sqrt(m)").replace("µ", "u")


def event_line(event: Event) -> str:
    """One line on what a tip has met, or where a crack has started, and where that is."""
    return f"step {event.step}, {event.kind}: {event.words}"


class Progress:
    """Tells of the steps through `say`, a function of a text and of its end; a live line is `width` characters long."""

    def __init__(
        self, case: Case, say: Callable[[str, str], None], *, width: int | None, first: int = 0, expected: str = ""
    ) -> None:
        """`width` is None where there is no terminal; `first` is the step with which the run begins.

        `expected` says what the run is about to take.
        """
        self._case, self._say, self._width = case, say, width
        self._times = [time.perf_counter()]  # at the end of every step
        self._warnings = Gathered()
        self._K_scale = 0.0  # Pa sqrt(m), largest K so far: lines of a run can be compared if K keeps its unit
        for text in (f"{case.name}: {case.title}", expected, f"goes on with step {first}" if first else ""):
            if text:
                say(text, "\n")
        self._show_live(first - 1, "")

    def show(self, result: StepResult) -> None:
        """Tell of a solved step."""
        self._times.append(time.perf_counter())
        self._warnings.add(result.step, result.step_warnings)
        self._K_scale = max(self._K_scale, largest_K(result))
        if self._width is None:
            self._say(step_line(result, self._case, self._K_scale), "\n")
        words = [load_words(self._case, result.load_factor), *criticality_words(result)[:1], *length_words(result)]
        self._show_live(result.step, f", {', '.join(words)}")
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
        texts = [f"warning: {text}" for text in self._warnings.sentences()]
        for text in cut(texts, MOST_WARNINGS, "and {} more warnings in run.log"):
            self._say(text, "\n")

    def _show_live(self, step: int, what: str) -> None:
        """Replace the live line by one that says that a step, -1 for none, is done, and about how long others take."""
        if self._width is None:
            return
        last = self._case.last_step
        filled = round(BAR_WIDTH * max(step, 0) / last) if last else BAR_WIDTH * (step + 1)
        bar = f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] " if self._width >= ROOM_FOR_BAR else ""
        recent, left = self._times[-RECENT - 1 :], ""
        if len(recent) > 1 and step < last:
            left = f", {duration((last - step) * (recent[-1] - recent[0]) / (len(recent) - 1))} left"
        text = f"{bar}{step_label(max(step, 0), last)}{left}{what}, {self._times[-1] - self._times[0]:.1f} s"
        self._say(f"\r{text[: self._width]}{CLEAR}", "")
