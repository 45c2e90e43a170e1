"""Specs that are made of others: lists, things under names, vectors, and names that stand for what is defined once."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from crackgrow.case.reader import Listing, Node, Scalar, Table
from crackgrow.case.report import Path, did_you_mean, quoted
from crackgrow.case.scalars import INVALID, Context, Schema, Schemas, Takes, WordOr, refuse
from crackgrow.case.schema import MOST_ITEMS, Mapping, OneOf

CONSTANTS: Final = ("true", "false", "null")  # of YAML
SHORT: Final = 20  # letters of a kind: in a list of some it is repeated

_NAME: Final = re.compile(r"\w[\w-]{0,63}")
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NAMES: Final = {"title": "name", "pattern": rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"}


def core(spec: Any) -> Mapping | OneOf | None:
    """The mapping, or the forms of one, inside of a spec, or None."""
    if isinstance(spec, Mapping | OneOf):
        return spec
    inner = spec.mapping if isinstance(spec, Components) else getattr(spec, "spec", None)
    return core(inner) if inner is not None else None


@dataclass(frozen=True, slots=True)
class Converted:
    """What another spec reads, brought into another form."""

    spec: Any
    convert: Callable[[object, Path, Context], object]

    def describe(self) -> str:
        return str(self.spec.describe())

    def takes(self) -> Takes:
        found: Takes = self.spec.takes()
        return found

    def schema(self, schemas: Schemas) -> Schema:
        return schemas.of(self.spec)

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the converted value, INVALID if any part of it is."""
        value = self.spec.read(node, path, context)
        return self.convert(value, path, context) if context.report.sound(*path) else value


@dataclass(frozen=True, slots=True)
class ListOf:
    """A list of values of one kind."""

    spec: Any
    length: int | None = None  # None: any up to `at_most`
    at_most: int = MOST_ITEMS

    def describe(self) -> str:
        return f"a list{'' if self.length is None else f' of {self.length}'}: each item {self.spec.describe()}"

    def takes(self) -> Takes:
        kind, units, allowed = self.spec.takes()
        if self.length and len(kind) <= SHORT:
            return Takes(f"[{', '.join([kind] * self.length)}]", units, allowed)
        return Takes(f"list of {self.length}, each {kind}" if self.length else f"list, each {kind}", units, allowed)

    def schema(self, schemas: Schemas) -> Schema:
        sized = {"minItems": self.length, "maxItems": self.length} if self.length else {"maxItems": self.at_most}
        return {"type": "array", "items": schemas.of(self.spec), **sized}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a list; faulty items are INVALID and keep their place."""
        if not isinstance(node, Listing):
            return refuse(node, self.describe(), path, context)
        if self.length is not None and len(node.items) != self.length:
            message = f"a list of {len(node.items)} given; wanted: {self.describe()}"
            return context.refused(path, message)
        if len(node.items) > self.at_most:
            return context.refused(path, f"a list of {len(node.items)} given; wanted: {self.at_most} at most")
        values = []
        for index, item in enumerate(node.items):
            context.report.put((*path, index), item.place)
            values.append(self.spec.read(item, (*path, index), context))
        return values


@dataclass(frozen=True, slots=True)
class OneOrList:
    """A single value or a list of them."""

    spec: Any

    def describe(self) -> str:
        return f"{self.spec.describe()}, or a list of them"

    def takes(self) -> Takes:
        kind, units, allowed = self.spec.takes()
        return Takes(f"{kind}, or list of them", units, allowed)

    def schema(self, schemas: Schemas) -> Schema:
        return {"anyOf": [schemas.of(self.spec), ListOf(self.spec).schema(schemas)]}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the value or the list."""
        return (ListOf(self.spec) if isinstance(node, Listing) else self.spec).read(node, path, context)


