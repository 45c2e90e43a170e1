"""Mappings and lists that are handed out to be read: nobody changes a case from outside."""

from __future__ import annotations

from typing import Any, NoReturn

import yaml


def _refuse(self: object, *_: object, **__: object) -> NoReturn:
    raise TypeError("a case cannot be changed; load it with overrides, or change a copy.deepcopy of this")


class ReadOnlyDict(dict[str, object]):
    """A mapping whose values are read-only, too; a deep copy of it is an ordinary dict."""

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return read_only, (writable(self),)

    def __deepcopy__(self, memo: dict[int, Any]) -> dict[str, object]:
        copied: dict[str, object] = writable(self)
        return copied


class ReadOnlyList(list[object]):
    """A list whose items are read-only, too; a deep copy of it is an ordinary list."""

    __setitem__ = __delitem__ = __iadd__ = __imul__ = _refuse
    append = clear = extend = insert = pop = remove = reverse = sort = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return read_only, (writable(self),)

    def __deepcopy__(self, memo: dict[int, Any]) -> list[object]:
        copied: list[object] = writable(self)
        return copied


def read_only(value: Any) -> Any:
    """The same value with all its mappings and lists read-only."""
    if isinstance(value, dict):
        return ReadOnlyDict({key: read_only(item) for key, item in value.items()})
    return ReadOnlyList(map(read_only, value)) if isinstance(value, list) else value


def writable(value: Any) -> Any:
    """The same value with ordinary mappings and lists."""
    if isinstance(value, dict):
        return {key: writable(item) for key, item in value.items()}
    return [writable(item) for item in value] if isinstance(value, list) else value


yaml.SafeDumper.add_representer(ReadOnlyDict, yaml.SafeDumper.represent_dict)
yaml.SafeDumper.add_representer(ReadOnlyList, yaml.SafeDumper.represent_list)
