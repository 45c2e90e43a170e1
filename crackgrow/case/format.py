"""The case format: specs that read what `format.yaml` declares, and the way from what they read to a model and back.

The text of the format says how it is written; other files, such as those of sweeps, are declared in the same way.
"""

from __future__ import annotations

import json
import re
import types
from collections.abc import Callable
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from pathlib import Path as FilePath
from typing import Any, Final, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
import yaml

from crackgrow.arrays import frozen
from crackgrow.case.drawings import File
from crackgrow.case.formula import OrFormula
from crackgrow.case.overrides import OfFile
from crackgrow.case.reader import Listing, Node, Scalar, Table
from crackgrow.case.regions import PlaceOnEdge
from crackgrow.case.report import Path
from crackgrow.case.scalars import PLAIN, SHARE, WHOLE, Context, Measured, Reference, Spec, Switch, Text, Words
from crackgrow.case.schema import MOST_ITEMS, OPTIONAL, REQUIRED, Field, ListOf, Mapping, Named, OneOf, Same
from crackgrow.case.shapes import Resolved
from crackgrow.case.units import UNITS, Units, parse_quantity

T = TypeVar("T")

GIVEN: Final = "given"  # the field of a class that holds the keys that are none of its fields
TEXTS: Final[dict[str, Spec]] = {"text": Text(), "text or empty": Text(may_be_empty=True), "switch": Switch()}