@dataclass(frozen=True, slots=True)
class Components:
    """A vector as a list [x, y], or as a mapping of x and y; resolved cases hold one of the two forms."""

    mapping: Mapping  # of x and y; one that may be left out can be left out in the mapping alone
    as_list: bool  # the form in resolved cases

    @property
    def listing(self) -> ListOf:
        """The list of all components."""
        return ListOf(next(iter(self.mapping.fields.values())).spec, len(self.mapping.fields))

    def describe(self) -> str:
        return f"{self.listing.describe()}, or {self.mapping.describe()}"

    def takes(self) -> Takes:
        kind, units, allowed = self.listing.takes()
        return Takes(f"{kind}, or mapping", units, allowed)

    def schema(self, schemas: Schemas) -> Schema:
        return {"anyOf": [schemas.of(self.listing), schemas.of(self.mapping)]}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the components, as a list or as a dict."""
        if not isinstance(node, Listing | Table):
            return refuse(node, self.describe(), path, context)
        value = (self.listing if isinstance(node, Listing) else self.mapping).read(node, path, context)
        if self.as_list and isinstance(value, dict):
            return list(value.values())
        if not self.as_list and isinstance(value, list):
            return dict(zip(self.mapping.fields, value, strict=True))
        return value


@dataclass(frozen=True, slots=True)
class Named:
    """Things under names of the user's choice."""

    thing: str
    spec: Any
    at_most: int = MOST_ITEMS
    any_name: bool = False  # whether names are those of another file, whatever they are

    def describe(self) -> str:
        return f"a mapping of names, each a {self.thing}"

    def takes(self) -> Takes:
        kind, units, _ = self.spec.takes()
        return Takes(f"{self.thing} by name", units, "" if core(self.spec) else f"each: {kind}")

    def schema(self, schemas: Schemas) -> Schema:
        names = {} if self.any_name else {"propertyNames": schemas.named("name", lambda: _NAMES)}
        inner = schemas.of(self.spec)
        return {"type": "object", **names, "maxProperties": self.at_most, "additionalProperties": inner}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a dict of the values in file order."""
        if not isinstance(node, Table):
            return refuse(node, self.describe(), path, context)
        if len(node.entries) > self.at_most:
            return context.refused(path, f"{len(node.entries)} names given; wanted: {self.at_most} at most")
        values: dict[str, object] = {}
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
        return values


@dataclass(frozen=True, slots=True)
class Definitions:
    """Named things that other keys refer to."""

    spec: Named
    words: tuple[str, ...] = ()  # that mean something else where a name is taken

    def describe(self) -> str:
        return self.spec.describe()

    def takes(self) -> Takes:
        return self.spec.takes()

    def schema(self, schemas: Schemas) -> Schema:
        return self.spec.schema(schemas)

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the things by name, and note them for those who refer to them."""
        defined = node.entries if isinstance(node, Table) else {}
        context.defined[str(path[-1])] = {name: entry.node for name, entry in defined.items()}
        values = self.spec.read(node, path, context)
        for name in (name for name in defined if name in (*self.words, *CONSTANTS)):
            listed = ", ".join((*self.words, *CONSTANTS))
            message = f"{quoted(name)} is no name here: these words mean something else: {listed}"
            context.report.fault((*path, name), message)
        return values


@dataclass(frozen=True, slots=True)
class Reference:
    """A thing that is written out, or the name of one that is defined; the value is the thing."""

    where: str  # the key that holds the definitions
    spec: Any  # of what is written out

    def describe(self) -> str:
        return f"{self.spec.describe()}, or a name from `{self.where}`"

    def takes(self) -> Takes:
        kind, units, allowed = self.spec.takes()
        return Takes(f"{kind}, or a name from {self.where}", units, allowed)

    def schema(self, schemas: Schemas) -> Schema:
        name = {"title": f"reference (to {self.where})", "type": ["string", "number"], "allOf": [_NAMES]}
        return {"anyOf": [schemas.of(self.spec), schemas.named(f"from {self.where}", lambda: name)]}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the thing; faults that are found in it later stand in the lines of its definition."""
        words = self.spec.words if isinstance(self.spec, WordOr) else ()
        if not isinstance(node, Scalar) or node.is_null or node.text in words:
            found: object = self.spec.read(node, path, context)
            return found
        known = context.defined.get(self.where, {})
        if node.text not in known:
            has = f"`{self.where}` has: {', '.join(known) or 'none'}{did_you_mean(node.text, [*known, *words])}"
            return context.refused(path, f"{quoted(node.text)} given; wanted: {self.describe()}; {has}")
        if not context.report.sound(self.where, node.text):
            context.report.doubt(path)  # its faults are reported where it is defined
            return INVALID
        found = self.spec.read(known[node.text], path, context)
        return found
