"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
import re
from typing import Any, Final

from crackgrow.case.along import LengthOrAngle
from crackgrow.case.base import BESIDE, OfFile
from crackgrow.case.formula import ALPHABET, ONE_VALUE, OrFormula
from crackgrow.case.outline_file import ENDINGS, OutlineFile
from crackgrow.case.references import Definitions, Reference
from crackgrow.case.scalars import ANY, Bounds, Choice, Integer, Number, Quantity, Share, Spec, Switch, Text, WordOr
from crackgrow.case.scene import CASE
from crackgrow.case.schema import (
    BY_PARTS,
    OPTIONAL,
    REQUIRED,
    Chosen,
    Components,
    Converted,
    Field,
    ListOf,
    Mapping,
    Named,
    OneOf,
    OneOrList,
)
from crackgrow.case.units import LARGEST, SMALLEST, UNITS

Schema = dict[str, Any]

DRAFT: Final = "http://json-schema.org/draft-07/schema#"

_NUMBER: Final = r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?"
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NAME: Final = rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"
_NO_FORMULA: Final = rf"(?!.*\.[0-9]*\.)(?!.*({'|'.join(ONE_VALUE)})\s*\([^()]*,\s*[^)\s])"  # 1.2.3, sin(x, y)


def case_schema() -> str:
    """The JSON Schema of a case file as text."""
    head: Schema = {"$schema": DRAFT, "title": "crackgrow case", "description": "One scene of frictional crack growth."}
    body = schema_of(CASE)
    own: Schema = {"required": body.pop("required"), "not": {"required": ["base"]}}
    based: Schema = {"required": ["base"], "propertyNames": {"enum": ["base", "set", *BESIDE]}}
    return json.dumps(head | body | {"anyOf": [own, based]}, indent=1, ensure_ascii=False) + "\n"


def schema_of(spec: Spec) -> Schema:
    """What a spec accepts, as far as JSON Schema can say it."""
    match spec:
        case Mapping():
            return _mapping(spec)
        case Chosen():
            return _mapping(spec.otherwise)
        case OneOf(forms):
            return {"anyOf": [schema_of(form) for form in forms]}
        case Converted(inner):
            return schema_of(inner)
        case OfFile(kind):
            return {"type": "object" if kind == "a mapping" else "string"}
        case Definitions(named):
            return schema_of(named)
        case Reference(_, _, inner):
            return {"anyOf": [schema_of(inner), {"type": ["string", "number"], "pattern": _NAME}]}
        case Components(mapping):
            return {"anyOf": [schema_of(spec.listing), schema_of(mapping)]}
        case Named(_, inner, at_most):
            names = {"propertyNames": {"pattern": _NAME}, "maxProperties": at_most}
            return {"type": "object", **names, "additionalProperties": schema_of(inner)}
        case ListOf(inner, length, at_most):
            sized = {"maxItems": at_most} if length is None else {"minItems": length, "maxItems": length}
            return {"type": "array", "items": schema_of(inner), **sized}
        case OneOrList(inner):
            return {"anyOf": [schema_of(inner), schema_of(ListOf(inner))]}
        case WordOr(words, inner, docs):
            return {"anyOf": [schema_of(Choice(words, docs)), schema_of(inner)]}
        case _:
            return _scalar(spec)


def _scalar(spec: Spec) -> Schema:
    match spec:
        case Text(may_be_empty):  # an editor takes 2017 and true for no texts, the reader does
            pattern = {} if may_be_empty else {"pattern": r"\S"}
            return {"type": ["string", "number", "boolean"], **pattern}
        case Choice(words, docs):
            return {"enum": list(words), **({"enumDescriptions": list(docs)} if docs else {})}
        case Switch():
            return {"type": "boolean"}
        case Number(bounds):
            return {"type": "number", **_limits(bounds), **_no_less(SMALLEST)}
        case Integer(bounds):
            return {"type": "integer", **_limits(bounds)}
        case Quantity(kind, bounds):
            return {"anyOf": [_bare(kind, bounds), _with_unit(kind, bounds)]}
        case Share(bounds):
            percent = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%\s*$"}
            return {"anyOf": [{"type": "number", **_limits(bounds)}, percent]}
        case LengthOrAngle():
            texts = [_with_unit(kind, ANY) for kind in ("length", "angle")]
            return {"anyOf": [_bare("length", ANY), *texts]}
        case OrFormula(kind):
            formula = {"type": "string", "pattern": rf"^(?!\s*{_NUMBER}\s*$){_NO_FORMULA}({ALPHABET})+$"}
            return {"anyOf": [_bare(kind, ANY), _with_unit(kind, ANY), formula]}
        case OutlineFile():
            letters = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in ENDINGS]
            return {"type": "string", "pattern": rf"\.({'|'.join(letters)})$"}
    raise TypeError(f"{type(spec).__name__} has no form in JSON Schema")


