"""The one family of errors that crackgrow raises on purpose."""

from __future__ import annotations

from dataclasses import dataclass


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

    def __str__(self) -> str:
        place = self.source if self.line is None else f"{self.source}:{self.line}"
        told = not self.key or place == f"--set {self.key}"
        return f"{place}: {self.message}" if told else f"{place}: {self.key}: {self.message}"


class CaseError(CrackgrowError):
    """The case is wrong; carries every fault found, in file order."""

    exit_code = 2

    def __init__(self, faults: list[Fault] | tuple[Fault, ...]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


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


def reason_of(error: BaseException) -> str:
    """Why a run broke off, in a line: what the program raises on purpose speaks for itself."""
    if isinstance(error, CrackgrowError):
        return " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return " ".join(f"out of memory: {error}".split())
    return " ".join(f"internal error: {type(error).__name__}: {error}".split())
