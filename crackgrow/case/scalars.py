"""Specs of single values: text, words, switches, numbers and quantities with a unit."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Any, Final, NamedTuple, Protocol

from crackgrow.case.reader import Broken, Listing, Node, Scalar
from crackgrow.case.report import Path, Report, did_you_mean, quoted
from crackgrow.case.units import LARGEST, SMALLEST, UNITS, QuantityError, Units, is_number, parse_number, parse_quantity

Schema = dict[str, Any]  # in JSON Schema

INVALID: Final = object()  # stands for a value whose fault is in the report

NUMBER: Final = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"  # pattern of a number in JSON Schema
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0


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

    def folder_of(self, node: Node) -> FilePath:
        """What a file name is relative to: the folder of the file that it stands in."""
        return self.folders.get(node.place.source, self.folder)


class Spec(Protocol):
    """What is allowed at one place of a file. Those of cases also tell what they take, and their JSON Schema."""

    def describe(self) -> str:
        """Say in a few words what is allowed."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the plain SI value with defaults filled in, or INVALID after reporting why not."""


class Takes(NamedTuple):
    """What a spec takes, for the documentation."""

    kind: str
    units: str = ""  # that it may have, and what a bare number means
    allowed: str = ""  # values; empty where the kind says all


class Schemas:
    """JSON Schemas of specs; parts of the format and quantities are definitions that the others refer to."""

    def __init__(self) -> None:
        self.definitions: dict[str, Schema] = {}

    def of(self, spec: Any) -> Schema:
        """What a spec accepts, as far as JSON Schema can say it."""
        part = getattr(spec, "part", "")
        found: Schema = self.named(part, lambda: spec.schema(self)) if part else spec.schema(self)
        return found

    def named(self, name: str, make: Callable[[], Schema]) -> Schema:
        """A reference to a definition, made where it is not known yet."""
        name = re.sub(r"\W+", "_", name)
        if name not in self.definitions:
            self.definitions[name] = {}  # its place, before those inside of it
            self.definitions[name] = make()
        return {"$ref": f"#/definitions/{name}"}


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

    def takes(self) -> Takes:
        return Takes("text")

    def schema(self, _: Schemas) -> Schema:  # an editor takes 2017 and true for no texts, the reader does
        return {"type": ["string", "number", "boolean"], **({} if self.may_be_empty else {"pattern": r"\S"})}

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

    def takes(self) -> Takes:
        told = [f"`{word}`: {doc}" for word, doc in zip(self.words, self.docs, strict=True)] if self.docs else []
        return Takes("word", "", "; ".join(told or [f"`{word}`" for word in self.words]))

    def schema(self, _: Schemas) -> Schema:
        return {"enum": list(self.words), **({"enumDescriptions": list(self.docs)} if self.docs else {})}

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

    def takes(self) -> Takes:
        return Takes("true or false")

    def schema(self, _: Schemas) -> Schema:
        return {"type": "boolean"}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the bool."""
        if isinstance(node, Scalar) and node.plain and node.text.lower() in ("true", "false"):
            return node.text.lower() == "true"
        return refuse(node, self.describe(), path, context)


SIGNS: Final[dict[str, tuple[str, str, Callable[[float, float], bool]]]] = {
    ">": ("above", "exclusiveMinimum", operator.gt),
    ">=": ("at_least", "minimum", operator.ge),
    "<": ("below", "exclusiveMaximum", operator.lt),
    "<=": ("at_most", "maximum", operator.le),
}
"""Of each sign the bound, its key in JSON Schema, and when it holds."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of a number, in SI."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    @property
    def limits(self) -> dict[str, float]:
        """The limits by sign."""
        limits = {sign: getattr(self, name) for sign, (name, *_) in SIGNS.items()}
        return {sign: limit for sign, limit in limits.items() if limit is not None}

    def describe(self) -> str:
        """Return such as ' > 0 and < 90'."""
        limits = [f"{sign} {limit:g}" for sign, limit in self.limits.items()]
        return f" {' and '.join(limits)}" if limits else ""

    def hold(self, value: float) -> bool:
        """Whether the value lies within."""
        return all(SIGNS[sign][2](value, limit) for sign, limit in self.limits.items())

    def schema(self) -> Schema:
        """The bounds of a number in JSON Schema; a text heeds none of them."""
        return {SIGNS[sign][1]: limit for sign, limit in self.limits.items()}


ANY: Final = Bounds()


