"""run.log, and the line that tells of a step."""

from __future__ import annotations

import math
import re
import time
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from crackgrow.results.atomic import append_text, write_text
from crackgrow.results.units import INTENSITIES, LENGTHS, TIMES, counted, unit_of

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.arrays import Floats
    from crackgrow.case.model import Case
    from crackgrow.run.result import Event, StepResult, TipResult


MOST_TIPS = 3  # that a line tells of
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


def step_line(result: StepResult, n_steps: int | None) -> str:
    """One line on a solved step: dofs, contact iterations, tips that advanced and by which branch, seconds."""
    moved = [f"{tip.crack} {tip.tip} ({tip.criterion})" for tip in result.tips if tip.advanced]
    return ", ".join(
        [
            step_label(result.step, n_steps),
            f"{result.n_dofs} dofs",
            counted(result.contact_iterations, "contact iteration"),
            f"advanced: {', '.join(moved)}" if moved else "no tip advanced",
            *([] if moved else start_words(result)),
            f"{sum(result.seconds.values()):.2f} s",
        ]
    )


def load_words(case: Case, factor: float) -> str:
    """What loads a step: its load factor, or the stage that ends with it."""
    from crackgrow.case.model import Stages  # only now: it loads numpy

    if isinstance(case.loading, Stages) and factor in range(1, len(case.loading.stages) + 1):
        return f"stage '{case.loading.stages[round(factor) - 1].name}'"
    return f"load factor {factor:.4g}"


def told_line(result: StepResult, case: Case, K_scale: float) -> str:
    """One line on a solved step for who looks on: its load, the tips that advanced or else the largest K, length.

    K has at least the unit in which `K_scale` (Pa sqrt(m)) is read easily.
    """
    n_steps = case.growth.steps if case.growth else None
    moved = [tip for tip in result.tips if tip.advanced]
    known = [tip for tip in result.tips if math.isfinite(tip.K_I + tip.K_II)]
    largest = max(known, key=lambda tip: float(f"{math.hypot(tip.K_I, tip.K_II):.6g}"), default=None)  # not round-off
    shown = moved or ([largest] if largest else [])
    arrested = bool(result.tips) and not moved and n_steps is not None and result.step < n_steps  # else none is to
    return ", ".join(
        [
            step_label(result.step, n_steps),
            load_words(case, result.load_factor),
            *(["no tip advanced"] if arrested else []),
            *([] if moved else start_words(result)),
            *(_tip_words(tip, K_scale) for tip in shown[:MOST_TIPS]),
            *([f"{len(shown) - MOST_TIPS} more"] if len(shown) > MOST_TIPS else []),
            *length_words(result),
            *_time_words(result),
        ]
    )


def largest_K(result: StepResult) -> float:
    """The largest size of a K_I or K_II of a step, Pa sqrt(m); 0 where none is known."""
    values = (abs(K) for tip in result.tips for K in (tip.K_I, tip.K_II))
    return max((value for value in values if math.isfinite(value)), default=0.0)


def _tip_words(tip: TipResult, K_scale: float) -> str:
    """A tip with its K in one unit, to three digits of the larger one."""
    size, unit = unit_of((tip.K_I, tip.K_II, K_scale), INTENSITIES)
    largest = max((abs(K) / size for K in (tip.K_I, tip.K_II) if math.isfinite(K)), default=0.0)
    decimals = max(0, 2 - math.floor(math.log10(largest))) if largest >= 1.0 else 3
    values = (f"{round(K / size, decimals) + 0.0:.{decimals}f}" for K in (tip.K_I, tip.K_II))
    branch = f" ({tip.criterion})" if tip.advanced else ""
    return f"{tip.crack} {tip.tip}{branch} K_I {' K_II '.join(values)} {unit.replace('√m', ' sqrt(m)')}"


def start_words(result: StepResult) -> list[str]:
    """How critical the most critical place is at which a crack may start; empty where there is none."""
    if result.start is None:
        return []
    start = result.start
    return [f"most critical start at {_at(start.point)} ({start.criterion}), criticality {start.criticality:.3g}"]


def length_words(result: StepResult) -> list[str]:
    """How long the cracks are; empty where there are none."""
    if not result.cracks:
        return []
    size, unit = unit_of([result.crack_length], LENGTHS)
    return [f"cracks {result.crack_length / size:.4g} {unit.replace('µ', 'u')} long"]


def _time_words(result: StepResult) -> list[str]:
    """When the cracks have come here; empty where growth takes no time."""
    if not math.isfinite(result.time):
        return []
    size, unit = unit_of([result.time or 1.0], TIMES)
    return [f"at {result.time / size:.4g} {unit.replace('µ', 'u')}"]


def event_line(event: Event) -> str:
    """One line on what a tip has met, or where a crack has started, and where that is (m)."""
    if event.kind == "initiation":
        return f"step {event.step}, initiation: crack '{event.crack}' starts on {event.met} at {_at(event.point)}"
    tip = f"crack '{event.crack}' ({event.tip})"
    return f"step {event.step}, {event.kind}: {tip} reached {event.met} at {_at(event.point)}"


def _at(point: Floats) -> str:
    """A place (2,) m in words, without the round-off of zeros."""
    x, y = (round(float(value), 12) + 0.0 for value in point)
    return f"({x:.6g}, {y:.6g}) m"
