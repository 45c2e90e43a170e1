"""Fields of the model as keys of the case format, and the way from one to the other.

A field says with its type, and beside it in `Annotated`, what its key takes and means. Reader, JSON Schema and
documentation take that from `keys_of`, `made` fills the fields from what was read, and `written` goes back.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from typing import Any, Final, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from crackgrow.case.formula import OrFormula, component_of
from crackgrow.case.references import Reference
from crackgrow.case.scalars import Choice, Integer, Number, Quantity, Spec, Switch, Text, WordOr
from crackgrow.case.schema import BY_PARTS, OPTIONAL, REQUIRED, Components, Field, ListOf, Mapping
from crackgrow.case.shapes import Resolved, frozen

T = TypeVar("T")

AS_FIELD: Final = object()


@dataclass(frozen=True, slots=True)
class Doc:
    """What the case format says of a field beside its type, and where the key differs from the field."""

    text: str  # one line for the user
    words: tuple[str, ...] = ()  # a line about each word of a Literal
    key: str = ""  # its name, if it is another one
    default: object = AS_FIELD  # if it is another one: a plain SI value, OPTIONAL, or `Same`
    offered: bool = True
    also: tuple[str, ...] = ()
    drawn: bool = False  # whether the field follows from the geometry, and does not tell the key
    short: bool = False  # whether a word in place of the whole mapping stands for this key


@dataclass(frozen=True, slots=True)
class ByName:
    """That a value may also be the name of one that is defined elsewhere, or a word."""

    thing: str
    where: str  # the key that holds the definitions
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Declared:
    """A field of a class that is a key of the format."""

    name: str  # of the field
    key: str
    kinds: tuple[Any, ...]  # types of its values
    field: Field
    drawn: bool
    short: bool

    @property
    def spec(self) -> Spec:
        """What the key takes; a name stands for what is written out."""
        return self.field.spec.spec if isinstance(self.field.spec, Reference) else self.field.spec

    @property
    def word_for_none(self) -> str | None:
        """The word that stands for None."""
        spec = self.spec
        return spec.words[0] if isinstance(spec, WordOr) and types.NoneType in self.kinds else None


@cache
def declared(cls: Any) -> tuple[Declared, ...]:
    """The fields of a dataclass that are keys, in their order."""
    hints, found = get_type_hints(cls, include_extras=True), []
    for part in fields(cls):
        said = getattr(hints[part.name], "__metadata__", ())
        doc = next((item for item in said if isinstance(item, Doc)), None)
        if doc is None:
            continue
        hint = hints[part.name].__origin__
        kinds = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
        field = Field(_spec_of(kinds, doc, said), doc.text, doc.default, doc.offered, doc.also)
        item = Declared(part.name, doc.key or part.name, kinds, field, doc.drawn, doc.short)
        if doc.default is AS_FIELD:
            item = replace(item, field=replace(field, default=_default_of(item, part.default)))
        found.append(item)
    return tuple(found)


def keys_of(cls: Any, last: str = "") -> dict[str, Field]:
    """The keys that the fields of a dataclass are; one of them may come last."""
    keys = {item.key: item.field for item in declared(cls)}
    return {**{key: field for key, field in keys.items() if key != last}, **({last: keys[last]} if last else {})}


@cache
def mapping_of(cls: Any) -> Mapping:
    """The mapping that a dataclass is in the format."""
    return Mapping(keys_of(cls), short=next((item.key for item in declared(cls) if item.short), ""))


def made(cls: Callable[..., T], values: Resolved, **others: object) -> T:
    """An instance from the values of its keys, sound and in SI; `others` are fields that they do not tell."""
    told = [item for item in declared(cls) if item.key in values or types.NoneType in item.kinds]
    own = {item.name: _made(item, values.get(item.key)) for item in told if item.name not in others}
    return cls(**own, **others)


def written(instance: Any) -> Resolved:
    """The values of the keys of an instance; those that may be left out are, where there is nothing to tell."""
    cls: Any = type(instance)
    items = [(item, getattr(instance, item.name)) for item in declared(cls) if not item.drawn]
    return {item.key: _written(item, value) for item, value in items if _is_told(item, value)}


def _is_told(item: Declared, value: Any) -> bool:
    """Whether a key stands for a value: left out are None without a word, and a number that the key does not take."""
    if value is None:
        return item.word_for_none is not None
    return not isinstance(item.spec, Quantity) or item.spec.bounds.hold(value)


def _spec_of(kinds: tuple[Any, ...], doc: Doc, said: tuple[Any, ...]) -> Spec:
    """What a key takes: what is said beside the type of its field, else what that says alone."""
    by_name = next((item for item in said if isinstance(item, ByName)), None)
    spec: Spec = next((item for item in said if item not in (doc, by_name)), None) or _spec_by_type(kinds, doc)
    if by_name is None:
        return spec
    return Reference(by_name.thing, by_name.where, WordOr(by_name.words, spec) if by_name.words else spec)


def _spec_by_type(kinds: tuple[Any, ...], doc: Doc) -> Spec:
    kind: Any = next(kind for kind in kinds if kind is not types.NoneType)
    if get_origin(kind) is Literal:
        return Choice(get_args(kind), doc.words)
    if is_dataclass(kind):
        cls: Any = kind
        return mapping_of(cls)
    plain: dict[Any, Spec] = {str: Text(), bool: Switch(), int: Integer(), float: Number()}
    return plain[kind]


def _default_of(item: Declared, default: Any) -> object:
    if default is MISSING:
        return REQUIRED
    if is_dataclass(default):
        return BY_PARTS
    return (item.word_for_none or OPTIONAL) if default is None else _written(item, default)


def _made(item: Declared, value: Any) -> Any:
    """The value of a field from that of its key."""
    spec: Any = item.spec
    cls: Any = next((kind for kind in item.kinds if is_dataclass(kind)), None)
    if value is None or (isinstance(value, str) and value == item.word_for_none):
        return None
    if isinstance(value, dict) and cls is not None:
        return made(cls, value)
    if isinstance(spec, Mapping):  # of keys that are no fields
        parts = tuple(value[key] for key in spec.fields)
        return parts if len(parts) > 1 else parts[0]
    if isinstance(spec, Choice) and bool in item.kinds:
        return value == spec.words[1]
    if isinstance(spec, OrFormula):
        return component_of(value)
    if isinstance(spec, Components):
        parts = tuple(value.get(key) for key in spec.mapping.fields) if isinstance(value, dict) else tuple(value)
        return tuple(None if part is None else component_of(part) for part in parts)
    if isinstance(spec, ListOf):
        if any(get_origin(kind) is np.ndarray for kind in item.kinds):
            return frozen(value)
        return tuple(component_of(part) if isinstance(spec.spec, OrFormula) else part for part in value)
    return value


def _written(item: Declared, value: Any) -> object:
    """The value of a key from that of its field."""
    spec: Any = item.spec
    if value is None:
        return item.word_for_none
    if is_dataclass(value) and not callable(value):
        return written(value)
    if isinstance(spec, Mapping):
        return dict(zip(spec.fields, value if isinstance(value, tuple) else (value,), strict=True))
    if isinstance(spec, Choice) and isinstance(value, bool):
        return spec.words[value]
    if isinstance(spec, Components) and not spec.as_list:
        parts = zip(spec.mapping.fields, value, strict=True)
        return {key: _text_or_number(part) for key, part in parts if part is not None}
    return [_text_or_number(part) for part in value] if isinstance(value, tuple) else _text_or_number(value)


def _text_or_number(value: Any) -> object:
    """A value as it is, a formula as its text."""
    return str(getattr(value, "text", value)) if callable(value) else value
