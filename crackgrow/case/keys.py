"""Every key of the case format in words, made of the same specs that read a case."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from crackgrow.case.drawings import File
from crackgrow.case.format import CASE
from crackgrow.case.formula import OrFormula
from crackgrow.case.regions import PlaceOnEdge
from crackgrow.case.scalars import SHARE, Measured, Reference, Switch, Text, Words
from crackgrow.case.schema import OPTIONAL, REQUIRED, Field, ListOf, Mapping, Named, OneOf, Same
from crackgrow.case.units import UNITS, Units

NAME: Final = "NAME"  # stands for a name of the user's choice
NUMBER: Final = "N"  # stands for the number of an item of a list, from 0
SHORT: Final = 20  # letters of a kind: in a list of some it is repeated
BY_FORM: Final = "by form"  # the default of a key that belongs to some forms of a mapping, and is required there


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
    again: bool = False  # whether it is a key of such a mapping, which was told before


def case_keys() -> list[Key]:
    """All keys of a case, each after the one that it belongs to."""
    return list(_keys(CASE, "", {}, again=False))


def _keys(spec: Mapping | OneOf, before: str, known: dict[int, tuple[str, str]], again: bool) -> Iterator[Key]:
    """The keys of a mapping, or of all forms of one, each once; what every form takes comes last."""
    forms = spec.forms if isinstance(spec, OneOf) else (spec,)
    of_all = {name: all(name in form.fields for form in forms) for name in spec.fields}
    for name, field in sorted(spec.fields.items(), key=lambda item: of_all[item[0]]):
        if not field.offered:
            continue
        full = before + name
        inner = core(field.spec)
        step = _step(field.spec)
        first, its_step = known.setdefault(id(inner), (full, step)) if inner is not None else (full, step)
        same = first if step == its_step else f"{first}{its_step}".rstrip(".")
        default = _default(field) if of_all[name] or field.default is not REQUIRED else BY_FORM
        like, takes = "" if first == full else same, _takes(field.spec)
        yield Key(full, field.doc, takes.kind, takes.units, default, takes.allowed, like, again)
        if inner is not None:
            yield from _keys(inner, full + step, known, again or bool(like))


def _step(spec: Any) -> str:
    """What stands between a key and those of the mapping inside of it."""
    is_list = isinstance(spec, ListOf) and not spec.alone
    here = f".{NAME}" if isinstance(spec, Named) else f".{NUMBER}" if is_list else ""
    return here + (_step(spec.spec) if hasattr(spec, "spec") else ".")


def _default(field: Field) -> str:
    if field.default is REQUIRED:
        return "required"
    if field.default is OPTIONAL:
        return "may be left out"
    if isinstance(field.spec, Mapping):
        return "that of its keys"
    if isinstance(field.default, Same):
        return f"that of {field.default.key}"
    return json.dumps(field.default, ensure_ascii=False).replace('"', "") or "empty"


class _Takes(NamedTuple):
    """What a spec takes."""

    kind: str
    units: str = ""
    allowed: str = ""


def _takes(spec: Any) -> _Takes:
    match spec:
        case ListOf(inner, length):
            kind, units, allowed = _takes(inner)
            if spec.alone:
                return _Takes(f"{kind}, or list of them", units, allowed)
            if length and len(kind) <= SHORT:
                return _Takes(f"[{', '.join([kind] * length)}]", units, allowed)
            return _Takes(f"list of {length}, each {kind}" if length else f"list, each {kind}", units, allowed)
        case Mapping():
            kind, *rest = _takes(spec.other) if spec.other else ("",)
            return _Takes(f"{kind}, or mapping", *(rest if spec.read_as else ())) if kind else _Takes("mapping")
        case OneOf(forms):
            short = [_takes(form).kind for form in forms if form.short]
            return _Takes((short or ["mapping"])[0], "", f"with {' or '.join(form.form() for form in forms)}")
        case Named(thing, inner):
            kind, units, _ = _takes(inner)
            return _Takes(f"{thing} by name", units, "" if core(inner) else f"each: {kind}")
        case Reference(where, inner):
            kind, units, allowed = _takes(inner)
            return _Takes(f"{kind}, or a name from {where}", units, allowed)
        case Words(words, docs, other):
            told = [f"`{word}`: {doc}" for word, doc in zip(words, docs, strict=True)] if docs else []
            listed = "; ".join(told or [f"`{word}`" for word in words])
            if not other:
                return _Takes("word", "", listed)
            kind, units, allowed = _takes(other)
            return _Takes(f"word or {kind}", units, ", or ".join(filter(None, (listed, allowed))))
        case Measured(kind, step=step) if kind != SHARE:
            grid = f", in steps of {step:g}" if step else ""
            return _Takes(kind, units_of(kind) if kind in UNITS else "", spec.limits + grid)
        case OrFormula(kind):
            return _Takes(spec.describe(), units_of(kind))
        case PlaceOnEdge():
            return _Takes("length, or angle on an arc", f"{units_of('length')}; on an arc {units_of('angle')}")
        case File():
            return _Takes("file name", "", f"ends in {', '.join(spec.endings)}")
        case Switch():
            return _Takes("true or false")
        case Text():
            return _Takes("text")
    return _Takes(spec.describe())


def units_of(kind: str) -> str:
    """Units of a quantity, and the one of a bare number where the case chooses it."""
    listed = ", ".join(UNITS[kind])
    return f"{listed}; bare: that of units.{kind}" if hasattr(Units(), kind) else listed


def core(spec: Any) -> Mapping | OneOf | None:
    """The mapping, or the forms of one, inside of a spec, or None."""
    if isinstance(spec, Mapping | OneOf):
        return spec
    inner = getattr(spec, "spec", None)
    return core(inner) if inner is not None else None
