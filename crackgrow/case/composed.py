"""Specs of things under names, and of names that stand for what is defined elsewhere."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Final

from crackgrow.case.reader import Node, Scalar, Table
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.scalars import INVALID, Context, Words, refuse
from crackgrow.case.schema import MOST_ITEMS, Mapping, OneOf

CONSTANTS: Final = ("true", "false", "null")  # of YAML

_NAME: Final = re.compile(r"\w[\w-]{0,63}")


def core(spec: Any) -> Mapping | OneOf | None:
    """The mapping, or the forms of one, inside of a spec, or None."""
    if isinstance(spec, Mapping | OneOf):
        return spec
    inner = getattr(spec, "spec", None)
    return core(inner) if inner is not None else None


@dataclass(frozen=True, slots=True)
class Named:
    """Things under names of the user's choice."""

    thing: str
    spec: Any
    at_most: int = MOST_ITEMS
    any_name: bool = False  # whether names are those of another file, whatever they are
    other_words: tuple[str, ...] | None = None  # what is no name of a thing that other keys refer to; None: none does

    def describe(self) -> str:
        return f"a mapping of names, each a {self.thing}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a dict of the values in file order."""
        if not isinstance(node, Table):
            return refuse(node, self.describe(), path, context)
        if len(node.entries) > self.at_most:
            return context.refused(path, f"{len(node.entries)} names given; wanted: {self.at_most} at most")
        values: dict[str, object] = {}
        taken = () if self.other_words is None else (*self.other_words, *CONSTANTS)
        if taken:
            context.defined[str(path[-1])] = {name: entry.node for name, entry in node.entries.items()}
        for name, entry in node.entries.items():
            inner = (*path, name)
            context.report.put(inner, entry.place)
            if entry.implied:
                known = [other for other, its in node.entries.items() if not its.implied]
                message = f"the case has no {self.thing} {quoted(name)}; it has: {', '.join(known) or 'none'}"
                context.report.fault(inner, message + did_you_mean(name, known), entry.place)
            elif not (self.any_name or _NAME.fullmatch(name)):
                message = f"{quoted(name)} is not a name; use letters, digits, _ and -, 64 at most"
                context.report.fault(inner, message, entry.place)
            else:
                values[name] = self.spec.read(entry.node, inner, context)
            if name in taken:
                message = f"{quoted(name)} is no name here: these words mean something else: {', '.join(taken)}"
                context.report.fault(inner, message)
        return values


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
