"""What a sweep file may say of a parameter: a list of values as the case takes them, or a range of numbers."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.case.reader import Broken, Listing, Node, Scalar, Table
from crackgrow.case.report import Path, quoted
from crackgrow.case.scalars import INVALID, Context, Measured, Spec, Words, refuse
from crackgrow.case.schema import OPTIONAL, Field, Mapping
from crackgrow.case.units import QuantityError, parse_number

DIGITS: Final = 12  # of a generated value: what is beyond is rounding, and 0.3 is not to be 0.30000000000000004
_PLAIN_ENDS: Final = re.compile(r"[,\[\]{}]")  # what a word without quotes can't hold inside a list
_NUMBER_AND_UNIT: Final = re.compile(r"([-+.\deE]*[\d.])\s*([^\W\d_].*)?")


@dataclass(frozen=True, slots=True)
class Listed:
    """Values one by one."""

    texts: tuple[str, ...]  # as an override takes them

    def at(self, parts: NDArray[np.float64]) -> tuple[str, ...]:
        """The values that take the places 0 <= part < 1 in the list."""
        return tuple(self.texts[int(part * len(self.texts))] for part in parts)


@dataclass(frozen=True, slots=True)
class Range:
    """Numbers from one to another, both taken, evenly spaced on their scale."""

    low: float
    high: float
    unit: str  # of both, empty for bare numbers
    n: int | None
    log: bool

    @property
    def texts(self) -> tuple[str, ...]:
        """The values, as an override takes them; one where the design chooses."""
        return self.at(np.linspace(0.0, 1.0, self.n or 1))

    def at(self, parts: NDArray[np.float64]) -> tuple[str, ...]:
        """The values at parts of the range: low at 0, high at 1."""
        return tuple(f"{value:.{DIGITS}g} {self.unit}".strip() for value in self.numbers(parts).tolist())

    def numbers(self, parts: NDArray[np.float64]) -> NDArray[np.float64]:
        """The same as numbers."""
        ratio = self.high / self.low if self.log else 1.0
        return np.asarray(self.low * ratio**parts if self.log else self.low + (self.high - self.low) * parts)


@dataclass(frozen=True, slots=True)
class _NumberWithUnit:
    """A number, bare or with a unit, which the case checks."""

    def describe(self) -> str:
        return "a number, bare or with a unit"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the number and its unit, empty for a bare one."""
        match = _NUMBER_AND_UNIT.fullmatch(node.text.strip()) if isinstance(node, Scalar) else None
        if not isinstance(node, Scalar) or match is None:
            return refuse(node, self.describe(), path, context)
        try:
            return parse_number(match[1]), match[2] or ""
        except QuantityError as error:
            context.report.fault(path, f"{quoted(node.text)} {error}; wanted: {self.describe()}")
            return INVALID


_RANGE: Final = Mapping(
    {
        "from": Field(_NumberWithUnit(), "the first value"),
        "to": Field(_NumberWithUnit(), "the last value"),
        "n": Field(Measured("whole number", ((">=", 2),)), "the number of values, both ends included", OPTIONAL),
        "scale": Field(Words(("linear", "log")), "on which the values are evenly spaced", "linear"),
    }
)


@dataclass(frozen=True, slots=True)
class ParameterValues:
    """The values of one parameter."""

    def describe(self) -> str:
        return "a list of values, or {from, to, n, scale}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return Listed or Range."""
        if isinstance(node, Table):
            found: Any = _RANGE.read(node, path, context)
            return self._range(found, path, context) if context.report.sound(*path) else INVALID
        if not isinstance(node, Listing):
            return refuse(node, self.describe(), path, context)
        if not node.items:
            context.report.fault(path, "an empty list given; wanted: at least one value")
            return INVALID
        texts: list[Any] = []
        for index, item in enumerate(node.items):
            context.report.put((*path, index), item.place)
            texts.append(ValueText().read(item, (*path, index), context))
        return Listed(tuple(texts)) if context.report.sound(*path) else INVALID

    def _range(self, found: dict[str, Any], path: Path, context: Context) -> object:
        (low, unit), (high, other), log = found["from"], found["to"], found["scale"] == "log"
        if unit != other:
            context.report.fault(path, f"from has the unit '{unit}', to has '{other}'; give both the same")
        elif low == high:
            context.report.fault(path, f"from and to are both {low:g}; a range has two ends")
        elif log and min(low, high) <= 0.0:
            context.report.fault(path, "scale: log needs `from` and `to` above 0")
        return Range(low, high, unit, found.get("n"), log) if context.report.sound(*path) else INVALID


@dataclass(frozen=True, slots=True)
class ValueText:
    """Any value, kept as text that reads back to it."""

    def describe(self) -> str:
        return "a value as the case takes it"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the text."""
        try:
            return yaml_text(node)
        except ValueError:  # of what the reader has found broken
            return INVALID


@dataclass(frozen=True, slots=True)
class KeyedValues:
    """A mapping from keys of the case, such as numerics.spacing; one key at least."""

    spec: Spec

    def describe(self) -> str:
        return f"a mapping of keys of the case such as numerics.spacing, each {self.spec.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a dict in the order of the file."""
        if not isinstance(node, Table) or not node.entries:
            return refuse(node, self.describe(), path, context)
        values: dict[str, object] = {}
        for key, entry in node.entries.items():
            inner = (*path, key)
            context.report.put(inner, entry.place)
            if not all(key.split(".")) or "=" in key:
                context.report.fault(inner, f"{quoted(key)} is not a key path such as numerics.spacing")
            else:
                values[key] = self.spec.read(entry.node, inner, context)
        return values


def yaml_text(node: Node) -> str:
    """The node on one line of YAML; what was in quotes stays in quotes. Raises ValueError where it is broken."""
    if isinstance(node, Listing):
        return f"[{', '.join(_inner(item) for item in node.items)}]"
    if isinstance(node, Table):
        return f"{{{', '.join(f'{json.dumps(key)}: {_inner(entry.node)}' for key, entry in node.entries.items())}}}"
    if isinstance(node, Broken):
        raise ValueError("a broken node has no text")
    return node.text if node.plain else json.dumps(node.text, ensure_ascii=False)


def _inner(node: Node) -> str:
    """As `yaml_text`, inside a list or a mapping."""
    text = yaml_text(node)
    return json.dumps(text, ensure_ascii=False) if isinstance(node, Scalar) and _PLAIN_ENDS.search(text) else text
