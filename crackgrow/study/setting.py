"""A case file that a study runs, the settings that it runs it with, and the folders that are named after them."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from crackgrow.case import Case, load_case
from crackgrow.case.declared import keys_of
from crackgrow.case.model import ContactNumerics, LoadHistory, Numerics, StrengthReduction
from crackgrow.errors import CaseError, Fault

UNWRITTEN: Final = ("output.frames=none", "output.figures=false", "output.report=false")
HALVED: Final = "numerics.refine={tips: auto, kinks: auto, corners: auto}"

LONGEST: Final = 120  # bytes: file systems take 255


@dataclass(frozen=True, slots=True)
class CaseFile:
    """A case file with the settings that replace its own."""

    path: Path
    overrides: tuple[str, ...] = ()

    def load(self, *more: str) -> Case:
        """The case with more settings replaced; raises CaseError."""
        return load_case(self.path, (*self.overrides, *more))

    def tried(self, *more: str) -> tuple[Case | None, tuple[Fault, ...]]:
        """The same, None where it has faults, and these."""
        try:
            return self.load(*more), ()
        except CaseError as error:
            return None, error.faults


@dataclass(frozen=True, slots=True)
class Setting:
    """One run of a study."""

    name: str  # "spacing=1.5 support=2", or the preset
    overrides: tuple[str, ...]
    preset: str = ""


def check_steps(case: Case, steps: int | None) -> None:
    """Raise CaseError where a number of growth steps is asked for that the case can't grow."""
    if steps is not None and (case.growth is None or steps < 0):
        wanted = "wanted: 0 or more" if case.growth else "the case has no `growth`, so no steps"
        raise CaseError.at("--steps", f"{steps} given; {wanted}")


def under_its_loads(case: Case) -> Case:
    """The case with the strength that it has, where it asks by how much that can be reduced."""
    if not isinstance(case.loading, StrengthReduction):
        return case
    return replace(case, loading=LoadHistory(case.loading.factors))


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


def folder_names(names: Iterable[str]) -> list[str]:
    """A folder for each run, by its name; runs whose folders would be the same are counted: `_2`, `_3`."""
    met: Counter[str] = Counter()
    found = []
    for name in names:
        folder = folder_name(name)
        met[folder.lower()] += 1  # some file systems take capitals for the same
        count = met[folder.lower()]
        found.append(folder if count == 1 else f"{folder}_{count}")
    return found


def folder_name(name: str) -> str:
    """Such as angle=30_friction=0.2, in letters that every file system takes; a long name ends in its checksum."""
    words = re.sub(r"[^\w.=+-]+", "_", name).strip("_")
    if len(words.encode()) <= LONGEST:
        return words
    checksum = f"_{zlib.crc32(name.encode()):08x}"
    return words.encode()[: LONGEST - len(checksum)].decode(errors="ignore") + checksum
