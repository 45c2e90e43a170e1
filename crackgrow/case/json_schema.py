"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from copy import copy
from dataclasses import replace
from typing import Any, Final

from crackgrow.case import schema as specs
from crackgrow.case.format import CASE
from crackgrow.case.formula import ALPHABET, ONE_VALUE, OrFormula
from crackgrow.case.outline_file import OutlineFile
from crackgrow.case.overrides import BESIDE, OfFile
from crackgrow.case.references import Definitions, Reference
from crackgrow.case.regions import LengthOrAngle
from crackgrow.case.scalars import ANY, Bounds, Choice, Integer, Number, Quantity, Share, Spec, Switch, Text, WordOr
from crackgrow.case.units import LARGEST, SMALLEST, UNITS

Schema = dict[str, Any]

DRAFT: Final = "http://json-schema.org/draft-07/schema#"
SHORT: Final = 64  # letters of a schema that is written out wherever it is met

_HERE: Final = "#/definitions/"
_NUMBER: Final = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NAME: Final = {"title": "name", "pattern": rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"}
_NO_FORMULA: Final = rf"(?!.*\.[0-9]*\.)(?!.*({'|'.join(ONE_VALUE)})\s*\([^()]*,\s*[^)\s])"  # 1.2.3, sin(x, y)


def case_schema() -> str:
    """The JSON Schema of a case file as text, a line for each key of the case and for each definition."""
    head: Schema = {"$schema": DRAFT, "title": "crackgrow case", "description": "One scene of frictional crack growth."}
    body = schema_of(CASE)
    own: Schema = {"required": body.pop("required"), "not": {"required": ["base"]}}
    based: Schema = {"required": ["base"], "propertyNames": {"enum": ["base", "set", *BESIDE]}}
    return _text(head | body | {"anyOf": [own, based]})


def _text(schema: Schema) -> str:
    parts = []
    for key, value in schema.items():
        long = isinstance(value, dict) and key in ("properties", "definitions")
        inner = [f"  {_json(name)}: {_json(its)}" for name, its in value.items()] if long else []
        parts.append(f" {_json(key)}: " + ("{\n" + ",\n".join(inner) + "\n }" if long else _json(value)))
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _json(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def schema_of(spec: Spec) -> Schema:
    """What a spec accepts, as far as JSON Schema can say it; what is met more than once is a definition."""
    whole = _written(spec)
    times: Counter[str] = Counter()
    _count(whole, times)
    shared = _Shared({text for text, number in times.items() if number > 1 and len(text) > SHORT})
    body = shared.with_references(whole, "case")
    return body | ({"definitions": shared.definitions} if shared.definitions else {})


def _inside(schema: Schema) -> list[tuple[Any, Any, str]]:
    """Where the schemas in a schema stand: what holds each, its key or number in that, and the key that it is of."""
    found: list[tuple[Any, Any, str]] = [(schema["properties"], name, name) for name in schema.get("properties", ())]
    found += [(schema[key], number, "") for key in ("anyOf", "allOf") for number in range(len(schema.get(key, ())))]
    return found + [(schema, key, "") for key in ("items", "additionalProperties", "propertyNames") if schema.get(key)]


def _count(schema: Schema, times: Counter[str]) -> None:
    """Count how often each schema is met, where those in equal ones are looked at once."""
    for holder, place, _ in _inside(schema):
        text = _json(holder[place])
        times[text] += 1
        if times[text] == 1:
            _count(holder[place], times)


class _Shared:
    """Puts references in the place of schemas that are met more than once."""

    def __init__(self, texts: set[str]) -> None:
        self._names: dict[str, str] = {}
        self._texts = texts
        self.definitions: dict[str, Schema] = {}

    def of(self, schema: Schema, key: str) -> Schema:
        """A schema, or a reference to its definition, which is called after its title or the key that it is met at."""
        text = _json(schema)
        if text not in self._texts:
            return self.with_references(schema, key)
        if text not in self._names:
            name = re.sub(r"\W+", "_", schema.get("title", key).partition(" (")[0])
            number = sum(re.fullmatch(rf"{name}(_\d+)?", other) is not None for other in self._names.values())
            self._names[text] = f"{name}_{number + 1}" if number else name
            self.definitions[self._names[text]] = {}  # its place, before those inside of it
            self.definitions[self._names[text]] = self.with_references(schema, key)
        return {"$ref": _HERE + self._names[text]}

    def with_references(self, schema: Schema, key: str) -> Schema:
        """A schema with references inside; what one alone adds to its description it holds itself."""
        found = {name: copy(value) for name, value in schema.items()}
        for holder, place, its_key in _inside(found):
            holder[place] = self.of(holder[place], its_key or key)
        alone = found.get("allOf", [{"$ref": ""}])[0]
        if "$ref" in alone:
            return found
        del found["allOf"]
        return {**found, **alone, **found}


def _written(spec: Spec) -> Schema:
    """The schema of a spec without references."""
    match spec:
        case specs.Mapping(fields, at_least_one):
            if spec.short:
                return {"anyOf": [_written(fields[spec.short].spec), _written(replace(spec, short=""))]}
            spelt = {key: [key, *(word for word in field.also if word != "true")] for key, field in fields.items()}
            needed = [spelt[key] for key, field in fields.items() if field.default is specs.REQUIRED]
            required = [names[0] for names in needed if len(names) == 1]
            either = [{"required": [name]} for names in needed if len(names) > 1 for name in names]
            return {
                "type": "object",
                "properties": {name: _property(fields[key]) for key, names in spelt.items() for name in names},
                "additionalProperties": False,
                **({"required": required} if required else {}),
                **({"anyOf": either} if either else {}),
                **({"minProperties": 1} if at_least_one else {}),
            }
        case specs.OneOf(forms):
            return {"anyOf": [_written(form) for form in forms]}
        case specs.Converted(inner) | Definitions(inner):
            return _written(inner)
        case OfFile(kind):
            return {"type": "object" if kind == "a mapping" else "string"}
        case Reference(_, where, inner):
            name = {"title": f"reference (to {where})", "type": ["string", "number"], "allOf": [_NAME]}
            return {"anyOf": [_written(inner), name]}
        case specs.Components(mapping):
            return {"anyOf": [_written(spec.listing), _written(mapping)]}
        case specs.Named(_, inner, at_most):
            names = {**({} if spec.any_name else {"propertyNames": _NAME}), "maxProperties": at_most}
            return {"type": "object", **names, "additionalProperties": _written(inner)}
        case specs.ListOf(inner, length, at_most):
            sized = {"maxItems": at_most} if length is None else {"minItems": length, "maxItems": length}
            return {"type": "array", "items": _written(inner), **sized}
        case specs.OneOrList(inner):
            return {"anyOf": [_written(inner), _written(specs.ListOf(inner))]}
        case WordOr(words, inner, docs):
            return {"anyOf": [_written(Choice(words, docs)), _written(inner)]}
    return _scalar(spec)


def _property(field: specs.Field) -> Schema:
    """What a key accepts, with what an editor shows of it; beside a reference draft 7 heeds no other key."""
    measured = isinstance(getattr(field.spec, "spec", field.spec), Quantity | Number | Integer)
    return {
        "description": f"{field.doc}: {field.spec.describe()}" if measured else field.doc,
        **field.default_value,
        "allOf": [_written(field.spec)],
    }


def _scalar(spec: Spec) -> Schema:
    match spec:
        case Text(may_be_empty):  # an editor takes 2017 and true for no texts, the reader does
            return {"type": ["string", "number", "boolean"], **({} if may_be_empty else {"pattern": r"\S"})}
        case Choice(words, docs):
            return {"enum": list(words), **({"enumDescriptions": list(docs)} if docs else {})}
        case Switch():
            return {"type": "boolean"}
        case Number(bounds):
            return {"allOf": [_bare(1.0)], **_limits(bounds)}
        case Integer(bounds):
            return {"type": "integer", **_limits(bounds)}
        case Quantity(kind, bounds):
            title = {"title": spec.describe().partition(" ")[2]}
            limited = {**title, "allOf": [_quantity(kind)], **_limits(bounds), **_sign(bounds)}
            return limited if bounds != ANY else _quantity(kind)
        case Share(bounds):
            percent = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%\s*$"}
            return {"anyOf": [{"type": "number", **_limits(bounds)}, percent]}
        case LengthOrAngle():
            return {"anyOf": [_quantity("length"), _quantity("angle")]}
        case OrFormula(kind):
            pattern = rf"^(?!\s*{_NUMBER}\s*$){_NO_FORMULA}({ALPHABET})+$"
            formula = {"title": "formula (in x and y, such as 0.09*x - 0.1)", "type": "string", "pattern": pattern}
            return {"anyOf": [_quantity(kind), formula]}
        case OutlineFile():
            letters = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in spec.endings]
            return {"title": spec.describe(), "type": "string", "pattern": rf"\.({'|'.join(letters)})$"}
    raise TypeError(f"{type(spec).__name__} has no form in JSON Schema")


def _limits(bounds: Bounds) -> Schema:
    """Bounds of a number; a text heeds none of them."""
    keys = {
        "exclusiveMinimum": bounds.above,
        "minimum": bounds.at_least,
        "exclusiveMaximum": bounds.below,
        "maximum": bounds.at_most,
    }
    return {key: value for key, value in keys.items() if value is not None}


def _sign(bounds: Bounds) -> Schema:
    """What a pattern can tell of the bounds of a number with a unit."""
    if bounds.above == 0:
        return {"pattern": rf"^(?!\s*-)(?={_NOT_ZERO})"}
    return {"pattern": rf"^(?!\s*-{_NOT_ZERO})"} if bounds.at_least == 0 else {}


def _bare(largest: float) -> Schema:
    """A number that is physical in the largest of its units: not .nan, which no bound refuses, and 0 or far from it."""
    near = {"exclusiveMinimum": -SMALLEST / largest, "exclusiveMaximum": SMALLEST / largest, "not": {"const": 0}}
    return {"title": "number", "type": "number", "minimum": -LARGEST, "maximum": LARGEST, "not": near}


def _quantity(kind: str) -> Schema:
    """A bare number, whose unit is another key's business, or a text of a number and a unit."""
    chosen = {
        "length": "in units.length",
        "stress": "in units.stress",
        "toughness": "in units.stress sqrt(m), where units.length is m",
        "stiffness": "in units.stress / units.length",
    }
    bare = chosen.get(kind, f"in {next(iter(UNITS[kind]))}")
    units = "|".join(re.escape(unit) for unit in UNITS[kind])
    return {
        "title": f"{kind} ({' | '.join(UNITS[kind])}; a bare number is {bare})",
        "anyOf": [
            _bare(float(max(UNITS[kind].values()))),
            {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*({units})\s*$"},
        ],
    }
