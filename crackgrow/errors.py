"""The one family of errors that crackgrow raises on purpose."""

from __future__ import annotations

import errno
from dataclasses import dataclass
from typing import Final

NO_ROOM: Final = (
    "failed to map segment",
    "annot allocate memory",
    "without exception set",
    "without setting an",
    "Failed to load vtk",  # whose own reason it keeps to itself
)
LESS_MEMORY: Final = (
    "a larger numerics.spacing takes less, twice it about a quarter; so do growth.steps that end earlier, "
    "output.figures=false and output.frames=none"
)


class CrackgrowError(Exception):
    """Base of every error that the program raises on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong in a case file: where it is and what is allowed there."""

    source: str  # file name, or "--set" for an override
    line: int | None  # counted from 1; None for an override
    key: str  # dotted key path, "" for the whole file
    message: str  # what was given, what is allowed

    @property
    def of_override(self) -> str:
        """The key of the override that is wrong; empty where a file is."""
        return self.source.partition("--set ")[2]

    def __str__(self) -> str:
        place = self.source if self.line is None else f"{self.source}:{self.line}"
        inner = f"{self.key}.".removeprefix(f"{place.removeprefix('--set ')}.").removesuffix(".")
        key = self.key if inner[:1].isdigit() else inner  # of what an override sets, the place has the beginning
        return f"{place}: {key}: {self.message}" if key else f"{place}: {self.message}"


class CaseError(CrackgrowError):
    """The case is wrong; carries every fault found, in file order."""

    exit_code = 2

    def __init__(self, faults: list[Fault] | tuple[Fault, ...]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))

    @classmethod
    def at(cls, source: object, message: str, key: str = "") -> CaseError:
        """That of one fault without a line: of an option such as "--steps", or of a whole file."""
        return cls([Fault(str(source), None, key, message)])


class GeometryError(CrackgrowError):
    """A geometry that the cover cannot represent; the message names the place and the remedy."""

    exit_code = 3


class SolveError(CrackgrowError):
    """A system that has no acceptable solution; the message names the quantity, its value and the remedy."""

    exit_code = 3


class NotSolvedError(SolveError):
    """A system whose solution was not found, or not to enough digits: there may be one."""


class FreePieceError(SolveError):
    """A system without equilibrium: a piece of rock that nothing holds.

    `what` says which piece and how it can move, the message adds the remedy.
    """

    def __init__(self, what: str, remedy: str) -> None:
        self.what, self.remedy = what, remedy
        super().__init__(f"{what}; {remedy}")


def is_out_of_memory(error: BaseException) -> bool:
    """Whether memory has run out: also where it was a library that found no room."""
    if isinstance(error, ImportError | SystemError):  # SystemError: of a library that fails without a word
        return any(words in str(error) for words in NO_ROOM)
    return isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM)


def reason_of(error: BaseException) -> str:
    """Why a run broke off, in a line: what the program raises on purpose speaks for itself."""
    if isinstance(error, CrackgrowError):
        return " ".join(str(error).split())
    if is_out_of_memory(error):
        return " ".join(f"out of memory{f': {error}' if str(error) else ''}; {LESS_MEMORY}".split())
    if isinstance(error, OSError) and error.strerror:
        return f"the system refuses: {error.strerror}{f': {error.filename}' if error.filename else ''}"
    return " ".join(f"internal error: {type(error).__name__}: {error}".split())
