"""Specs of single values: text, words, switches, numbers and quantities with a unit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Final, Protocol

from crackgrow.case.reader import Broken, Listing, Node, Scalar
from crackgrow.case.report import Path, Place, Report, did_you_mean, quoted
from crackgrow.case.units import UNITS, QuantityError, Units, is_number, parse_number, parse_quantity

_BEGIN_OF_NUMBER: Final = tuple("+-.0123456789")

INVALID: Final = object()  # stands for a value whose fault is in the report


@dataclass(frozen=True, slots=True)
class Definition:
    """A thing under a name that other keys refer to."""

    value: object
    sound: bool  # whether it has no fault
    places: dict[Path, Place]  # of its keys, each from the thing on


@dataclass(frozen=True, slots=True)
class Context:
    """What reading a value needs besides its node."""

    report: Report
    units: Units
    folder: FilePath = FilePath()  # what file names in the case are relative to
    folders: dict[str, FilePath] = field(default_factory=dict)  # the same of the file and its bases, by name in faults
    defined: dict[str, dict[str, Definition]] = field(default_factory=dict)  # by kind and name, as they are read

    def refused(self, path: Path, message: str) -> object:
        """Report the fault of a value, and return INVALID in its place."""
        self.report.fault(path, message)
        return INVALID

    def folder_of(self, node: Node) -> FilePath:
        """What a file name is relative to: the folder of the file that it stands in."""
        return self.folders.get(node.place.source, self.folder)


class Spec(Protocol):
    """What is allowed at one place of the case file."""

    def describe(self) -> str:
        """Say in a few words what is allowed."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the plain SI value with defaults filled in, or INVALID after reporting why not."""


def given(node: Node) -> str:
    """Say what kind of value stands in the file."""
    if isinstance(node, Scalar):
        return "no value" if node.is_null else quoted(node.text)
    return "a list" if isinstance(node, Listing) else "a mapping"


def refuse(node: Node, wanted: str, path: Path, context: Context) -> object:
    """Report a value of the wrong type, unless its fault is known, and return INVALID."""
    if not isinstance(node, Broken):
        context.report.fault(path, f"{given(node)} given; wanted: {wanted}")
    return INVALID


@dataclass(frozen=True, slots=True)
class Text:
    """Words for people."""

    may_be_empty: bool = False

    def describe(self) -> str:
        return "a text"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the text."""
        if not isinstance(node, Scalar) or node.is_null or not (self.may_be_empty or node.text.strip()):
            return refuse(node, self.describe(), path, context)
        return node.text


@dataclass(frozen=True, slots=True)
class Choice:
    """One of a few words, perhaps with a line about each."""

    words: tuple[str, ...]
    docs: tuple[str, ...] = ()

    def describe(self) -> str:
        return " | ".join(self.words)

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the word."""
        if not isinstance(node, Scalar) or node.is_null:
            return refuse(node, self.describe(), path, context)
        if node.text in self.words:
            return node.text
        message = f"{quoted(node.text)} is not one of {self.describe()}{did_you_mean(node.text, self.words)}"
        return context.refused(path, message)