@dataclass(frozen=True, slots=True, eq=False)
class Format:
    """A format.

    declared: its parts, as a YAML text has them
    kinds: what keys take besides, by name
    wrapped: for a part what becomes of the spec of its mapping or forms
    """

    declared: AnyMapping[str, Any]
    kinds: AnyMapping[str, Spec]
    wrapped: AnyMapping[str, Callable[[Any], Spec]]
    _specs: dict[str, Spec] = field(default_factory=dict)  # those that were asked for, by what the text says
    _keys: dict[Any, dict[str, Field]] = field(default_factory=dict)  # the same, of classes

    def part(self, name: str) -> Any:
        """The spec of a part, one for all keys that take it."""
        if name not in self._specs:
            said = self.declared[name]
            if isinstance(said, list):
                forms = (self.part(form) if isinstance(form, str) else self._mapping(form, "") for form in said)
                spec: Spec = OneOf(tuple(forms), name)
            else:
                is_mapping = isinstance(said, dict) and isinstance(next(iter(said.values())), list)
                spec = self._mapping(said, name) if is_mapping else self.spec(said)
            self._specs[name] = self.wrapped[name](spec) if name in self.wrapped else spec
        return self._specs[name]

    def _mapping(self, said: dict[str, list[Any]], part: str) -> Mapping:
        short = [key for key, (*_, more) in said.items() if isinstance(more, dict) and "short" in more]
        fields = {key: self._field(*of_key) for key, of_key in said.items()}
        return Mapping(fields, short=short[0] if short else "", part=part)

    def _field(
        self, takes: object, doc: str, default: object = "required", more: AnyMapping[str, Any] | None = None
    ) -> Field:
        spec, more = self.spec(takes), more or {}
        if isinstance(default, str) and default.startswith("same as "):
            default = Same(default.removeprefix("same as "))
        elif isinstance(default, str):
            default = {"required": REQUIRED, "optional": OPTIONAL}.get(default, default)
        return Field(spec, doc, default, not more.get("hidden"), tuple(more.get("also", ())), more.get("field", ""))

    def spec(self, said: Any) -> Spec:
        """What a key takes; one spec for all keys that say the same in a text."""
        if isinstance(said, dict):
            words = tuple(word for word in said if word != "or")
            docs = tuple(said[word] for word in words) if any(said[word] for word in words) else ()
            other, _, where = said.get("or", "").partition(" or a name from ")
            spec = Words(words, docs, self.spec(other) if other else None)
            return Reference(where, spec) if where else spec
        if said in self.declared:
            part: Spec = self.part(said)
            return part
        if said not in self._specs:
            self._specs[said] = {**TEXTS, **self.kinds}.get(said) or self._composed(said)
        return self._specs[said]

    def _composed(self, said: str) -> Spec:
        for pattern, make in _COMPOSED.items():
            if match := re.fullmatch(pattern, said):
                return make(self, **match.groupdict())
        return _measured(said)

    def name(self, spec: Any) -> str:
        """How the text calls a spec; empty where it has no word for it."""
        return next((name for name, known in self._specs.items() if known == spec), "")

    def keys_of(self, cls: Any) -> dict[str, Field]:
        """The keys of the part, or of all forms, that a class stands for."""
        if cls in self._keys:
            return self._keys[cls]
        parts = (self.part(name) for name in self.declared if name.split()[0] == cls.__name__)
        found = {key: field for part in parts for key, field in part.fields.items()}
        return self._keys.setdefault(cls, found)

    def made(self, cls: Callable[..., T], values: Resolved, **others: object) -> T:
        """An instance from the values of its keys, sound and in SI; `others` are fields that these do not tell."""
        own, given, kinds = dict(others), {}, kinds_of(cls)
        for key, its in self.keys_of(cls).items():
            name = its.field or key
            if name not in kinds and key in values:
                given[key] = values[key]
            elif name not in others and name in kinds and (key in values or types.NoneType in kinds[name]):
                own[name] = self._made(_plain(its.spec), kinds[name], values.get(key))
        return cls(**own, **({GIVEN: given} if GIVEN in kinds else {}))

    def _made(self, spec: Any, kinds: tuple[Any, ...], value: Any) -> Any:
        """The value of a field from that of its key."""
        cls: Any = next((kind for kind in kinds if is_dataclass(kind)), None)
        if value is None or (isinstance(value, str) and value == _word_for_none(spec, kinds)):
            return None
        if isinstance(value, dict) and cls is not None:
            return self.made(cls, value)
        if isinstance(spec, Mapping) and spec.read_as:
            return tuple(map(value.get, spec.fields) if isinstance(value, dict) else value)
        if isinstance(spec, Mapping):  # of keys that are no fields
            parts = tuple(value[key] for key in spec.fields)
            return parts if len(parts) > 1 else parts[0]
        if isinstance(spec, Words) and bool in kinds:
            return value == spec.words[1]
        if isinstance(spec, ListOf):
            return frozen(value) if any(get_origin(kind) is np.ndarray for kind in kinds) else tuple(value)
        return value

    def written(self, instance: Any) -> Resolved:
        """The values of the keys of an instance; those that may be left out are, where there is nothing to tell."""
        cls: Any = type(instance)
        kinds, given, found = kinds_of(cls), getattr(instance, GIVEN, {}), {}
        for key, its in self.keys_of(cls).items():
            name, spec = its.field or key, _plain(its.spec)
            if key in given:
                found[key] = given[key]
            elif name in kinds:
                value, word = getattr(instance, name), _word_for_none(spec, kinds[name])
                nothing = value is None or (isinstance(value, tuple) and not value)
                if (nothing and its.default is OPTIONAL) or (value is None and word is None):
                    continue
                if isinstance(spec, Measured) and spec.kind in UNITS and not spec.holds(value):
                    continue  # nothing, said by a quantity that the key does not take
                found[key] = word if value is None else self._written(spec, value)
        return found

    def _written(self, spec: Any, value: Any) -> object:
        """The value of a key from that of its field."""
        if is_dataclass(value) and not callable(value):
            return self.written(value)
        if isinstance(spec, Mapping) and spec.read_as is dict:
            parts = zip(spec.fields, value, strict=True)
            return {key: _text_or_number(part) for key, part in parts if part is not None}
        if isinstance(spec, Mapping) and not spec.read_as:
            return dict(zip(spec.fields, value if isinstance(value, tuple) else (value,), strict=True))
        if isinstance(spec, Words) and isinstance(value, bool):
            return spec.words[value]
        if isinstance(spec, Named):
            return {item.name: self.written(item) for item in value}
        if isinstance(value, tuple):
            return [self._written(None, part) for part in value]
        return _text_or_number(value)


def format_of(text: str, kinds: AnyMapping[str, Spec], wrapped: AnyMapping[str, Callable[[Any], Spec]]) -> Format:
    """The format of a YAML text."""
    return Format(yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader)), kinds, wrapped)


