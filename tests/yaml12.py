"""YAML 1.2 as editors read it: `on` and `yes` are words, 1e5 is a number, a key that is given twice is a fault."""

from __future__ import annotations

import re
from typing import Any

import yaml

MOST_ALIASES = 8  # editors stop at what aliases expand to


class _Core(yaml.SafeLoader):
    """Resolves plain scalars by the core schema of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012  (as in its base)

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.n_aliases = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        self.n_aliases += self.check_event(yaml.AliasEvent)
        if self.n_aliases > MOST_ALIASES:
            raise yaml.composer.ComposerError(None, None, "too many aliases", self.peek_event().start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [str(key.value) for key, _ in node.value]  # as texts, whatever they look like
        if len(set(keys)) < len(keys):
            raise yaml.constructor.ConstructorError(None, None, "a key is given twice", node.start_mark)
        return {key: self.construct_object(value, deep=True) for key, (_, value) in zip(keys, node.value, strict=True)}


def _number(loader: _Core, node: yaml.ScalarNode) -> float:
    text = node.value.lower()
    return (
        float(int(text, 0))
        if text.startswith(("0x", "0o"))
        else float(text.replace(".inf", "inf").replace(".nan", "nan"))
    )


_NUMBER = (
    r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|0x[0-9a-fA-F]+|0o[0-7]+|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
)
for _tag, _pattern, _first in (
    ("float", _NUMBER, "-+0123456789."),
    ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
):
    _Core.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first))
_Core.add_constructor("tag:yaml.org,2002:float", _number)


def read_yaml12(text: str) -> Any:
    """The document as JSON values; keys are texts. Raises yaml.YAMLError."""
    return yaml.load(text, Loader=_Core)
