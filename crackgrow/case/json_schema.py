"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from crackgrow.case.drawings import File
from crackgrow.case.format import CASE, FORMAT
from crackgrow.case.formula import ALPHABET, ONE_VALUE, OrFormula
from crackgrow.case.overrides import BESIDE, OfFile
from crackgrow.case.regions import PlaceOnEdge
from crackgrow.case.report import listed
from crackgrow.case.scalars import PLAIN, SHARE, WHOLE, Measured, Reference, Switch, Text, Words
from crackgrow.case.schema import OPTIONAL, REQUIRED, Field, ListOf, Mapping, Named, OneOf, Same
from crackgrow.case.units import LARGEST, SMALLEST, UNITS, Units

Schema = dict[str, Any]

DRAFT: Final = "http://json-schema.org/draft-07/schema#"
LIMITS: Final = {">": "exclusiveMinimum", ">=": "minimum", "<": "exclusiveMaximum", "<=": "maximum"}
IN_NAMES: Final = {">=": "from", "<=": "to", ">": "above", "<": "below"}  # of definitions

_NUMBER: Final = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NO_FORMULA: Final = rf"(?!.*\.[0-9]*\.)(?!.*({'|'.join(ONE_VALUE)})\s*\([^()]*,\s*[^)\s])"  # 1.2.3, sin(x, y)

_POSITIVE: Final[Schema] = {"exclusiveMinimum": 0, "pattern": rf"^(?!\s*-)(?={_NOT_ZERO})"}
_NOT_NEGATIVE: Final[Schema] = {"minimum": 0, "pattern": rf"^(?!\s*-{_NOT_ZERO})"}
SIGNS: Final = {">": ("positive", lambda: _POSITIVE), ">=": ("not negative", lambda: _NOT_NEGATIVE)}
"""Bounds by 0, which a pattern can tell of a number with a unit."""


def _no_number(smallest: float) -> Schema:
    """Numbers that are not physical, neither 0 nor at least so large; .nan, too, which no bound refuses."""
    wrong = [{"exclusiveMaximum": -LARGEST}, {"exclusiveMinimum": LARGEST}]
    wrong += [{"exclusiveMinimum": low, "exclusiveMaximum": low + smallest} for low in (-smallest, 0)]
    return {"type": "number", "anyOf": wrong}


def _no_quantity() -> Schema:
    """The same in the largest unit that a case may choose, and texts that are no number with a word behind it."""
    text = rf"\s*{_NUMBER}\s*[a-zA-Z][a-zA-Z/]*(\^\d)?( sqrt\(\w+\))?\s*"
    largest_unit = float(max(one for units in UNITS.values() for one in units.values()))
    return {"anyOf": [_no_number(SMALLEST / largest_unit), {"type": "string", "pattern": f"^(?!{text}$)"}]}


def case_schema() -> str:
    """The JSON Schema of a case file as text, a line for each key and for each definition."""
    head: Schema = {"$schema": DRAFT, "description": "A case of crackgrow: one scene of frictional crack growth."}
    body = schema_of(CASE)
    own: Schema = {"required": body.pop("required"), "not": {"required": ["base"]}}
    based: Schema = {"required": ["base"], "propertyNames": {"enum": ["base", "set", *BESIDE]}}
    return _text(head | body | {"anyOf": [own, based]}) + "\n"


def _text(value: Any, depth: int = 1, lines: bool = False) -> str:
    """The text of a schema, or of what keys and definitions hold, which each begin a line."""
    if isinstance(value, list):
        return f"[{','.join(_text(item, depth) for item in value)}]"
    if not isinstance(value, dict):
        return json.dumps(value, ensure_ascii=False)
    before = "\n" + " " * depth if lines else ""
    listed = {key: key in ("properties", "$defs") and not lines for key in value}
    parts = (f"{before}{json.dumps(key)}:{_text(its, depth + lines, listed[key])}" for key, its in value.items())
    return f"{{{','.join(parts)}}}"


