"""summary.json: how the run ended, what it cost, how good it is at its worst."""

from __future__ import annotations

import functools
import json
import math
import resource
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from crackgrow import __version__
from crackgrow.case.model import Case
from crackgrow.run.result import Event, RunEnd, StepResult, event_of, event_record

CHECKS = ("residual", "penetration", "complementarity", "overlap", "energy_error")


class Tally:
    """What the summary needs of the steps, gathered one step at a time so that no step has to be kept."""

    def __init__(self) -> None:
        self.steps: list[int] = []
        self.n_dofs: list[int] = []
        self.seconds: dict[str, float] = {}
        self.worst: dict[str, tuple[float, int]] = {}
        self.warnings: list[str] = []
        self.events: list[Event] = []
        self.effective_toughness = math.nan

    def add(self, result: StepResult) -> None:
        """Count a step in; a check that is nan counts as worst of all."""
        self.steps.append(int(result.step))
        self.n_dofs.append(int(result.n_dofs))
        self.effective_toughness = float(result.effective_toughness)
        for phase, seconds in result.seconds.items():
            self.add_seconds(phase, seconds)
        for check in CHECKS:
            value = float(result.energy.error if check == "energy_error" else getattr(result, check))
            if check not in self.worst or _badness(value) > _badness(self.worst[check][0]):
                self.worst[check] = (value, int(result.step))
        self.events.extend(result.events)
        self.warnings.extend(f"step {result.step}: {text}" for text in result.warnings)

    def record(self) -> dict[str, object]:
        """All of it as a mapping that JSON can hold."""
        return {
            "steps": self.steps,
            "n_dofs": self.n_dofs,
            "seconds": self.seconds,
            "worst": self.worst,
            "warnings": self.warnings,
            "events": [event_record(event) for event in self.events],
            "effective_toughness": self.effective_toughness,
        }

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> Tally:
        """The tally of a `record`."""
        tally = cls()
        tally.steps, tally.n_dofs = list(record["steps"]), list(record["n_dofs"])
        tally.seconds, tally.warnings = dict(record["seconds"]), list(record["warnings"])
        tally.worst = {check: (value, step) for check, (value, step) in record["worst"].items()}
        tally.events = [event_of(event) for event in record["events"]]
        tally.effective_toughness = record["effective_toughness"]
        return tally

    def add_seconds(self, phase: str, seconds: float) -> None:
        """Add wall time to a phase."""
        self.seconds[phase] = self.seconds.get(phase, 0.0) + float(seconds)


def summarize(
    case: Case, tally: Tally, end: RunEnd, wall_seconds: float, memory: float, resumed: Sequence[int] = ()
) -> dict[str, object]:
    """The summary as a mapping that JSON can hold: SI units, seconds, MB; null for what has no value.

    `memory` is the most that the run has taken, `resumed` are the steps with which it was gone on.
    """
    commit, modified = _program_state()
    by_phase: dict[str, object] = {phase: round(seconds, 3) for phase, seconds in tally.seconds.items()}
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
        "peak_memory_mb": round(memory, 1),
        "resumed_with_steps": list(resumed),
        "effective_toughness_K_I": tally.effective_toughness if math.isfinite(tally.effective_toughness) else None,
        "worst_checks": {
            check: {"value": value if math.isfinite(value) else None, "step": step}
            for check, (value, step) in tally.worst.items()
        },
        "events": [event_record(event) for event in (*tally.events, *end.events)],
        "warnings": tally.warnings,
    }


def summary_text(summary: dict[str, object]) -> str:
    """The summary as JSON text."""
    return json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def peak_memory_mb() -> float:
    """Largest resident memory of this process so far, MB."""
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


def _badness(value: float) -> float:
    return math.inf if math.isnan(value) else abs(value)
