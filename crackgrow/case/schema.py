"""Specs of lists, mappings and things under names: the case format is one tree of specs, `format.CASE`."""

from __future__ import annotations

import re
from collections.abc import Mapping as AnyMapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Final

from crackgrow.case.reader import Entry, Listing, Node, Scalar, Table
from crackgrow.case.report import Path, did_you_mean, dotted, explained, nearest, quoted
from crackgrow.case.scalars import INVALID, Context, Numeric, Words, refuse

MOST_ITEMS: Final = 1000  # of a list, unless it says otherwise: beyond, checks take too long
CONSTANTS: Final = ("true", "false", "null")  # of YAML
SHOWN_UNKNOWN: Final = 50  # of more keys that a mapping does not take only the number is told

REQUIRED: Final = object()  # the key must be given
OPTIONAL: Final = object()  # the key may be left out and then stays out

_NAME: Final = re.compile(r"\w[\w-]{0,63}")


@dataclass(frozen=True, slots=True)
class Same:
    """A default: the value of a key before it."""

    key: str


@dataclass(frozen=True, slots=True)
class Field:
    """One key of a mapping."""

    spec: Any
    doc: str  # one line for the user
    default: object = REQUIRED  # a plain SI value, {} of a mapping, `Same`, REQUIRED, OPTIONAL
    offered: bool = True  # whether messages name the key; else the program writes it
    also: tuple[str, ...] = ()  # other spellings that are taken for the key
    field: str = ""  # of the model that it is, if that has another name


@dataclass(frozen=True, slots=True)
class ListOf:
    """A list of values of one kind."""

    spec: Any
    length: int | None = None  # None: any up to `at_most`
    at_most: int = MOST_ITEMS
    alone: bool = False  # whether one item may stand in place of the list

    def describe(self) -> str:
        if self.alone:
            return f"{self.spec.describe()}, or a list of them"
        return f"a list{'' if self.length is None else f' of {self.length}'}: each item {self.spec.describe()}"

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a list; faulty items are INVALID and keep their place."""
        if not isinstance(node, Listing) and self.alone:
            return [self.spec.read(node, path, context)]
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
class Mapping:
    """A mapping with known keys.

    fields: what each key takes, in the order of the resolved case.
    short: the key that a value stands for in place of the mapping; empty: none.
    part: its name in the format.
    read_as: of a vector what it becomes: a list of all components, or a mapping that lacks some, but not all.
    """

    fields: AnyMapping[str, Field]
    short: str = ""
    part: str = ""
    read_as: type | None = None

    @property
    def other(self) -> Any:
        """The spec of what may be given in place of the mapping, if there is something."""
        if self.read_as:
            return ListOf(next(iter(self.fields.values())).spec, len(self.fields))
        return self.fields[self.short].spec if self.short else None

    def describe(self) -> str:
        word = f"{self.other.describe()}, or " if self.other else ""
        return f"{word}a mapping of {', '.join(self.offered())}"

    def offered(self) -> list[str]:
        """The keys that are named to users."""
        return [key for key, field in self.fields.items() if field.offered]

    def form(self) -> str:
        """Write the keys that tell this mapping from others: those that must be given, or all if none must."""
        return f"{{{', '.join(key for key in self.fields if key in (self.required() or self.fields))}}}"

    def required(self) -> set[str]:
        """The keys that must be given."""
        return {key for key, field in self.fields.items() if field.default is REQUIRED}

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return a dict with the keys in the order of `fields`; faulty values are INVALID or left out."""
        if self.read_as and isinstance(node, Listing):
            listed: Any = self.other.read(node, path, context)
            if self.read_as is list or listed is INVALID:
                return listed
            return dict(zip(self.fields, listed, strict=True))
        stands_alone = Scalar if self.short and isinstance(self.other, Numeric | Words) else Listing
        if self.short and isinstance(node, stands_alone) and not (isinstance(node, Scalar) and node.is_null):
            node = Table({self.short: Entry(node.place, node)}, node.place)
        if not isinstance(node, Table):
            return refuse(node, self.describe(), path, context)
        node = _respelt(node, self.fields)
        misspelt = self._report_unknown(node, path, context)
        values: dict[str, object] = {}
        for key, wanted in self.fields.items():
            inner = (*path, key)
            if key in node.entries:
                context.report.put(inner, node.entries[key].place)
                values[key] = wanted.spec.read(node.entries[key].node, inner, context)
            elif wanted.default is REQUIRED:
                if key in misspelt:
                    context.report.doubt(inner)
                else:
                    context.report.fault(inner, f"missing: {wanted.doc} ({wanted.spec.describe()})")
            elif isinstance(wanted.default, Same):
                values[key] = values.get(wanted.default.key, INVALID)
            elif isinstance(wanted.spec, Mapping) and wanted.default is not OPTIONAL:
                values[key] = wanted.spec.read(Table({}, node.place), inner, context)
            elif wanted.default is not OPTIONAL:
                values[key] = deepcopy(wanted.default)
        if self.read_as is dict and not any(key in self.fields for key in node.entries):
            context.report.fault(path, f"needs at least one of {', '.join(self.fields)}")
        return list(values.values()) if self.read_as is list else values

    def _report_unknown(self, node: Table, path: Path, context: Context) -> set[str]:
        """Report keys that the mapping does not take; return the keys that were probably meant."""
        guesses: set[str] = set()
        unknown = [(key, entry) for key, entry in node.entries.items() if key not in self.fields]
        if len(unknown) > SHOWN_UNKNOWN:
            context.report.fault(path, f"{len(unknown)} unknown keys; allowed: {', '.join(self.offered())}")
            return guesses
        for key, entry in unknown:
            free = [known for known in self.offered() if known not in node.entries]
            meant = [known for known in self.offered() if known.rstrip("s") == key.rstrip("s")]
            if not meant and not explained(key, free):
                inner = [(outer, its.spec) for outer, its in self.fields.items() if isinstance(its.spec, Mapping)]
                meant = [f"{outer}.{key}" for outer, spec in inner if key in spec.offered()]
            hint = f"; did you mean '{meant[0]}'?" if meant else did_you_mean(key, free)
            hint = hint or did_you_mean(key, self.offered())
            message = f"unknown key; allowed: {', '.join(self.offered())}{hint}"
            context.report.fault((*path, key), message, entry.place)
            guesses.add(nearest(key, free) or "")
        return guesses


