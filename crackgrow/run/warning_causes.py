"""Warnings: what makes results doubtful, and where; `warning_causes.yaml` has the limits, the reasons and the words."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import yaml


@cache
def warning_causes() -> dict[str, dict[str, Any]]:
    """By its name each cause, the most important first: its limit, reason and words."""
    return dict(yaml.safe_load(files("crackgrow.run").joinpath("warning_causes.yaml").read_text(encoding="utf-8")))


def limit_of(cause: str) -> float:
    """The size beyond which a cause is told."""
    return float(warning_causes()[cause].get("limit", 0.0))


@dataclass(frozen=True, slots=True)
class StepWarning:
    """One thing that makes the results of a step doubtful."""

    cause: str  # its name in the table
    words: str  # a sentence of this place alone
    place: str = ""  # "crack 'flaw'", "the end of crack 'flaw'"; empty: the whole scene
    size: float = 0.0  # of warnings of one cause the larger is the worse; may be infinite

    @property
    def rank(self) -> int:
        """The smaller the more important."""
        return 1 + list(warning_causes()).index(self.cause)


def warning(cause: str, place: str = "", size: float = 0.0, **values: object) -> StepWarning:
    """What to say of a place in the words of a cause; of warnings of one cause the larger `size` is the worse."""
    words = warning_causes()[cause]["words"].format(place=place, size=size, limit=limit_of(cause), **values)
    return StepWarning(cause, words, place, float(size))