_COMPOSED: Final[dict[str, Callable[..., Spec]]] = {
    r"unit of (?P<kind>\w+)": lambda _, kind: Words(tuple(UNITS[kind])),
    r"definitions of (?P<thing>\w+)( but (?P<words>.+?))?: (?P<inner>.+?)(, at most (?P<most>\d+))?": (
        lambda its, thing, words, inner, most: Named(
            thing, its.spec(inner), int(most or MOST_ITEMS), other_words=tuple(words.split(", ")) if words else ()
        )
    ),
    r"(?P<thing>\w+) by (?P<free>any )?name: (?P<inner>.+?)(, at most (?P<most>\d+))?": (
        lambda its, thing, free, inner, most: Named(thing, its.spec(inner), int(most or MOST_ITEMS), bool(free))
    ),
    r"(?P<length>list|\d+) of (?P<inner>.+?)(, at most (?P<most>\d+))?": (
        lambda its, length, inner, most: ListOf(
            its.spec(inner), None if length == "list" else int(length), int(most or MOST_ITEMS)
        )
    ),
    r"one or more (?P<inner>.+)": lambda its, inner: ListOf(its.spec(inner), alone=True),
    r"(?P<inner>.+) or a name from (?P<where>\w+)": lambda its, inner, where: Reference(where, its.spec(inner)),
}
"""How kinds are made of others."""


def _measured(said: str) -> Spec:
    """The spec of a number such as "angle >= 0 and < 90"."""
    found = re.fullmatch(r"([a-z ]+?)((?: (?:and )?[<>]=? [-.\d]+)*)(?: in steps of (\S+))?((?:, .+)?)", said)
    kind, limits, step, note = found.groups() if found else ("", "", None, "")
    if kind in (PLAIN, WHOLE, SHARE, *UNITS):
        bounds = tuple((sign, json.loads(limit)) for sign, limit in re.findall(r"([<>]=?) (\S+)", limits))
        return Measured(kind, bounds, float(step) if step else None, note)
    raise ValueError(f"{said!r} is nothing that a key can take")


@cache
def kinds_of(cls: Any) -> dict[str, tuple[Any, ...]]:
    """The types of values that each field of a dataclass takes."""
    hints = get_type_hints(cls)
    unions = (Union, types.UnionType)
    return {
        part.name: get_args(hint) if get_origin(hint := hints[part.name]) in unions else (hint,) for part in fields(cls)
    }


def _plain(spec: Spec) -> Spec:
    """What a key takes; a name stands for what is written out."""
    return spec.spec if isinstance(spec, Reference) else spec


def _word_for_none(spec: Spec, kinds: tuple[Any, ...]) -> str | None:
    """The word that stands for None."""
    return spec.words[0] if isinstance(spec, Words) and types.NoneType in kinds else None


def _text_or_number(value: Any) -> object:
    """A value as it is, a formula as its text."""
    return str(getattr(value, "text", value)) if callable(value) else value


MINIMAL: Final = "minimal"
DEFINITIONS: Final = ("materials", "laws")  # of the case; resolved cases hold none


@dataclass(frozen=True, slots=True)
class Point(ListOf):
    """Both coordinates of a place, from the origin of the case."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return them in m."""
        values = ListOf.read(self, node, path, context)
        if context.units.origin is None or not isinstance(node, Listing) or not context.report.sound(*path):
            return values
        texts = (item.text for item in node.items if isinstance(item, Scalar))
        return [parse_quantity(text, "length", context.units, axis) for axis, text in enumerate(texts)]


@dataclass(frozen=True, slots=True)
class UnitsOfCase(Mapping):
    """What bare numbers mean in what is read after it."""

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Return the units of lengths and stresses, and the origin in m."""
        values: Any = Mapping.read(self, node, path, context)
        if context.report.sound(*path) and isinstance(node, Table):
            context.units = Units(values["length"], values["stress"])
            if "origin" in values:  # its bare numbers are in the unit that stands beside it
                key = (*path, "origin")
                values["origin"] = self.fields["origin"].spec.read(node.entries["origin"].node, key, context)
                if context.report.sound(*key):
                    context.units = replace(context.units, origin=tuple(values["origin"]))
        return values


FORMAT: Final[Format] = format_of(
    FilePath(__file__).with_name("format.yaml").read_text(encoding="utf-8"),
    kinds={
        "point": Point(Measured("length"), 2),
        "place on an edge": PlaceOnEdge(),
        "file": File(),
        "file of cracks": File(of_cracks=True),
        "formula of length": OrFormula("length"),
        "formula of stress": OrFormula("stress"),
        "base file": OfFile("a case file"),
        "settings of the base": OfFile("a mapping"),
    },
    wrapped={
        "Units": lambda mapping: UnitsOfCase(mapping.fields, part=mapping.part),
        "Displacement": lambda mapping: replace(mapping, read_as=dict),
        "Traction": lambda mapping: replace(mapping, read_as=list),
    },
)

CASE: Final[Mapping] = FORMAT.part("Case")
