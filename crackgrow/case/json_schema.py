"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from crackgrow.case.drawings import File
from crackgrow.case.format import CASE
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
IN_NAMES: Final = {">": "above", ">=": "from", "<": "below", "<=": "to"}  # of definitions

_NUMBER: Final = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NO_FORMULA: Final = rf"(?!.*\.[0-9]*\.)(?!.*({'|'.join(ONE_VALUE)})\s*\([^()]*,\s*[^)\s])"  # 1.2.3, sin(x, y)

_NEAR_ZERO: Final = SMALLEST / float(max(one for units in UNITS.values() for one in units.values()))
_BARE: Final[Schema] = {
    "title": "number",
    "type": "number",
    "minimum": -LARGEST,
    "maximum": LARGEST,
    "not": {"exclusiveMinimum": -_NEAR_ZERO, "exclusiveMaximum": _NEAR_ZERO, "not": {"const": 0}},
}
"""A number that is physical in some unit: not .nan, which no bound refuses, and 0 or far from it."""


def case_schema() -> str:
    """The JSON Schema of a case file as text, a line for each key of the case and for each definition."""
    head: Schema = {"$schema": DRAFT, "title": "crackgrow case", "description": "One scene of frictional crack growth."}
    body = schema_of(replace(CASE, part=""))
    own: Schema = {"required": body.pop("required"), "not": {"required": ["base"]}}
    based: Schema = {"required": ["base"], "propertyNames": {"enum": ["base", "set", *BESIDE]}}
    parts = []
    for key, value in (head | body | {"anyOf": [own, based]}).items():
        long = key in ("properties", "definitions")
        inner = [f"  {_json(name)}: {_json(its)}" for name, its in value.items()] if long else []
        parts.append(f" {_json(key)}: " + ("{\n" + ",\n".join(inner) + "\n }" if long else _json(value)))
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def schema_of(spec: Any) -> Schema:
    """What a spec accepts, with the definitions that it refers to."""
    schemas = _Schemas()
    body = schemas.of(spec)
    return {**body, **({"definitions": schemas.definitions} if schemas.definitions else {})}


