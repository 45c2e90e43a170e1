"""What is held against a run: how often each kind of check was made, and every departure, told by the run or not."""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass, field

from tests.stability.judge.written import WrittenRun

_K = r"\bK\b|K_I"
TELLS = {
    "overlap": r"overlap|stand apart",
    "open under pressure": r"overlap|stand apart|unsure|oscillate|ripple",
    "slip against friction": r"several solutions|leads elsewhere",
    "K_I of a closed straight tip": _K,
    "K of a stuck crack": _K,
    "K_I below zero": rf"{_K}|overlap",
    "energy balance": r"energ|balance",
    "dissipation falls": r"energ|dissipat",
    "released energy below zero": r"energ|releas",
    "reactions": r"balance|residual|ill conditioned|support",
    "moment": r"balance|residual|ill conditioned|support",
    "overlap without contact": r"contact: none",
    "critical load that is not": r"jumps",
}
"""Words of a warning that names such a departure; kinds without any have no excuse."""

PLACE = re.compile(r"crack '|faces of '|^'")
"""What names a place."""

OTHERS = re.compile(r"\d+ (more|others?)")
"""A warning that names one place and counts the others tells of them too."""


@dataclass(frozen=True, slots=True)
class Departure:
    """Something that is not as it should be."""

    kind: str
    size: float  # relative, or degrees: see the check
    step: int
    place: str  # the crack or surface; empty: the scene
    told: bool


@dataclass(slots=True)
class Court:
    """Gathers what the checks of one run find."""

    run: WrittenRun
    judged: Counter[str] = field(default_factory=Counter)
    departures: list[Departure] = field(default_factory=list)

    def check(self, kind: str, size: float, limit: float, step: int, place: str = "", stated: bool = False) -> None:
        """Hold one size against its limit; nan is beyond any. `stated`: the tables give an error as large."""
        self.judged[kind] += 1
        if not size <= limit:
            size = float(size) if math.isfinite(size) else math.inf
            told = stated or self._told(kind, step, place)
            self.departures.append(Departure(kind, size, int(step), place, told))

    def _told(self, kind: str, step: int, place: str) -> bool:
        words = TELLS.get(kind)
        if words is None:
            return False
        said = [where for text, where in self.run.warnings(step) if re.search(words, text)]
        named = [where for where in said if f"'{place}'" in where or not PLACE.search(where) or OTHERS.search(where)]
        return bool(named if place else said)
