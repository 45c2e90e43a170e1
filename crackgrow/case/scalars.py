"""Specs of single values: text, words, switches, numbers, quantities with a unit, and names of what is defined."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Any, Final, Protocol

from crackgrow.case.reader import Broken, Listing, Node, Scalar
from crackgrow.case.report import Path, Report, did_you_mean, quoted
from crackgrow.case.units import UNITS, QuantityError, Units, is_number, parse_number, parse_quantity

PLAIN: Final = "number"  # kinds without a unit
WHOLE: Final = "whole number"
SHARE: Final = "share"

INVALID: Final = object()  # stands for a value whose fault is in the report

_BEGIN_OF_NUMBER: Final = tuple("+-.0123456789")


@dataclass(slots=True)
class Context:
    """What reading a value needs besides its node."""

    report: Report
    units: Units  # in which what follows is read
    folder: FilePath = FilePath()  # what file names in the case are relative to
    folders: dict[str, FilePath] = field(default_factory=dict)  # the same of the file and its bases, by name in faults
    defined: dict[str, dict[str, Node]] = field(default_factory=dict)  # what other keys refer to, by key and name

    def refused(self, path: Path, message: str) -> object:
        """Report the fault of a value, and return INVALID in its place."""
        self.report.fault(path, message)
        return INVALID


class Spec(Protocol):
    """What is allowed at one place of a file."""

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
class Switch:
    """Yes or no."""

    def describe(self) -> str:
        return "true | false"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the bool."""
        if isinstance(node, Scalar) and node.plain and node.text.lower() in ("true", "false"):
            return node.text.lower() == "true"
        return refuse(node, self.describe(), path, context)


SIGNS: Final[dict[str, Callable[[float, float], bool]]] = {
    ">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le,
}  # fmt: skip
"""Of the sign of a bound when it holds."""

Bounds = tuple[tuple[str, float], ...]
"""Limits of a number in SI, each with its sign."""


class Numeric(Spec):
    """A number, a quantity or what stands for one, written without quotes."""

    def parse(self, text: str, context: Context) -> object:
        """Convert a text of a case to a value in SI units; each kind of number does so. Raises QuantityError."""
        raise NotImplementedError

    def hint(self, context: Context) -> str:
        """What is added to the message for what is none."""
        return ""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the value, in SI."""
        wanted = self.describe() + self.hint(context)
        if not isinstance(node, Scalar) or node.is_null:
            return refuse(node, wanted, path, context)
        text = node.text.strip()
        if not node.plain and is_number(text):
            return context.refused(path, f'"{text}" in quotes is a text; write {self.describe()} without quotes')
        try:
            return self.parse(text, context)
        except QuantityError as error:
            return context.refused(path, f"{quoted(node.text)} {error}; wanted: {wanted}")


@dataclass(frozen=True, slots=True)
class Measured(Numeric):
    """A number, or a quantity with a unit of its own or a bare one in the units of the case, within bounds."""

    kind: str  # number, whole number, share, or a key of UNITS
    bounds: Bounds = ()
    step: float | None = None  # between the numbers that are taken
    note: str = ""  # added to the message for what is none

    @property
    def limits(self) -> str:
        """The bounds in signs, such as "> 0 and < 90"."""
        return " and ".join(f"{sign} {limit:g}" for sign, limit in self.bounds)

    def holds(self, value: float) -> bool:
        """Whether a number lies within the bounds."""
        return all(SIGNS[sign](value, limit) for sign, limit in self.bounds)

    def describe(self) -> str:
        kind = "part such as 0.01 or 1 %" if self.kind == SHARE else self.kind
        grid = "" if self.step is None else f"in steps of {self.step:g}"
        return " ".join(filter(None, ["an" if kind[0] in "aeiou" else "a", kind, self.limits, grid]))

    def parse(self, text: str, context: Context) -> float:
        """The number, whole where it is to be; raises QuantityError."""
        number, percent, rest = text.partition("%")
        if self.kind in UNITS:
            value = parse_quantity(text, self.kind, context.units)
        elif self.kind == SHARE and percent and not rest:
            value = parse_number(number.strip(), Fraction(1, 100))
        else:
            value = parse_number(text)
        if not self.holds(value):
            raise QuantityError("is out of range")
        if (self.kind == WHOLE and not value.is_integer()) or (self.step and value % self.step):
            raise QuantityError("given")
        return int(value) if self.kind == WHOLE else value

    def hint(self, context: Context) -> str:
        if self.kind not in UNITS:
            return self.note
        bare = f"; a bare number means {context.units.of(self.kind)}" if context.units.bare(self.kind) else ""
        return f" ({' | '.join(UNITS[self.kind])}{bare}){self.note}"


def _begins_number(node: Node) -> bool:
    return isinstance(node, Scalar) and node.text.strip()[:1] in _BEGIN_OF_NUMBER


def _looks_measured(node: Scalar, spec: Any) -> bool:
    """Whether a text where words stand is a number, or the beginning of one where it may have a unit."""
    with_unit = isinstance(spec, Measured) and spec.kind not in (PLAIN, WHOLE) and _begins_number(node)
    return isinstance(spec, Measured) and (with_unit or (node.plain and is_number(node.text)))


@dataclass(frozen=True, slots=True)
class Words:
    """One of a few words, perhaps with a line about each, or else what another spec allows."""

    words: tuple[str, ...]
    docs: tuple[str, ...] = ()
    spec: Any = None

    def describe(self) -> str:
        return " | ".join([*self.words, *([self.spec.describe()] if self.spec else [])])

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the word or the other spec's value."""
        if isinstance(node, Scalar) and node.text in self.words:
            return node.text
        if self.spec and (not isinstance(node, Scalar) or _looks_measured(node, self.spec)):
            return self.spec.read(node, path, context)
        hint = did_you_mean(node.text, self.words) if isinstance(node, Scalar) and not node.is_null else ""
        note = self.spec.note if _begins_number(node) and isinstance(self.spec, Measured) else ""
        return refuse(node, f"{self.describe()}{note}{hint}", path, context)


@dataclass(frozen=True, slots=True)
class Reference:
    """A thing that is written out, or the name of one that is defined; the value is the thing."""

    where: str  # the key that holds the definitions
    spec: Any  # of what is written out

    def describe(self) -> str:
        return f"{self.spec.describe()}, or a name from `{self.where}`"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the thing; faults that are found in it later stand in the lines of its definition."""
        words = self.spec.words if isinstance(self.spec, Words) else ()
        if not isinstance(node, Scalar) or node.is_null or node.text in words:
            return self.spec.read(node, path, context)
        known = context.defined.get(self.where, {})
        if node.text not in known:
            has = f"`{self.where}` has: {', '.join(known) or 'none'}{did_you_mean(node.text, [*known, *words])}"
            return context.refused(path, f"{quoted(node.text)} given; wanted: {self.describe()}; {has}")
        if not context.report.sound(self.where, node.text):
            context.report.doubt(path)  # its faults are reported where it is defined
            return INVALID
        return self.spec.read(known[node.text], path, context)
