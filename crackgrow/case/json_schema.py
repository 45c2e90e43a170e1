"""The case format as JSON Schema, for editors: made of the same specs that read a case, key by key.

Draft 7 is what YAML plugins know best. It sees one value at a time: whether names are those of bodies and cracks, and
what geometry asks, the reader alone can tell. Never does it refuse what the reader accepts.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, Final

from crackgrow.case.format import CASE
from crackgrow.case.overrides import BESIDE
from crackgrow.case.scalars import Schema, Schemas

DRAFT: Final = "http://json-schema.org/draft-07/schema#"


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
    schemas = Schemas()
    body = schemas.of(spec)
    return {**body, **({"definitions": schemas.definitions} if schemas.definitions else {})}
