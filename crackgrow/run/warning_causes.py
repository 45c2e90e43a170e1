"""Warnings: what makes results doubtful, and where; `warning_causes.yaml` has the limits, the reasons and the words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from functools import cache
from importlib.resources import files
from typing import Any

import yaml


class WarningCause(Enum):
    """What makes results doubtful, the most important first."""

    CONTACT_NONE = auto()
    UNBALANCED = auto()
    FREE_EDGES = auto()
    DRY = auto()
    SUCTION = auto()
    POINT_FORCE = auto()
    CONTRADICTION = auto()
    RESIDUAL = auto()
    IMBALANCE = auto()
    ENERGY = auto()
    CREATED = auto()
    OVERLOAD = auto()
    NOT_SMALL = auto()
    SAWING = auto()
    OVERLAP = auto()
    JUMP = auto()
    RIPPLE = auto()
    LOCKING = auto()
    WIDE_SHEAR = auto()
    SHORT_START = auto()
    MEMORY = auto()
    NO_TIPS = auto()
    BONDED_TIPS = auto()
    UNKNOWN_G = auto()
    MOVED = auto()
    CUT = auto()
    TINY_CRACKS = auto()
    LEFT_OUT = auto()
    TARGET = auto()
    UNMEASURED = auto()
    UNSTABLE = auto()
    NOTE = auto()

    @property
    def limit(self) -> float:
        """The size beyond which it is told."""
        return float(_table()[self.name].get("limit", 0.0))

    def at(self, place: str = "", size: float = 0.0, **values: object) -> StepWarning:
        """What to say of a place; of warnings of one cause the larger `size` is the worse."""
        words = _table()[self.name]["words"].format(place=place, size=size, limit=self.limit, **values)
        return StepWarning(self, words, place, float(size))


@cache
def _table() -> dict[str, dict[str, Any]]:
    """Cause by cause its limit, reason and words."""
    text = files("crackgrow.run").joinpath("warning_causes.yaml").read_text(encoding="utf-8")
    return dict(yaml.safe_load(text))


@dataclass(frozen=True, slots=True)
class StepWarning:
    """One thing that makes the results of a step doubtful."""

    cause: WarningCause
    words: str  # a sentence of this place alone
    place: str = ""  # "crack 'flaw'", "the end of crack 'flaw'"; empty: the whole scene
    size: float = 0.0  # of warnings of one cause the larger is the worse; may be infinite

    @property
    def rank(self) -> int:
        """The smaller the more important."""
        return int(self.cause.value)
