"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection
from dataclasses import asdict
from typing import Any, Final

from crackgrow.case import scene
from crackgrow.case.along import LengthOrAngle
from crackgrow.case.base import BESIDE, OfFile
from crackgrow.case.formula import ALPHABET, ONE_VALUE, OrFormula
from crackgrow.case.outline_file import OutlineFile
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

_HERE: Final = "#/definitions/"
_SCENE: Final[dict[str, Spec]] = {
    name.lower().strip("_"): spec for name, spec in vars(scene).items() if name.isupper() and hasattr(spec, "describe")
}
"""All specs that have a name in `scene`, by that name."""

_NUMBER: Final = r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?"
_NOT_ZERO: Final = "[^a-zA-Z]*[1-9]"  # ahead of a number: it has a digit, before its exponent, that is not 0
_NO_LETTERS: Final = r"\x00-,./:-@\[-^`{-\x7f\u0300-\u036f\u2000-\u206f"  # _ and - are some; letters are of any script
_NAME: Final = rf"^[^{_NO_LETTERS}-][^{_NO_LETTERS}]{{0,63}}$"
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
    every = _Schemas(None)
    text = _json([every.written(spec), every.definitions])
    shared = _Schemas({name for name in every.definitions if text.count(f'"{_HERE}{name}"') > 1})
    body = shared.written(spec)
    return body | ({"definitions": shared.definitions} if shared.definitions else {})


def _name_of(spec: Spec) -> str:
    """What the definition of a spec is called, empty where it never is one: a quantity, or as in `scene`."""
    match spec:
        case Quantity(kind, bounds):
            return "_".join([kind, *(f"{key}_{limit:g}" for key, limit in asdict(bounds).items() if limit is not None)])
        case OrFormula(kind):
            return f"{kind}_or_formula"
        case Text(may_be_empty):
            return "" if may_be_empty else "text"
        case Switch() | Integer() | Number() | Share() | OfFile():
            return ""
    return next((name for name, other in _SCENE.items() if other == spec), "")


class _Schemas:
    """Writes specs as schemas, those with a name as definitions that others refer to."""

    def __init__(self, shared: Collection[str] | None) -> None:
        self._shared = shared  # names of the definitions; None: all that have a name
        self._keys: dict[str, list[Field]] = {}
        self.definitions: dict[str, Schema] = {}

    def of(self, spec: Spec) -> Schema:
        """The schema, or a reference to it."""
        name = _name_of(spec)
        return self._referred(name, lambda: self.written(spec)) if name else self.written(spec)

    def _referred(self, name: str, write: Callable[[], Schema]) -> Schema:
        """A reference to a definition, or what it is where it is no shared one."""
        if self._shared is not None and name not in self._shared:
            return write()
        if name not in self.definitions:
            self.definitions[name] = write()
        return {"$ref": f"{_HERE}{name}"}

    def written(self, spec: Spec) -> Schema:
        """The schema itself."""
        match spec:
            case Mapping():
                return self._mapping(spec)
            case Chosen():
                return self.of(spec.otherwise)
            case OneOf(forms):
                return {"anyOf": [self.of(form) for form in forms]}
            case Converted(inner):
                return self.of(inner)
            case OfFile(kind):
                return {"type": "object" if kind == "a mapping" else "string"}
            case Definitions(named):
                return self.of(named)
            case Reference(_, _, inner):
                return {"anyOf": [self.of(inner), {"type": ["string", "number"], "allOf": [self._name()]}]}
            case Components(mapping):
                return {"anyOf": [self.of(spec.listing), self.of(mapping)]}
            case Named(_, inner, at_most):
                names = {"propertyNames": self._name(), "maxProperties": at_most}
                return {"type": "object", **names, "additionalProperties": self.of(inner)}
            case ListOf(inner, length, at_most):
                sized = {"maxItems": at_most} if length is None else {"minItems": length, "maxItems": length}
                return {"type": "array", "items": self.of(inner), **sized}
            case OneOrList(inner):
                return {"anyOf": [self.of(inner), self.of(ListOf(inner))]}
            case WordOr(words, inner, docs):
                other = self.of(inner)
                return {"anyOf": [self.of(Choice(words, docs)), *other.get("anyOf", [other])]}
            case _:
                return _scalar(spec)

    def _name(self) -> Schema:
        """What a name of the user's choice looks like."""
        return self._referred("name", lambda: {"pattern": _NAME})

    def _mapping(self, spec: Mapping) -> Schema:
        required = [key for key, field in spec.fields.items() if field.default is REQUIRED]
        return {
            "type": "object",
            "properties": {key: self._property(key, field) for key, field in spec.fields.items()},
            "additionalProperties": False,
            **({"required": required} if required else {}),
            **({"minProperties": 1} if spec.at_least_one else {}),
        }

    def _property(self, key: str, field: Field) -> Schema:
        """The same of a key, or a reference to it; keys that mean other things elsewhere have numbers."""
        known = self._keys.setdefault(key, [])
        if field not in known:
            known.append(field)
        number = known.index(field)
        return self._referred(f"key_{key}{f'_{number + 1}' if number else ''}", lambda: self._shown(field))

    def _shown(self, field: Field) -> Schema:
        """What a key accepts, with what an editor shows of it; beside a reference draft 7 heeds no other key."""
        words = f"{field.doc}: {_described(field.spec)}{_units(field.spec)}"
        plain = field.default not in (REQUIRED, OPTIONAL, BY_PARTS)
        if field.default in (OPTIONAL, BY_PARTS):
            words += "; optional"
        elif plain:
            words += f"; default: {json.dumps(field.default, ensure_ascii=False)}"
        schema = self.of(field.spec)
        schema = {"allOf": [schema]} if "$ref" in schema else schema
        return {"description": words, **schema, **({"default": field.default} if plain else {})}


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
            letters = ["".join(f"[{c}{c.upper()}]" for c in ending.removeprefix(".")) for ending in spec.endings]
            return {"type": "string", "pattern": rf"\.({'|'.join(letters)})$"}
    raise TypeError(f"{type(spec).__name__} has no form in JSON Schema")


def _described(spec: Spec) -> str:
    """What a spec allows, in words; which keys a mapping has an editor tells as they are typed."""
    match spec:
        case Mapping() | Chosen():
            return "a mapping"
        case Converted(inner):
            return _described(inner)
        case Reference(_, where, inner):
            return f"{_described(inner)}, or a name from `{where}`"
        case WordOr(words, other):
            return f"{' | '.join(words)} | {_described(other)}"
        case Components():
            return f"{spec.listing.describe()}, or a mapping"
    return spec.describe()


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
