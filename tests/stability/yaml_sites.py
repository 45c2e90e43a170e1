"""Where the keys and values of a YAML text stand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import yaml


@dataclass(frozen=True, slots=True)
class Site:
    """A value in a text, from `start` to `end`, and its key, which begins at `key_start` if it has one."""

    start: int
    end: int
    scalar: bool
    key: str = ""
    key_start: int = -1
    key_end: int = -1
    column: int = 0  # of the key
    flow: bool = False  # in braces
    parent: str = ""  # the key of the mapping that the key is in


@lru_cache(maxsize=64)
def sites(text: str) -> tuple[Site, ...]:
    """All values of a good case."""
    return tuple(_sites(yaml.compose(text, Loader=yaml.SafeLoader), ""))


def _sites(node: yaml.Node, parent: str) -> Iterator[Site]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            span = (key.start_mark.index, key.end_mark.index, key.start_mark.column, bool(node.flow_style))
            inner = (value.start_mark.index, value.end_mark.index, isinstance(value, yaml.ScalarNode))
            yield Site(*inner, key.value, *span, parent)
            yield from _sites(value, key.value)
    elif isinstance(node, yaml.SequenceNode):
        for value in node.value:
            yield Site(value.start_mark.index, value.end_mark.index, isinstance(value, yaml.ScalarNode))
            yield from _sites(value, "")
