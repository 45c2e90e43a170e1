"""A case as a flat list of settings, to say how two of them differ."""

from __future__ import annotations

from typing import Any

import yaml


def read_settings(text: str) -> dict[str, str]:
    """The settings of a case as YAML text, by dotted key; lists of numbers and words are one value."""
    flat: dict[str, str] = {}

    def put(key: str, value: Any) -> None:
        if isinstance(value, dict) and value:
            for name, inner in value.items():
                put(f"{key}.{name}" if key else str(name), inner)
        elif isinstance(value, list) and any(isinstance(inner, dict | list) for inner in value):
            for number, inner in enumerate(value):
                put(f"{key}.{number}", inner)
        else:
            flat[key] = str(value)

    put("", yaml.safe_load(text))
    return flat
