"""What is kept of the steps, and summary.json, which says how a run ended and how good it is at its worst."""

from __future__ import annotations

import functools
import math
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from crackgrow import __version__
from crackgrow.case.model import Case, Stages, StrengthReduction
from crackgrow.results.gathered import Gathered
from crackgrow.results.units import or_null
from crackgrow.run.result import Event, RunEnd, StepResult, TipResult, event_of, event_record

NOTHING = 1e-3
"""Of what the stress could make of a crack with the radius of a K as its half length: a smaller K is none.

Joints that stick under a stress of 12 MPa in the ground have 4e-6 of it, with bounds of 7e-4.
"""

MEMORY_FILE: Final = Path("/proc/self/status")  # of Linux
CHECKS: Final = ("residual", "penetration", "complementarity", "overlap", "energy_error")


def _known(value: float) -> float:
    return -math.inf if math.isnan(value) else value


def K_error(result: StepResult) -> float:
    """Largest bound of the error of K, in percent of the largest K of the step; nan where that is nothing."""
    return _part_of_largest(result, result.tips, [max(tip.K_I_error, tip.K_II_error) for tip in result.tips])


def K_spread(result: StepResult) -> float:
    """Largest spread of K over the radii of its integral, in percent of the largest K of the step.

    Of tips with room for their discs, whatever kept the others from it; nan where there are none, and where all K are
    nothing beside what the stress could make, as at a crack that sticks.
    """
    roomy = [tip for tip in result.tips if not tip.K_note]
    return _part_of_largest(result, roomy, [max(tip.K_I_spread, tip.K_II_spread) for tip in roomy])


def _part_of_largest(result: StepResult, tips: Sequence[TipResult], values: Sequence[float]) -> float:
    """The largest of some `values` (Pa sqrt(m)) of tips, in percent of the largest K of those whose K is known.

    The size of K is that of K_I and K_II together, as for a target. That of tips that stick is zero, and none is told.
    """
    moved = [(tip, value) for tip, value in zip(tips, values, strict=True) if not tip.sticks]
    known = [(tip, value) for tip, value in moved if math.isfinite(tip.K_I + tip.K_II + value)]
    largest = max((math.hypot(tip.K_I, tip.K_II) for tip, _ in known), default=0.0)
    could = NOTHING * result.stress * math.sqrt(math.pi)
    if largest == 0.0 or any(largest < could * math.sqrt(tip.K_radius) for tip, _ in known):
        return math.nan
    return 100.0 * max(value for _, value in known) / largest


ESTIMATES: Final[Mapping[str, Callable[[StepResult], float]]] = {
    "K_percent_at_most": K_error,
    "K_percent_expected": lambda of: _part_of_largest(of, of.tips, [tip.K_error_expected for tip in of.tips]),
    "K_spread_percent": K_spread,
    "kink_degrees_at_most": lambda of: max(
        (tip.kink_error_deg for tip in of.tips if tip.advanced), key=_known, default=math.nan
    ),
    "load_factor_percent_at_most": lambda of: of.load_factor_error,
    "goal_percent_at_most": lambda of: of.goal_error,
}
"""What a step estimates of its own error, by name in the summary; nan where it is unknown."""


@dataclass(slots=True)
class Tally:
    """What the summary and a resumption need of the steps, gathered step by step so that no step has to be kept."""

    steps: list[int] = field(default_factory=list)
    n_dofs: list[int] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)
    worst: dict[str, tuple[float, int]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)  # on how the run was gone on with
    cautions: Gathered = field(default_factory=Gathered)
    events: list[Event] = field(default_factory=list)
    norm_error: float = math.nan  # percent, of the first step
    estimates: dict[str, float] = field(default_factory=lambda: dict.fromkeys(ESTIMATES, math.nan))  # the worst
    time: float = math.nan  # s, of the last step
    cycles: float = math.nan  # the same
    peak: float = math.nan  # the largest load factor
    peak_step: int = 0
    frames: list[int] = field(default_factory=list)  # steps that have one
    cracks: list[int] = field(default_factory=list)  # steps whose crack faces are written
    resumed: list[int] = field(default_factory=list)  # steps with which the run was gone on

    @property
    def warnings(self) -> list[str]:
        """Remarks, then one sentence for each cause, the most important first."""
        return [*self.remarks, *self.cautions.sentences()]

    def add(self, result: StepResult) -> list[str]:
        """Count a step in; returns its warnings that are news. A check that is nan counts as worst of all."""
        step = int(result.step)
        self.steps.append(step)
        self.n_dofs.append(int(result.n_dofs))
        if len(self.steps) == 1:
            self.norm_error = float(result.norm_error)
        for name, estimate in ESTIMATES.items():
            self.estimates[name] = max((self.estimates[name], float(estimate(result))), key=_known)
        self.time, self.cycles = float(result.time), float(result.cycles)
        if not result.load_factor <= self.peak:
            self.peak, self.peak_step = float(result.load_factor), step
        for phase, seconds in result.seconds.items():
            self.add_seconds(phase, seconds)
        for check in CHECKS:
            value = float(result.energy.error if check == "energy_error" else getattr(result, check))
            worst, _ = self.worst.get(check, (0.0, 0))
            if check not in self.worst or (not math.isnan(worst) and not abs(value) <= abs(worst)):
                self.worst[check] = (value, step)
        self.events.extend(result.events)
        return self.cautions.add(step, result.step_warnings)

    def add_seconds(self, phase: str, seconds: float) -> None:
        """Add wall time to a phase."""
        self.seconds[phase] = self.seconds.get(phase, 0.0) + float(seconds)

    def record(self) -> dict[str, object]:
        """All of it as a mapping that JSON can hold."""
        found = {each.name: getattr(self, each.name) for each in fields(self)}
        return found | {"cautions": self.cautions.records(), "events": [event_record(event) for event in self.events]}

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> Tally:
        """The tally of a `record`."""
        worst = {check: (value, step) for check, (value, step) in record["worst"].items()}
        events = [event_of(event) for event in record["events"]]
        return cls(**{**record, "worst": worst, "events": events, "cautions": Gathered.of(record["cautions"])})


