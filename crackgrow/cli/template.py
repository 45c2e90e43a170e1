"""Commented cases to start from, which lie beside this file."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

SCHEMA_FILE: Final = "case.schema.json"
"""What the JSON Schema is called where it lies beside cases."""

MODELINE: Final = f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
"""First line of a case that tells editors where its schema is."""

_SUFFIX: Final = ".yaml"
_FOLDER: Final = files("crackgrow.cli") / "templates"


def templates() -> dict[str, str]:
    """What each template is, in a line, by its name."""
    names = sorted(file.name.removesuffix(_SUFFIX) for file in _FOLDER.iterdir() if file.name.endswith(_SUFFIX))
    return {name: template_text(name).splitlines()[0].removeprefix("# ") for name in names}


def template_text(name: str) -> str:
    """The text of a template; its name must be one of `templates`."""
    return (_FOLDER / f"{name}{_SUFFIX}").read_text(encoding="utf-8")
