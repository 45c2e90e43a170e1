"""A case file that a study runs, and the settings that it runs it with."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.case import Case, load_case
from crackgrow.case.declared import keys_of
from crackgrow.case.model import ContactNumerics, Numerics

UNWRITTEN: Final = ("output.frames=none", "output.figures=false", "output.report=false")
HALVED: Final = "numerics.refine={tips: auto, kinks: auto, corners: auto}"


@dataclass(frozen=True, slots=True)
class CaseFile:
    """A case file with the settings that replace its own."""

    path: Path
    overrides: tuple[str, ...] = ()

    def load(self, *more: str) -> Case:
        """The case with more settings replaced; raises CaseError."""
        return load_case(self.path, (*self.overrides, *more))


@dataclass(frozen=True, slots=True)
class Setting:
    """One run of a study."""

    name: str  # "spacing=1.5 support=2", or the preset
    overrides: tuple[str, ...]
    preset: str = ""


def accuracy_overrides(accuracy: str | float) -> tuple[str, ...]:
    """All that a preset or a target sets or counts on, given as keys, which a case's own would win over otherwise."""
    numerics, contact = keys_of(Numerics), keys_of(ContactNumerics)
    return (
        f"numerics.accuracy={accuracy}",
        "numerics.spacing=auto",
        HALVED,
        f"numerics.support={numerics['support'].default}",
        f"numerics.quadrature={numerics['quadrature'].default}",
        f"numerics.contact.spacing={contact['spacing'].default}",
    )