def _mapping(spec: Mapping) -> Schema:
    required = [key for key, field in spec.fields.items() if field.default is REQUIRED]
    return {
        "type": "object",
        "properties": {key: _property(field) for key, field in spec.fields.items()},
        "additionalProperties": False,
        **({"required": required} if required else {}),
        **({"minProperties": 1} if spec.at_least_one else {}),
    }


def _property(field: Field) -> Schema:
    """What a key accepts, with what an editor shows of it."""
    words = f"{field.doc}: {field.spec.describe()}{_units(field.spec)}"
    plain = field.default not in (REQUIRED, OPTIONAL, BY_PARTS)
    if field.default in (OPTIONAL, BY_PARTS):
        words += "; may be left out"
    elif plain:
        words += f"; default: {json.dumps(field.default, ensure_ascii=False)}"
    return {"description": words, **schema_of(field.spec), **({"default": field.default} if plain else {})}


def _units(spec: Spec) -> str:
    """The units that a quantity, or each item of a list of them, may have, and what a bare number means."""
    match spec:
        case Quantity(kind):
            chosen = {
                "length": "in units.length",
                "stress": "in units.stress",
                "toughness": "in units.stress sqrt(m), where units.length is m",
                "stiffness": "in units.stress / units.length",
            }
            bare = chosen.get(kind, f"in {next(iter(UNITS[kind]))}")
            return f" ({' | '.join(UNITS[kind])}; a bare number is {bare})"
        case OrFormula(kind):
            return _units(Quantity(kind))
        case ListOf(inner) | WordOr(_, inner) | Reference(_, _, inner):
            return _units(inner)
        case Components():
            return _units(spec.listing)
    return ""


def _limits(bounds: Bounds) -> Schema:
    """Bounds of a number, and the size beyond which there is nothing physical."""
    low = {"exclusiveMinimum": bounds.above} if bounds.above is not None else {"minimum": bounds.at_least}
    high = {"exclusiveMaximum": bounds.below} if bounds.below is not None else {"maximum": bounds.at_most}
    limits = {key: value for key, value in (low | high).items() if value is not None}
    return limits | {key: size for key, size in (("minimum", -LARGEST), ("maximum", LARGEST)) if _open(limits, key)}


def _open(limits: Schema, key: str) -> bool:
    return key not in limits and f"exclusive{key.capitalize()}" not in limits


def _no_less(smallest: float) -> Schema:
    """Nothing nearer to 0 than physical numbers are, but 0; nor .nan, which no bound refuses."""
    return {"not": {"exclusiveMinimum": -smallest, "exclusiveMaximum": smallest, "not": {"const": 0}}}


def _bare(kind: str, bounds: Bounds) -> Schema:
    """A bare number; its unit is another key's business, so that the smallest one is that of the largest unit."""
    return {"type": "number", **_limits(bounds), **_no_less(SMALLEST / float(max(UNITS[kind].values())))}


def _with_unit(kind: str, bounds: Bounds) -> Schema:
    """A text of a number and a unit; of its bounds a pattern can tell the sign."""
    sign = ""
    if bounds.above == 0:
        sign = rf"(?!\s*-)(?={_NOT_ZERO})"
    elif bounds.at_least == 0:
        sign = rf"(?!\s*-{_NOT_ZERO})"
    units = "|".join(re.escape(unit) for unit in UNITS[kind])
    return {"type": "string", "pattern": rf"^{sign}\s*{_NUMBER}\s*({units})\s*$"}
