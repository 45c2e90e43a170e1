"""A case as YAML text that reads back to the same case, bit for bit; as a mapping, as `Case` offers it in Python; and
in words what was changed when it was read."""

from __future__ import annotations

from collections.abc import Mapping as AnyMapping
from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from pathlib import PurePath
from typing import Any, TypeVar

import numpy as np
import yaml

from crackgrow.case.format import CASE, FORMAT
from crackgrow.case.load import REDUCTION, read_case
from crackgrow.case.model import Case, CriticalLoad
from crackgrow.case.units import Coordinate, Metres, place_text
from crackgrow.errors import CaseError, Fault

T = TypeVar("T")


class _Loader(yaml.SafeLoader):
    """Keeps all digits of coordinates on a map."""


_Loader.add_constructor("tag:yaml.org,2002:float", lambda _, node: Coordinate.of_text(str(node.value)))


class _Dumper(yaml.SafeDumper):
    """Writes equal lists out instead of naming them once and pointing to them."""

    def ignore_aliases(self, data: object) -> bool:
        return True


_Dumper.add_representer(Coordinate, lambda its, value: its.represent_scalar("tag:yaml.org,2002:float", value.text))


def dump_case(case: Case) -> str:
    """Return the case as YAML: SI units, every default filled in, floats with all their digits.

    All that is not drawn is written as the fields of the case have it. Raises CaseError where the geometry is another
    one than was read: it cannot be written.
    """
    return yaml_text(written(_read_back(case)))


def mapping_of(case: Case) -> dict[str, Any]:
    """The same as a mapping, of which `case_from` makes the same case."""
    found: dict[str, Any] = yaml.load(dump_case(case), _Loader)  # a SafeLoader
    return found


def _read_back(case: Case) -> Case:
    """The case as it reads back from its text. Raises CaseError where that is another one."""
    again = _without_lines(yaml_text(written(case)), "the case as it is", case.name)
    changed = [
        part.name
        for part in fields(case)
        if part.name not in ("moved", "cut") and not _same(getattr(case, part.name), getattr(again, part.name))
    ]
    if changed:
        remedy = "change the case file, or load it with overrides such as 'cracks.flaw.path.angle=30'"
        message = f"differs from what was read, and cannot be written: {remedy}"
        raise CaseError([Fault("the case as it is", None, name, message) for name in changed])
    return again


def yaml_text(resolved: object) -> str:
    """A mapping as YAML, equal lists written out."""
    return str(
        yaml.dump(resolved, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100)
    )


def written(case: Case) -> dict[str, Any]:
    """The case as a mapping in its format, whether or not it reads back: what is drawn as it was given."""
    as_given = tuple(interface for interface in case.interfaces if not interface.beside_crack)
    found = FORMAT.written(replace(case, interfaces=as_given))
    units = {"length": "m", "stress": "Pa", **({"origin": list(case.origin)} if any(case.origin) else {})}
    loading = found["loading"] or ("critical" if isinstance(case.loading, CriticalLoad) else REDUCTION)
    every = {**found, "units": units, "loading": loading}
    return {key: every[key] for key in CASE.fields if key in every}


def _same(one: Any, other: Any) -> bool:
    """Whether two parts of a case are equal, number by number; the rule of a spacing follows from the rest."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and np.array_equal(one, other)
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(_same, one, other))
    if is_dataclass(one) and not isinstance(one, type):
        if hasattr(one, "auto_rule") and hasattr(other, "auto_rule"):
            one, other = replace(one, auto_rule=None), replace(other, auto_rule=None)
        return type(one) is type(other) and all(
            _same(getattr(one, part.name), getattr(other, part.name)) for part in fields(one)
        )
    return bool(one == other)


def case_from(mapping: AnyMapping[str, Any], name: str) -> Case:
    """Return the checked case of a mapping in the case format; file names in it are relative to the working folder.

    Raises CaseError with every fault, TypeError where the mapping holds what YAML cannot.
    """
    if not isinstance(mapping, AnyMapping):
        raise TypeError(f"a mapping in the case format is wanted, not {type(mapping).__name__}")
    return _without_lines(yaml_text(_plain(mapping, "")), "the mapping", name)


def changed(case: Case, settings: Sequence[str]) -> Case:
    """Return a case with settings such as "numerics.spacing=1 mm"; bare numbers are in SI.

    A spacing that was automatic follows from the case as it is then.
    """
    mapping = written(_read_back(case))  # not what YAML makes of its text: coordinates on a map keep all their digits
    if mapping["numerics"].pop("auto_rule", None) is not None:
        mapping["numerics"]["spacing"] = "auto"
    return _without_lines(yaml_text(mapping), "the mapping", case.name, settings)


def _without_lines(text: str, source: str, name: str, settings: Sequence[str] = ()) -> Case:
    """The case of a text that nobody has seen: its faults name no lines."""
    try:
        return read_case(text, source, name, settings)
    except CaseError as error:
        raise CaseError([Fault(fault.source, None, fault.key, fault.message) for fault in error.faults]) from None


def _plain(value: object, key: str) -> object:
    """A value as YAML takes it, arrays as lists; keys that YAML 1.1 has made truth values of in YAML's words."""
    if isinstance(value, AnyMapping):
        named = {str(name).lower() if isinstance(name, bool) else str(name): inner for name, inner in value.items()}
        return {name: _plain(inner, f"{key}.{name}" if key else name) for name, inner in named.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), key)
    if isinstance(value, list | tuple):
        return [_plain(inner, f"{key}.{number}") for number, inner in enumerate(value)]
    if isinstance(value, PurePath):
        return str(value)
    if value is None or isinstance(value, str | int | float):
        return value
    raise TypeError(f"{key}: {type(value).__name__} given; wanted: a number, a text, true, false, a list or a mapping")


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


def differing(a: AnyMapping[str, str], b: AnyMapping[str, str], missing: T) -> dict[str, tuple[str | T, str | T]]:
    """The values in both of the settings that are not the same, by dotted key; `missing` stands for one not given."""
    keys = [key for key in dict.fromkeys([*a, *b]) if a.get(key) != b.get(key)]
    return {key: (a.get(key, missing), b.get(key, missing)) for key in keys}


def changes_of(case: Case) -> tuple[list[str], list[str]]:
    """What was moved when the case was read, and what of cracks was left out, the largest first."""
    moved, left = [], []
    for move in sorted(case.moved, key=lambda move: -move.distance):
        there = place_text(np.add(move.place, case.origin), 12)
        moved.append(f"{move.what} by {Metres(move.distance):.2g} onto {move.onto} at {there}")
    for part in sorted(case.cut, key=lambda part: (not part.whole, -part.length)):
        crack = f"'{part.crack}'{f' ({part.where})' if part.where else ''}"
        much = "all of " if part.whole else f"{Metres(part.length):.3g} of " if part.length else ""
        left.append(f"{much}{crack} at {place_text(np.add(part.place, case.origin))}: {part.why}")
    return moved, left