class Measured:
    """A number within bounds, which is written in one of several ways."""

    __slots__ = ()
    kind: str  # of number, or of quantity
    bounds: Bounds
    multiple_of: float | None = None
    note: str = ""  # added to the message for what is none

    def describe(self) -> str:
        grid = "" if self.multiple_of is None else f" in steps of {self.multiple_of:g}"
        return f"{'an' if self.kind[0] in 'aeiou' else 'a'} {self.kind}{self.bounds.describe()}{grid}"

    def takes(self) -> Takes:
        grid = f", in steps of {self.multiple_of:g}" if self.multiple_of else ""
        units = units_of(self.kind) if self.kind in UNITS else ""
        return Takes(self.kind, units, self.bounds.describe().strip() + grid)

    def parse(self, text: str, context: Context) -> float:
        """The number that a text stands for; raises QuantityError."""
        return parse_number(text)

    def hint(self, context: Context) -> str:
        """What is added to the message for what is none."""
        return self.note

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the float, in SI."""
        wanted = self.describe()
        if not isinstance(node, Scalar) or node.is_null:
            return refuse(node, wanted + self.hint(context), path, context)
        if not node.plain and is_number(node.text.strip()):
            message = f'"{node.text.strip()}" in quotes is a text; write {wanted} without quotes'
            return context.refused(path, message)
        try:
            value = self.parse(node.text, context)
        except QuantityError as error:
            return context.refused(path, f"{quoted(node.text)} {error}; wanted: {wanted}{self.hint(context)}")
        if not self.bounds.hold(value):
            return context.refused(path, f"{quoted(node.text)} is out of range; wanted: {wanted}")
        return value


@dataclass(frozen=True, slots=True)
class Number(Measured):
    """A number without a unit."""

    kind = "number"
    bounds: Bounds = ANY
    multiple_of: float | None = None
    note: str = ""

    def schema(self, schemas: Schemas) -> Schema:
        return {"allOf": [schemas.named("number", lambda: _bare(1.0))], **self.bounds.schema()}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the float."""
        value = Measured.read(self, node, path, context)
        if isinstance(value, float) and self.multiple_of and value % self.multiple_of != 0:
            return refuse(node, self.describe(), path, context)
        return value


@dataclass(frozen=True, slots=True)
class Integer(Measured):
    """A whole number."""

    kind = "whole number"
    bounds: Bounds = ANY

    def schema(self, _: Schemas) -> Schema:
        return {"type": "integer", **self.bounds.schema()}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the int."""
        value = Measured.read(self, node, path, context)
        if not isinstance(value, float):
            return INVALID
        return int(value) if value.is_integer() else refuse(node, self.describe(), path, context)


@dataclass(frozen=True, slots=True)
class Share(Measured):
    """A part of something, as a number or in percent."""

    kind = "part such as 0.01 or 1 %"
    bounds: Bounds = ANY

    def takes(self) -> Takes:
        return Takes(self.describe())

    def schema(self, _: Schemas) -> Schema:
        percent = {"type": "string", "pattern": rf"^\s*{NUMBER}\s*%\s*$"}
        return {"anyOf": [{"type": "number", **self.bounds.schema()}, percent]}

    def parse(self, text: str, context: Context) -> float:
        number, percent, rest = text.strip().partition("%")
        if percent and not rest:
            return parse_number(number.strip(), Fraction(1, 100))
        return parse_number(text.strip())


@dataclass(frozen=True, slots=True)
class Quantity(Measured):
    """A number with a unit of its own, or a bare one in the units of the case."""

    kind: str  # a key of UNITS
    bounds: Bounds = ANY
    note: str = ""

    def schema(self, schemas: Schemas) -> Schema:
        whole = schemas.named(self.kind, lambda: _quantity(self.kind))
        if self.bounds == ANY:
            return whole
        sign = {}  # what a pattern can tell of the bounds of a number with a unit
        if self.bounds.above == 0:
            sign = {"pattern": rf"^(?!\s*-)(?={_NOT_ZERO})"}
        elif self.bounds.at_least == 0:
            sign = {"pattern": rf"^(?!\s*-{_NOT_ZERO})"}
        return {"title": self.describe().partition(" ")[2], "allOf": [whole], **self.bounds.schema(), **sign}

    def parse(self, text: str, context: Context) -> float:
        return parse_quantity(text, self.kind, context.units)

    def hint(self, context: Context) -> str:
        bare = f"; a bare number means {context.units.of(self.kind)}" if context.units.bare(self.kind) else ""
        return f" ({' | '.join(UNITS[self.kind])}{bare}){self.note}"


def units_of(kind: str) -> str:
    """Units of a quantity, and the one of a bare number where the case chooses it."""
    listed = ", ".join(UNITS[kind])
    return f"{listed}; bare: that of units.{kind}" if hasattr(Units(), kind) else listed


def _bare(largest: float) -> Schema:
    """A number that is physical in the largest of its units: not .nan, which no bound refuses, and 0 or far from it."""
    near = {"exclusiveMinimum": -SMALLEST / largest, "exclusiveMaximum": SMALLEST / largest, "not": {"const": 0}}
    return {"title": "number", "type": "number", "minimum": -LARGEST, "maximum": LARGEST, "not": near}


def _quantity(kind: str) -> Schema:
    """A bare number, whose unit is another key's business, or a text of a number and a unit."""
    chosen = {
        "length": "in units.length",
        "stress": "in units.stress",
        "toughness": "in units.stress sqrt(m), where units.length is m",
        "stiffness": "in units.stress / units.length",
        "area": "in units.length^2",
    }
    bare = chosen.get(kind, f"in {next(iter(UNITS[kind]))}")
    units = "|".join(re.escape(unit) for unit in UNITS[kind])
    return {
        "title": f"{kind} ({' | '.join(UNITS[kind])}; a bare number is {bare})",
        "anyOf": [
            _bare(float(max(UNITS[kind].values()))),
            {"type": "string", "pattern": rf"^\s*{NUMBER}\s*({units})\s*$"},
        ],
    }
