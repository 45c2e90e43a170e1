"""A study before it runs: a case file with settings, the runs that are made of it, and their folders."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError, Fault

UNWRITTEN: Final = ("output.frames=none", "output.figures=false", "output.report=false")  # of runs that tell by tables
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


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One run of a study."""

    number: int
    name: str  # "angle=30 friction=0.2"
    folder: Path
    values: tuple[str, ...]  # of the parameters
    file: CaseFile  # with all settings of the run
    case: Case | None  # None where these make no case
    faults: tuple[Fault, ...] = ()  # why not
    reference: int | None = None  # number of the run that it is held against

    @property
    def refusal(self) -> str:
        """Why its settings make no case, in words."""
        return "; ".join(f"{fault.key}: {fault.message}" if fault.key else fault.message for fault in self.faults)

    @property
    def command(self) -> tuple[str, ...]:
        """The words of `crackgrow run`, with paths that hold in any folder."""
        settings = [word for setting in self.file.overrides for word in ("--set", setting)]
        where = ("--out", str(self.folder.resolve()), "--quiet", "--resume")
        return ("run", str(self.file.path.resolve()), *settings, *where)


@dataclass(frozen=True, slots=True, eq=False)
class Study:
    """All runs of a study."""

    command: str  # that makes it: sweep or trade
    name: str
    title: str  # of the base case
    folder: Path
    parameters: tuple[str, ...]  # short names of the keys
    runs: tuple[Run, ...]
    responses: tuple[str, ...] | None = None  # columns that the picture of a sweep shows; None: it chooses

    @property
    def words(self) -> str:
        """What it is called by those who find its folder locked."""
        return f"{self.command} {self.name}"

    @property
    def asked(self) -> tuple[Run, ...]:
        """The runs without those that are there for others to be held against."""
        against = {run.reference for run in self.runs}
        return tuple(run for run in self.runs if run.number not in against)


def folder_names(names: Iterable[str]) -> list[str]:
    """A folder for each run, such as angle=30_friction=0.2, in letters that every file system takes.

    A long name ends in its checksum; runs whose folders would be the same are counted: `_2`, `_3`.
    """
    met: Counter[str] = Counter()
    found = []
    for name in names:
        folder = re.sub(r"[^\w.=+-]+", "_", name).strip("_")
        if len(folder.encode()) > LONGEST:
            checksum = f"_{zlib.crc32(name.encode()):08x}"
            folder = folder.encode()[: LONGEST - len(checksum)].decode(errors="ignore") + checksum
        met[folder.lower()] += 1  # some file systems take capitals for the same
        count = met[folder.lower()]
        found.append(folder if count == 1 else f"{folder}_{count}")
    return found
