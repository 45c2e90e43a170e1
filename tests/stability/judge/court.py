"""What is held against a run: every departure, told by the run or not."""

from __future__ import annotations

import math
import re
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
    departures: list[Departure] = field(default_factory=list)

    def check(self, kind: str, size: float, limit: float, step: int, place: str = "", stated: bool = False) -> None:
        """Hold one size against its limit; nan is beyond any. `stated`: the tables give an error as large."""
        if not size <= limit:
            size = float(size) if math.isfinite(size) else math.inf
            told = stated or self._told(kind, step, place)
            self.departures.append(Departure(kind, size, int(step), place, told))

    def _told(self, kind: str, step: int, place: str) -> bool:
        """Whether the run warns of such a departure, there or in the whole scene."""
        words = TELLS.get(kind)
        said = [where for text, where in self.run.warnings(step) if words and re.search(words, text)]
        return any(not where or not place or f"'{place}'" in where for where in said)
