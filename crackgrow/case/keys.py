"""Every key of the case format in words, made of the same specs that read a case."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from crackgrow.case import schema as specs
from crackgrow.case.composed import Named, core
from crackgrow.case.format import CASE

NAME: Final = "NAME"  # stands for a name of the user's choice
NUMBER: Final = "N"  # stands for the number of an item of a list, from 0
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


def case_keys(spec: Any = CASE) -> list[Key]:
    """All keys below a spec, each after the one that it belongs to."""
    return list(_keys(spec, "", {}, again=False))


def _keys(spec: Any, before: str, known: dict[int, tuple[str, str]], again: bool) -> Iterator[Key]:
    forms = spec.forms if isinstance(spec, specs.OneOf) else ()
    for name, field in _fields(spec):
        full = before + name
        inner = core(field.spec)
        step = _step(field.spec)
        first, its_step = known.setdefault(id(inner), (full, step)) if inner is not None else (full, step)
        same = first if step == its_step else f"{first}{its_step}".rstrip(".")
        of_all = all(name in form.fields for form in forms)
        default = _default(field) if of_all or field.default is not specs.REQUIRED else BY_FORM
        like, takes = "" if first == full else same, field.spec.takes()
        yield Key(full, field.doc, takes.kind, takes.units, default, takes.allowed, like, again)
        if inner is not None:
            yield from _keys(inner, full + step, known, again or bool(like))


def _fields(spec: Any) -> list[tuple[str, specs.Field]]:
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


def _step(spec: Any) -> str:
    """What stands between a key and those of the mapping inside of it."""
    is_list = isinstance(spec, specs.ListOf) and not spec.alone
    here = f".{NAME}" if isinstance(spec, Named) else f".{NUMBER}" if is_list else ""
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