def summarize(
    case: Case, tally: Tally, end: RunEnd, wall_seconds: float, memory: float, cpu_seconds: float = math.nan
) -> dict[str, object]:
    """The summary as a mapping that JSON can hold: SI units, seconds, MB; null for what has no value.

    `memory` is the most that the run has taken.
    """
    commit, modified = _program_state()
    by_phase: dict[str, object] = {phase: round(seconds, 3) for phase, seconds in tally.seconds.items()}
    peak: dict[str, object] | None = None
    if tally.steps and not isinstance(case.loading, Stages | StrengthReduction):
        peak = {"load_factor": or_null(tally.peak), "step": tally.peak_step}
    safety: dict[str, object] = {}
    if end.safety is not None:
        factors = {"factor": end.safety.factor, "percent_at_most": end.safety.error, "fails_at": end.safety.fails_at}
        safety = {name: or_null(value) for name, value in factors.items()} | {"mechanism": end.safety.mechanism or None}
    return {
        "case": case.name,
        "title": case.title,
        "status": end.status,
        "stop_reason": end.reason,
        "steps_done": tally.steps[-1] if tally.steps else 0,
        "n_solves": len(tally.steps),
        "version": __version__,
        "git_commit": commit,
        "git_modified": modified,
        "n_dofs": {"first": tally.n_dofs[0], "last": tally.n_dofs[-1]} if tally.n_dofs else None,
        "wall_seconds": {"total": round(wall_seconds, 3), "by_phase": by_phase},
        "cpu_seconds": or_null(round(cpu_seconds, 3)),
        "peak_memory_mb": round(memory, 1),
        "resumed_with_steps": list(tally.resumed),
        **({"safety": safety} if safety else {}),
        **{name: own for name, own in (("time", tally.time), ("cycles", tally.cycles)) if not math.isnan(own)},
        "worst_checks": {
            check: {"value": or_null(value), "step": step} for check, (value, step) in tally.worst.items()
        },
        "error_estimate": {
            "energy_norm_percent": {"first": or_null(tally.norm_error), "last": or_null(end.norm_error)},
            **{name: or_null(value) for name, value in tally.estimates.items()},
        },
        "peak_load": peak,
        "events": [{**event_record(event), "words": event.words} for event in (*tally.events, *end.events)],
        "warnings": tally.warnings,
        "cautions": [{**record, "size": or_null(record["size"])} for record in tally.cautions.records()],
    }


def error_line(tally: Tally, end: RunEnd) -> str:
    """The estimated error of the last step and the bound of that of K over all steps, in words; empty if unknown."""
    known = {name: f"{value:.2g}" for name, value in tally.estimates.items() if math.isfinite(value)}
    expected = f"an expected {known['K_percent_expected']} %, " if "K_percent_expected" in known else ""
    words = {
        "K_percent_at_most": f"K by {expected}at most {{}} % of the largest",
        "kink_degrees_at_most": "directions of growth by {} degrees",
        "load_factor_percent_at_most": "critical load factors by {} %",
        "goal_percent_at_most": "numerics.goal by at most {} % of its largest value",
    }
    parts = [f"{end.norm_error:.2g} % of the energy norm"] if math.isfinite(end.norm_error) else []
    parts += [text.format(known[name]) for name, text in words.items() if name in known]
    return f"estimated error: {', '.join(parts)}" if parts else ""


def peak_memory_mb() -> float:
    """Largest resident memory of this program so far, MB, without that of the process that started it.

    Linux counts the starter's into getrusage; /proc tells the program's own.
    """
    if MEMORY_FILE.is_file():
        lines = MEMORY_FILE.read_text(encoding="utf-8").splitlines()
        return next(float(line.split()[1]) / 1e3 for line in lines if line.startswith("VmHWM:"))
    import resource  # here: of POSIX alone

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # kB, but bytes on macOS
    return peak / 1e6 if sys.platform == "darwin" else peak / 1e3


def program_commit() -> str | None:
    """Commit of the program, with a mark where it was changed since; None where it is not of a checkout."""
    commit, modified = _program_state()
    return f"{commit}, modified" if modified else commit


@functools.cache
def _program_state() -> tuple[str | None, bool | None]:
    return git_state(Path(__file__).resolve().parents[2])


def git_state(root: Path) -> tuple[str | None, bool | None]:
    """Commit of the checkout that the program runs from and whether it was changed since; nulls where there is none.

    `root` must be the checkout's top itself: a program installed inside somebody else's repository isn't of its commit.
    """
    if not (root / ".git").exists():
        return None, None
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=20).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None, None
    return answer.removesuffix("-dirty"), answer.endswith("-dirty")
