"""A case file that a study runs with other settings than its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from crackgrow.case import Case, load_case


@dataclass(frozen=True, slots=True)
class CaseFile:
    """A case file with the settings that replace its own."""

    path: Path
    overrides: tuple[str, ...] = ()

    def load(self, *more: str) -> Case:
        """The case with more settings replaced; raises CaseError."""
        return load_case(self.path, (*self.overrides, *more))