class _Schemas:
    """Schemas of specs; what several keys take is a definition that they refer to."""

    def __init__(self) -> None:
        self.definitions: dict[str, Schema] = {}

    def named(self, name: str, make: Callable[[], Schema]) -> Schema:
        """A reference to a definition, made where it is not known yet."""
        name = re.sub(r"\W+", "_", name)
        if name not in self.definitions:
            self.definitions[name] = {}  # its place, before those inside of it
            self.definitions[name] = make()
        return {"$ref": f"#/definitions/{name}"}

    def of(self, spec: Any) -> Schema:
        """What a spec accepts, as far as JSON Schema can say it."""
        match spec:
            case Mapping() | OneOf() if spec.part:
                return self.named(spec.part, lambda: self._forms(spec))
            case Mapping() | OneOf():
                return self._forms(spec)
            case ListOf(spec=inner, alone=True):
                return {"anyOf": [self.of(inner), self.of(replace(spec, alone=False))]}
            case ListOf(Measured("length", ()), 2):
                return self.named("point", lambda: self._list(spec))
            case ListOf():
                return self._list(spec)
            case Named(spec=inner):
                names = {} if spec.any_name else {"propertyNames": self._name()}
                inside = self.of(inner)
                return {"type": "object", **names, "maxProperties": spec.at_most, "additionalProperties": inside}
            case Reference(where, inner):
                name = {"title": f"reference (to {where})", "type": ["string", "number"], "allOf": [self._name()]}
                return {"anyOf": [self.of(inner), self.named(f"from {where}", lambda: name)]}
            case Words(words, docs, other):
                chosen = {"enum": list(words), **({"enumDescriptions": list(docs)} if docs else {})}
                return {"anyOf": [chosen, self.of(other)]} if other else chosen
            case Measured():
                return self._measured(spec)
            case OrFormula(kind):
                pattern = rf"^(?!\s*{_NUMBER}\s*$){_NO_FORMULA}({ALPHABET})+$"
                formula = {"title": "formula (in x and y, such as 0.09*x - 0.1)", "type": "string", "pattern": pattern}
                return {"anyOf": [self.of(Measured(kind)), self.named("formula", lambda: formula)]}
            case PlaceOnEdge():
                return {"anyOf": [self.of(Measured(kind)) for kind in ("length", "angle")]}
            case File():
                endings = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in spec.endings]
                file = {"title": spec.describe(), "type": "string", "pattern": rf"\.({'|'.join(endings)})$"}
                return self.named("file of cracks" if spec.of_cracks else "file", lambda: file)
            case OfFile(kind):
                return {"type": "object" if kind == "a mapping" else "string"}
            case Switch():
                return {"type": "boolean"}
            case Text():  # an editor takes 2017 and true for no texts, the reader does
                text = {"type": ["string", "number", "boolean"], **({} if spec.may_be_empty else {"pattern": r"\S"})}
                return self.named("text or empty" if spec.may_be_empty else "text", lambda: text)
        raise TypeError(f"{type(spec).__name__} has no JSON Schema")

    def _name(self) -> Schema:
        pattern = rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"
        return self.named("name", lambda: {"title": "name", "pattern": pattern})

    def _list(self, spec: ListOf) -> Schema:
        sized = {"minItems": spec.length, "maxItems": spec.length} if spec.length else {"maxItems": spec.at_most}
        return {"type": "array", "items": self.of(spec.spec), **sized}

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
            rule = {
                "required": [spelt[0] for spelt in needed if len(spelt) == 1],
                "anyOf": [{"required": [name]} for spelt in needed if len(spelt) > 1 for name in spelt],
                "minProperties": int(form.read_as is dict),
                "propertyNames": {"enum": [name for spelt in names.values() for name in spelt]} if forms[1:] else {},
            }
            rules.append({key: its for key, its in rule.items() if its})
        properties = {name: self._property(same) for name, same in fields.items()}
        own = rules[0] if len(rules) == 1 else {"anyOf": rules}
        found = {"type": "object", "properties": properties, "additionalProperties": False, **own}
        others = [form.other for form in forms if form.other]
        return {"anyOf": [*map(self.of, others), found]} if others else found

    def _property(self, fields: list[Field]) -> Schema:
        """What a key of one or several forms accepts; beside a reference draft 7 heeds no other key."""
        found: Schema = {"description": " / ".join(dict.fromkeys(field.doc for field in fields))}
        default = fields[0].default
        if default not in (REQUIRED, OPTIONAL) and not isinstance(default, Same):
            found["default"] = default
        schemas = [self.of(field.spec) for field in fields]
        different = [its for k, its in enumerate(schemas) if its not in schemas[:k]]
        accepted = different[0] if len(different) == 1 else {"anyOf": different}
        return {**found, "allOf": [accepted]} if "$ref" in accepted else {**accepted, **found}

    def _measured(self, spec: Measured) -> Schema:
        limits: Schema = {LIMITS[sign]: limit for sign, limit in spec.bounds}  # a text heeds none of them
        if spec.kind in (PLAIN, WHOLE, SHARE):
            told = {"title": spec.describe(), **limits} if limits else {}
            if spec.kind == WHOLE:
                return {"type": "integer", **told}
            number = self.named("number", lambda: _BARE)
            if spec.kind == PLAIN:
                return {"allOf": [number], **told} if told else number
            percent = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%\s*$"}
            return {"anyOf": [{"type": "number"}, percent], **told}
        whole = self.named(spec.kind, lambda: self._quantity(spec.kind))
        if not limits:
            return whole
        sign = {}  # what a pattern can tell of the bounds of a number with a unit
        if (">", 0) in spec.bounds:
            sign = {"pattern": rf"^(?!\s*-)(?={_NOT_ZERO})"}
        elif (">=", 0) in spec.bounds:
            sign = {"pattern": rf"^(?!\s*-{_NOT_ZERO})"}
        bounded = {"title": f"{spec.kind} {spec.limits}", "allOf": [whole], **limits, **sign}
        name = " ".join([spec.kind, *(f"{IN_NAMES[sign]} {limit:g}" for sign, limit in spec.bounds)])
        return self.named(name, lambda: bounded)

    def _quantity(self, kind: str) -> Schema:
        """A bare number, whose unit is another key's business, or a text of a number and a unit."""
        units = "|".join(re.escape(unit) for unit in UNITS[kind])
        bare = Units("units.length", "units.stress").of(kind) + ", in m" * (kind == "toughness")
        text = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*({units})\s*$"}
        title = f"{kind} ({listed(UNITS[kind])}; a bare number is in {bare})"
        return {"title": title, "anyOf": [self.named("number", lambda: _BARE), text]}