@dataclass(frozen=True, slots=True)
class Switch:
    """Yes or no."""

    def describe(self) -> str:
        return "true | false"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the bool."""
        if isinstance(node, Scalar) and node.plain and node.text.lower() in ("true", "false"):
            return node.text.lower() == "true"
        return refuse(node, self.describe(), path, context)


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of a number, in SI."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    def describe(self) -> str:
        """Return such as ' > 0 and < 90'."""
        signs = {">": self.above, ">=": self.at_least, "<": self.below, "<=": self.at_most}
        limits = [f"{sign} {limit:g}" for sign, limit in signs.items() if limit is not None]
        return f" {' and '.join(limits)}" if limits else ""

    def hold(self, value: float) -> bool:
        """Whether the value lies within."""
        return (
            (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.below is None or value < self.below)
            and (self.at_most is None or value <= self.at_most)
        )


ANY: Final = Bounds()
POSITIVE: Final = Bounds(above=0)
NOT_NEGATIVE: Final = Bounds(at_least=0)


def _read_float(
    node: Node, path: Path, context: Context, spec: Measured, convert: Callable[[str], float], hint: str = ""
) -> object:
    """Convert the text of a scalar and hold it to its bounds."""
    if not isinstance(node, Scalar) or node.is_null:
        return refuse(node, spec.describe() + hint, path, context)
    if not node.plain and is_number(node.text.strip()):
        message = f'"{node.text.strip()}" in quotes is a text; write {spec.describe()} without quotes'
        return context.refused(path, message)
    try:
        value = convert(node.text)
    except QuantityError as error:
        return context.refused(path, f"{quoted(node.text)} {error}; wanted: {spec.describe()}{hint}")
    if not spec.bounds.hold(value):
        return context.refused(path, f"{quoted(node.text)} is out of range; wanted: {spec.describe()}")
    return value


@dataclass(frozen=True, slots=True)
class Number:
    """A number without a unit."""

    bounds: Bounds = ANY
    multiple_of: float | None = None
    note: str = ""  # added to the message for what is no number

    def describe(self) -> str:
        grid = "" if self.multiple_of is None else f" in steps of {self.multiple_of:g}"
        return f"a number{self.bounds.describe()}{grid}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the float."""
        value = _read_float(node, path, context, self, parse_number, self.note)
        if isinstance(value, float) and self.multiple_of and value % self.multiple_of != 0:
            return refuse(node, self.describe(), path, context)
        return value


@dataclass(frozen=True, slots=True)
class Integer:
    """A whole number."""

    bounds: Bounds = ANY

    def describe(self) -> str:
        return f"a whole number{self.bounds.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the int."""
        value = _read_float(node, path, context, self, parse_number)
        if not isinstance(value, float):
            return INVALID
        return int(value) if value.is_integer() else refuse(node, self.describe(), path, context)


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with a unit of its own, or a bare one in the units of the case."""

    kind: str  # a key of UNITS
    bounds: Bounds = ANY
    note: str = ""  # added to the message for what is no quantity

    def describe(self) -> str:
        article = "an" if self.kind[0] in "aeiou" else "a"
        return f"{article} {self.kind}{self.bounds.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the float in SI (angles in degrees)."""

        def convert(text: str) -> float:
            return parse_quantity(text, self.kind, context.units)

        bare = f"; a bare number means {context.units.of(self.kind)}" if context.units.bare(self.kind) else ""
        hint = f" ({' | '.join(UNITS[self.kind])}{bare}){self.note}"
        return _read_float(node, path, context, self, convert, hint)


@dataclass(frozen=True, slots=True)
class Share:
    """A part of something, as a number or in percent."""

    bounds: Bounds = ANY

    def describe(self) -> str:
        return f"a part such as 0.01 or 1 %{self.bounds.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the part of one."""

        def convert(text: str) -> float:
            number = text.strip()
            if number.endswith("%"):
                return parse_number(number.removesuffix("%").strip(), Fraction(1, 100))
            return parse_number(number)

        return _read_float(node, path, context, self, convert)


Measured = Number | Integer | Quantity | Share


@dataclass(frozen=True, slots=True)
class WordOr:
    """One of a few words, or else what another spec allows."""

    words: tuple[str, ...]
    spec: Spec
    docs: tuple[str, ...] = ()  # a line about each of the words

    def describe(self) -> str:
        return f"{' | '.join(self.words)} | {self.spec.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the word or the other spec's value."""
        if not isinstance(node, Scalar):
            return self.spec.read(node, path, context)
        if node.text in self.words:
            return node.text
        if node.plain and is_number(node.text) and isinstance(self.spec, Measured):
            return self.spec.read(node, path, context)
        if isinstance(self.spec, Quantity | Share) and node.text.strip()[:1] in _BEGIN_OF_NUMBER:
            return self.spec.read(node, path, context)
        hint = did_you_mean(node.text, self.words)
        note = self.spec.note if isinstance(self.spec, Number) and node.text[:1] in _BEGIN_OF_NUMBER else ""
        return context.refused(path, f"{given(node)} given; wanted: {self.describe()}{note}{hint}")
