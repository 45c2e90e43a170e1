"""Every key of the case format in words, made of the same specs that read a case."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from crackgrow.case import schema as specs
from crackgrow.case.format import CASE
from crackgrow.case.outline_file import OutlineFile
from crackgrow.case.references import Definitions, Reference
from crackgrow.case.regions import LengthOrAngle
from crackgrow.case.scalars import Bounds, Choice, Integer, Number, Quantity, Spec, Switch, Text, WordOr
from crackgrow.case.units import UNITS, Units

NAME: Final = "NAME"  # stands for a name of the user's choice
SHORT: Final = 20  # letters of a kind: in a list of some it is repeated
NUMBER: Final = "N"  # stands for the number of an item of a list, from 0


@dataclass(frozen=True, slots=True)
class Key:
    """What is to be known of a key."""

    name: str  # dotted, such as cracks.NAME.path.length
    doc: str  # a line on what it means
    kind: str  # of its value
    units: str  # that it may have, and what a bare number means
    default: str
    allowed: str  # values, with a few words on each; empty where the kind says all
    like: str = ""  # the key before it that takes the same mapping


@dataclass(frozen=True, slots=True)
class _Value:
    """What a spec takes."""

    kind: str
    units: str = ""
    allowed: str = ""


def case_keys(spec: Spec = CASE) -> list[Key]:
    """All keys below a spec, each after the one that it belongs to."""
    known: dict[int, tuple[str, str]] = {}
    return list(_keys(spec, "", known))


def _keys(spec: Spec, before: str, known: dict[int, tuple[str, str]]) -> Iterator[Key]:
    for name, field in _fields(spec):
        full = before + name
        inner = _core(field.spec)
        step = _step(field.spec)
        first, its_step = known.setdefault(id(inner), (full, step)) if inner is not None else (full, step)
        same = first if step == its_step else f"{first}{its_step}".rstrip(".")
        like, value = "" if first == full else same, _value(field.spec)
        yield Key(full, field.doc, value.kind, value.units, _default(field), value.allowed, like)
        if inner is not None:
            yield from _keys(inner, full + step, known)


def _fields(spec: Spec) -> list[tuple[str, specs.Field]]:
    """The keys of a mapping, or of all forms of one, each once; what every form takes comes last."""
    forms = spec.forms if isinstance(spec, specs.OneOf) else (spec,) if isinstance(spec, specs.Mapping) else ()
    found: dict[str, specs.Field] = {}
    for form in forms:
        for name, field in form.fields.items():
            if field.offered:
                found.setdefault(name, field)
    if len(forms) == 1:
        return list(found.items())
    return sorted(found.items(), key=lambda item: all(item[0] in form.fields for form in forms))


def _core(spec: Spec) -> Spec | None:
    """The mapping inside of a spec, or None."""
    if isinstance(spec, specs.Components):
        return spec.mapping
    inner = getattr(spec, "spec", None)
    return spec if isinstance(spec, specs.Mapping | specs.OneOf) else inner and _core(inner)


def _step(spec: Spec) -> str:
    """What stands between a key and those of the mapping inside of it."""
    here = f".{NAME}" if isinstance(spec, specs.Named) else f".{NUMBER}" if isinstance(spec, specs.ListOf) else ""
    return here + (_step(spec.spec) if hasattr(spec, "spec") else ".")


def _default(field: specs.Field) -> str:
    if field.default is specs.REQUIRED:
        return "required"
    if field.default is specs.OPTIONAL:
        return "may be left out"
    if field.default is specs.BY_PARTS:
        return "that of its keys"
    if isinstance(field.default, specs.Same):
        return f"that of {field.default.key}"
    return json.dumps(field.default, ensure_ascii=False).replace('"', "") or "empty"


def _value(spec: Spec) -> _Value:
    match spec:
        case specs.Mapping():
            return _Value(f"{_value(spec.fields[spec.short].spec).kind}, or mapping" if spec.short else "mapping")
        case specs.OneOf(forms):
            short = [f"{_value(form).kind}" for form in forms if form.short]
            return _Value((short or ["mapping"])[0], allowed=f"with {' or '.join(form.form() for form in forms)}")
        case specs.Converted(inner) | Definitions(inner):
            return _value(inner)
        case Reference(_, where, inner):
            value = _value(inner)
            return _Value(f"{value.kind}, or a name from {where}", value.units, value.allowed)
        case specs.Components():
            listed = _value(spec.listing)
            return _Value(f"{listed.kind}, or mapping", listed.units, listed.allowed)
        case specs.Named(thing, inner):
            value = _value(inner)
            return _Value(f"{thing} by name", value.units, "" if _core(inner) else f"each: {value.kind}")
        case specs.ListOf(inner, length):
            value = _value(inner)
            kind = f"list of {length}, each {value.kind}" if length else f"list, each {value.kind}"
            if length and len(value.kind) <= SHORT:
                kind = f"[{', '.join([value.kind] * length)}]"
            return _Value(kind, value.units, value.allowed)
        case specs.OneOrList(inner):
            value = _value(inner)
            return _Value(f"{value.kind}, or list of them", value.units, value.allowed)
        case WordOr(words, inner):
            value = _value(inner)
            first = _value(Choice(words, getattr(spec, "docs", ())))
            return _Value(
                f"word or {value.kind}", value.units, ", or ".join(filter(None, (first.allowed, value.allowed)))
            )
    return _scalar(spec)


def _scalar(spec: Spec) -> _Value:
    match spec:
        case Text():
            return _Value("text")
        case Choice(words, docs):
            told = [f"`{word}`: {doc}" for word, doc in zip(words, docs, strict=True)] if docs else []
            return _Value("word", "", "; ".join(told or [f"`{word}`" for word in words]))
        case Switch():
            return _Value("true or false")
        case Number(bounds, multiple_of):
            grid = f", in steps of {multiple_of:g}" if multiple_of else ""
            return _Value("number", "", _limits(bounds) + grid)
        case Integer(bounds):
            return _Value("whole number", "", _limits(bounds))
        case Quantity(kind, bounds):
            return _Value(kind, _units(kind), _limits(bounds))
        case LengthOrAngle():
            return _Value("length, or angle on an arc", f"{_units('length')}; on an arc {_units('angle')}")
        case OutlineFile():
            return _Value("file name", "", f"ends in {', '.join(spec.endings)}")
    units = getattr(spec, "kind", "")  # of a spec that this module need not know
    return _Value(spec.describe(), _units(units) if units in UNITS else "")


def _units(kind: str) -> str:
    """Units of a quantity, and the one of a bare number where the case chooses it."""
    listed = ", ".join(UNITS[kind])
    return f"{listed}; bare: that of units.{kind}" if hasattr(Units(), kind) else listed


def _limits(bounds: Bounds) -> str:
    return bounds.describe().strip()