def _respelt(node: Table, fields: AnyMapping[str, Field]) -> Table:
    """The table with keys in the spelling of `fields`, where it has another one that is taken for it."""
    spellings = {other: key for key, field in fields.items() for other in field.also if key not in node.entries}
    if not spellings.keys() & node.entries.keys():
        return node
    return Table({spellings.get(key, key): entry for key, entry in node.entries.items()}, node.place)


@dataclass(frozen=True, slots=True)
class OneOf:
    """One of several mappings, told apart by the keys that are given."""

    forms: tuple[Mapping, ...]
    part: str = ""  # its name in the format

    @property
    def fields(self) -> AnyMapping[str, Field]:
        """The keys of all forms, each as the first one that has it takes it."""
        found: dict[str, Field] = {}
        for form in self.forms:
            found = {**found, **{key: field for key, field in form.fields.items() if key not in found}}
        return found

    def describe(self) -> str:
        return " or ".join(form.describe() for form in self.forms)

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the value of the form that is given."""
        if isinstance(node, Listing) and (short := [form for form in self.forms if form.short]):
            return short[0].read(node, path, context)
        if not isinstance(node, Table):
            return refuse(node, self.describe(), path, context)
        every = self.fields
        known, node = list(every), _respelt(node, every)
        free = [key for key in known if key not in node.entries]
        given = node.entries.keys() & every.keys()
        may_match = self.forms if given else [form for form in self.forms if not node.entries and not form.required()]
        matches = [form for form in may_match if given <= form.fields.keys()]
        if len(matches) > 1:  # a misspelt key may tell them apart, but never chooses a form alone
            meant = given | ({nearest(key, free) for key in node.entries.keys() - given} - {None})
            matches = [form for form in matches if meant <= form.fields.keys()]
            whole = [form for form in matches if form.required() <= given]  # no other key is wanted
            matches = whole if len(whole) == 1 else matches
        if len(matches) == 1:
            return matches[0].read(node, path, context)
        either = f"give either {' or '.join(form.form() for form in self.forms)}"
        for key, entry in node.entries.items():
            if key not in known:
                allowed = f"allowed: {', '.join(known)}" if given else either
                message = f"unknown key; {allowed}{did_you_mean(key, free)}"
                context.report.fault((*path, key), message, entry.place)
        odd = self._odd(node) if len(given) > 1 and not matches else None
        if odd is None and node.entries and not given:
            context.report.doubt(path)  # that none of its keys is one is told
        elif odd is None:
            context.report.fault(path, either)
        else:
            others = [key for key in node.entries if key in given and key != odd]
            place = node.entries[odd].place
            context.report.put((*path, odd), place)
            message = f"does not go with {', '.join(others)}; {either}"
            if place.line is None and any(entry.place.line for entry in node.entries.values()):  # an override adds it
                message += f"; --set '{dotted(path)}={{{odd}: ...}}' takes the place of all of them"
            context.report.fault((*path, odd), message)
        return INVALID

    def _odd(self, node: Table) -> str | None:
        """The first key that does not go with those before it; those of the file come before those of overrides."""
        fitting = self.forms
        for key in sorted(node.entries, key=lambda key: node.entries[key].place.line is None):
            still = tuple(form for form in fitting if key in form.fields)
            if not still and any(key in form.fields for form in self.forms):
                return key
            fitting = still or fitting
        return None


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
