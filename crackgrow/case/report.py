"""Collecting faults: each with the place of its key, all of them before anything is raised."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path as FilePath
from typing import Any

import yaml

from crackgrow.errors import CaseError, Fault

Path = tuple[str | int, ...]
Faults = Iterator[tuple[Path, str]]
"""What a check finds: the key of each fault, and what is wrong."""

SHOWN_LENGTH = 60  # longer texts are cut in messages
SHOWN_WORDS = 12  # of a longer list the rest is left out in messages
SIMILARITY = 0.55  # least likeness of a "did you mean", between 0 and 1


@dataclass(frozen=True, slots=True)
class Place:
    """Where a key or value stands."""

    source: str  # file name as given, or "--set key" for an override
    line: int | None  # counted from 1; None for an override


def clean(text: str) -> str:
    """Cut `text` to a length for messages and escape what cannot be printed on one line."""
    cut = text if len(text) <= SHOWN_LENGTH else text[: SHOWN_LENGTH - 3] + "..."
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in cut)


def quoted(text: str) -> str:
    """Show a text from the file inside a message."""
    return f"'{clean(text)}'"


def listed(words: Iterable[str]) -> str:
    """Words, each once; of many the first ones and the last."""
    each = [clean(word) or "''" for word in dict.fromkeys(words)]
    shown = each if len(each) <= SHOWN_WORDS else [*each[:SHOWN_WORDS], "...", each[-1]]
    return ", ".join(shown) or "none"


def dotted(path: Path) -> str:
    """Write a key path the way `--set` takes it."""
    return ".".join(clean(str(part)) for part in path)


@cache
def words_elsewhere() -> dict[str, Any]:
    """What users of other programs and of books write, as `synonyms.yaml` has it."""
    text = FilePath(__file__).with_name("synonyms.yaml").read_text(encoding="utf-8")
    found: dict[str, Any] = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    return found


def nearest(text: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed word that `text` is another name for, or else the one that looks most like it."""
    known = {word.lower(): word for word in allowed}
    for meant in words_elsewhere()["meant"].get(text.lower(), ()):
        if meant in known:
            return known[meant]
    near = difflib.get_close_matches(text[:SHOWN_LENGTH].lower(), list(known), n=1, cutoff=SIMILARITY)
    return known[near[0]] if near else None


def did_you_mean(text: str, allowed: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for the nearest of the allowed words, what to do instead, or nothing."""
    allowed = list(allowed)
    word = nearest(text, allowed)
    return explained(text, allowed) or (f"; did you mean '{word}'?" if word else "")


def explained(text: str, allowed: Iterable[str]) -> str:
    """Return "; what to do instead" of a word that no allowed one stands for, or nothing."""
    for words, key, instead in words_elsewhere()["explained"]:
        if text.lower() in words and key in allowed:
            return f"; {instead}"
    return ""


@dataclass(slots=True)
class Report:
    """Faults found so far and the places of all keys read so far."""

    source: str  # the case file, as given
    faults: list[Fault] = field(default_factory=list)
    places: dict[Path, Place] = field(default_factory=dict)
    overridden: list[Path] = field(default_factory=list)  # keys that stand in an override
    faulty: set[Path] = field(default_factory=set)
    above_faulty: set[Path] = field(default_factory=set)  # the faulty keys and all that contain them

    def put(self, path: Path, place: Place) -> None:
        """Note where a key stands."""
        self.places[path] = place
        if place.line is None:
            self.overridden.append(path)

    def fault(self, path: Path, message: str, place: Place | None = None) -> None:
        """Note a fault; without a place, that of an override in the value or else the nearest key that is given."""
        where = place or self._place_of(path)
        self.faults.append(Fault(where.source, where.line, dotted(path), message))
        self.doubt(path)

    def doubt(self, path: Path) -> None:
        """Mark a key as faulty; its fault is reported elsewhere, such as a misspelling of it."""
        self.faulty.add(path)
        self.above_faulty.update(path[:n] for n in range(len(path) + 1))

    def sound(self, *path: str | int) -> bool:
        """Whether no fault lies at this key, inside it, or at a key that contains it."""
        return path not in self.above_faulty and not any(path[:n] in self.faulty for n in range(len(path)))

    def error(self) -> CaseError:
        """Return the error with all faults: those of the file by line, of its bases, then those of overrides."""

        def order(fault: Fault) -> tuple[bool, bool, str, int]:
            if fault.line is None:
                return True, False, "", 0  # in the order in which they are found
            return False, fault.source != self.source, fault.source, fault.line

        return CaseError(sorted(self.faults, key=order))

    def _place_of(self, path: Path) -> Place:
        for key in self.overridden if path else ():
            if key[: len(path)] == path:
                return self.places[key]
        for n in range(len(path), -1, -1):
            if path[:n] in self.places:
                return self.places[path[:n]]
        return Place(self.source, 1)