def schema_of(spec: Any) -> Schema:
    """What a spec accepts; what is met more than once is a definition that it refers to."""
    every = _Schemas(set())
    every.of(spec)
    schemas = _Schemas({name for name, times in every.times.items() if times == 1})
    body = schemas.of(spec)
    return {**body, **({"$defs": schemas.definitions} if schemas.definitions else {})}


class _Schemas:
    """Schemas of specs; what has a name is a definition that others refer to, but for the names in `once`."""

    def __init__(self, once: set[str]) -> None:
        self.once = once
        self.definitions: dict[str, Schema] = {}
        self.times: Counter[str] = Counter()  # that each of them is referred to

    def shared(self, name: str, make: Callable[[], Schema]) -> Schema:
        """A reference to a definition."""
        name = re.sub(r"\W+", "_", name)
        if name in self.once:
            return make()
        if name not in self.definitions:
            self.definitions[name] = {}  # its place, before those inside of it
            self.definitions[name] = make()
        self.times[name] += 1
        return {"$ref": f"#/$defs/{name}"}

    def of(self, spec: Any) -> Schema:
        """What a spec accepts, as far as JSON Schema can say it."""
        name = "_".join(spec.words) if isinstance(spec, Words) and spec.docs else FORMAT.name(spec)
        if not name or isinstance(spec, Switch):
            return self._made(spec)
        for sign, word in IN_NAMES.items():
            name = name.replace(sign, word)
        return self.shared(name, lambda: self._made(spec))

    def _made(self, spec: Any) -> Schema:
        match spec:
            case Mapping() | OneOf():
                return self._forms(spec)
            case ListOf(spec=inner, alone=True):
                return {"anyOf": [self.of(inner), self.of(replace(spec, alone=False))]}
            case ListOf():
                sized = (
                    {"minItems": spec.length, "maxItems": spec.length} if spec.length else {"maxItems": spec.at_most}
                )
                return {"type": "array", "items": self.of(spec.spec), **sized}
            case Named(spec=inner):
                names = {} if spec.any_name else {"propertyNames": self._any_name()}
                inside = self.of(inner)
                return {"type": "object", **names, "maxProperties": spec.at_most, "additionalProperties": inside}
            case Reference(where, inner):
                name = {"title": f"reference (to {where})", "type": ["string", "number"], "allOf": [self._any_name()]}
                return {"anyOf": [self.of(inner), self.shared(f"from {where}", lambda: name)]}
            case Words(words, docs, other):
                chosen = {"enum": list(words), **({"enumDescriptions": list(docs)} if docs else {})}
                return {"anyOf": [chosen, self.of(other)]} if other else chosen
            case Measured():
                return self._measured(spec)
            case OrFormula(kind):
                pattern = rf"^(?!\s*{_NUMBER}\s*$){_NO_FORMULA}({ALPHABET})+$"
                formula = {"title": "formula (in x and y, such as 0.09*x - 0.1)", "type": "string", "pattern": pattern}
                return {"anyOf": [self.of(FORMAT.spec(kind)), self.shared("formula", lambda: formula)]}
            case PlaceOnEdge():
                return {"anyOf": [self.of(FORMAT.spec(kind)) for kind in ("length", "angle")]}
            case File():
                endings = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in spec.endings]
                return {"title": spec.describe(), "type": "string", "pattern": rf"\.({'|'.join(endings)})$"}
            case OfFile(kind):
                return {"type": "object" if kind == "a mapping" else "string"}
            case Switch():
                return {"type": "boolean"}
            case Text():  # an editor takes 2017 and true for no texts, the reader does
                return {"type": ["string", "number", "boolean"], **({} if spec.may_be_empty else {"pattern": r"\S"})}
        raise TypeError(f"{type(spec).__name__} has no JSON Schema")

    def _any_name(self) -> Schema:
        pattern = rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"
        return self.shared("name", lambda: {"title": "name", "pattern": pattern})

    def _forms(self, spec: Mapping | OneOf) -> Schema:
        """A mapping, or one of several forms of it with the keys of all of them; or what stands in place of it."""
        forms = spec.forms if isinstance(spec, OneOf) else (spec,)
        fields: dict[str, list[Field]] = {}
        rules = []
        for form in forms:
            # `true` is what YAML 1.1 makes of `on`
            names = {key: [key, *(word for word in its.also if word != "true")] for key, its in form.fields.items()}
            for key, spelt in names.items():
                for name in spelt:
                    fields.setdefault(name, []).append(form.fields[key])
            needed = [names[key] for key in form.fields if key in form.required()]
            own_keys = [name for spelt in names.values() for name in spelt]
            rule = {
                "required": [spelt[0] for spelt in needed if len(spelt) == 1],
                "anyOf": [{"required": [name]} for spelt in needed if len(spelt) > 1 for name in spelt],
                "minProperties": int(form.read_as is dict),
                "maxProperties": len(own_keys) * bool(forms[1:] and len(needed) == len(own_keys)),
                "propertyNames": {"enum": own_keys} if forms[1:] and len(needed) < len(own_keys) else {},
            }
            rules.append({key: its for key, its in rule.items() if its})
        properties = {name: self._property(same) for name, same in fields.items()}
        own = rules[0] if len(rules) == 1 else {"anyOf": rules}
        found = {"type": "object", "properties": properties, "additionalProperties": False, **own}
        others = [form.other for form in forms if form.other]
        return {"anyOf": [*map(self.of, others), found]} if others else found

    def _property(self, fields: list[Field]) -> Schema:
        """What a key of one or several forms accepts; beside a reference draft 7 takes what is told, but no bounds."""
        told: Schema = {"description": " / ".join(dict.fromkeys(field.doc for field in fields))}
        default = fields[0].default
        if default not in (REQUIRED, OPTIONAL, {}) and not isinstance(default, Same):  # {} is what its keys have
            told["default"] = default
        specs = [field.spec for field in fields]
        different = [self.of(spec) for k, spec in enumerate(specs) if spec not in specs[:k]]
        return {**(different[0] if len(different) == 1 else {"anyOf": different}), **told}

    def _measured(self, spec: Measured) -> Schema:
        limits: Schema = {LIMITS[sign]: limit for sign, limit in spec.bounds}  # a text heeds none of them
        title = {"title": spec.describe()}
        if spec.kind == WHOLE:
            return {"type": "integer", **title, **limits}
        if spec.kind == PLAIN:
            return {"type": "number", **title, **limits, "not": self.shared("no number", lambda: _no_number(SMALLEST))}
        if spec.kind == SHARE:
            percent = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%\s*$"}
            return {"anyOf": [{"type": "number"}, percent], **title, **limits}
        if not limits:
            return self._quantity(spec.kind)
        found: Schema = {"allOf": [self.of(FORMAT.spec(spec.kind))]}
        for sign, limit in spec.bounds:
            if limit == 0 and sign in SIGNS:
                found["allOf"].append(self.shared(*SIGNS[sign]))
            else:
                found[LIMITS[sign]] = limit
        return found

    def _quantity(self, kind: str) -> Schema:
        """A bare number, whose unit is another key's business, or a text of a number and a unit."""
        bare = Units("units.length", "units.stress").of(kind) + ", in m" * (kind == "toughness")
        title = f"{kind} ({listed(UNITS[kind])}; a bare number is in {bare})"
        parts = ("stress", "length") if kind == "stiffness" else (kind,)  # each unit of the one over each of the other
        units = "/".join(f"({'|'.join(map(re.escape, UNITS[part]))})" for part in parts)
        pattern = rf"[\d.]\s*{units}\s*$"
        wrong = self.shared("no quantity", _no_quantity)
        return {"title": title, "type": ["number", "string"], "pattern": pattern, "not": wrong}
