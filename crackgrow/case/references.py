"""Things that are written once, under a name, and referred to by it: materials and laws of contact."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass
from typing import Final

from crackgrow.case.reader import Node, Scalar
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.scalars import INVALID, Context, Definition, Spec, WordOr
from crackgrow.case.schema import Named

CONSTANTS: Final = ("true", "false", "null")  # of YAML


@dataclass(frozen=True, slots=True)
class Definitions:
    """Named things that other keys refer to."""

    spec: Named
    words: tuple[str, ...] = ()  # that mean something else where a name is taken

    def describe(self) -> str:
        return self.spec.describe()

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the things by name, and note them for those who refer to them."""
        values = self.spec.read(node, path, context)
        known = context.defined.setdefault(self.spec.thing, {})
        for name, value in values.items() if isinstance(values, dict) else ():
            key = (*path, name)
            if name in (*self.words, *CONSTANTS):
                listed = ", ".join((*self.words, *CONSTANTS))
                context.report.fault(key, f"{quoted(name)} is no name here: these words mean something else: {listed}")
            inside = {k[len(key) :]: place for k, place in context.report.places.items() if k[: len(key)] == key}
            known[name] = Definition(value, context.report.sound(*key), inside)
        return values


@dataclass(frozen=True, slots=True)
class Reference:
    """A thing that is written out, or the name of one that is defined; the value is the thing."""

    thing: str  # what Definitions.named calls it
    where: str  # the key that holds the definitions
    spec: Spec  # of what is written out

    def describe(self) -> str:
        return f"{self.spec.describe()}, or a name from `{self.where}`"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the thing; faults that are found in it later stand in the lines of its definition."""
        words = self.spec.words if isinstance(self.spec, WordOr) else ()
        if not isinstance(node, Scalar) or node.is_null or node.text in words:
            return self.spec.read(node, path, context)
        known = context.defined.get(self.thing, {})
        if node.text not in known:
            has = f"`{self.where}` has: {', '.join(known) or 'none'}{did_you_mean(node.text, [*known, *words])}"
            return context.refused(path, f"{quoted(node.text)} given; wanted: {self.describe()}; {has}")
        found = known[node.text]
        if not found.sound:
            context.report.doubt(path)  # its faults are reported where it is defined
            return INVALID
        for inner, place in found.places.items():
            if inner:
                context.report.put((*path, *inner), place)
        return deepcopy(found.value)
