"""A case from a mapping, as a mapping, and with other settings: what `Case` offers in Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePath
from typing import Any

import numpy as np
import yaml

from crackgrow.case.dump import dump_case, yaml_text
from crackgrow.case.load import read_case
from crackgrow.case.model import Case
from crackgrow.errors import CaseError, Fault

SOURCE = "the mapping"  # in faults, in place of a file


def case_from(mapping: Mapping[str, Any], name: str) -> Case:
    """Return the checked case of a mapping in the case format; file names in it are relative to the working folder.

    Raises CaseError with every fault, TypeError where the mapping holds what YAML cannot.
    """
    if not isinstance(mapping, Mapping):
        raise TypeError(f"a mapping in the case format is wanted, not {type(mapping).__name__}")
    return _without_lines(yaml_text(_plain(mapping, "")), name, ())


def mapping_of(case: Case) -> dict[str, Any]:
    """Return a case as a mapping in the case format: SI, every default filled in, the caller's own."""
    found: dict[str, Any] = yaml.safe_load(dump_case(case))
    return found


def changed(case: Case, settings: Sequence[str]) -> Case:
    """Return a case with settings such as "numerics.spacing=1 mm"; bare numbers are in SI.

    A spacing that was automatic follows from the case as it is then.
    """
    mapping = mapping_of(case)
    if mapping["numerics"].pop("auto_rule", None) is not None:
        mapping["numerics"]["spacing"] = "auto"
    return _without_lines(yaml_text(mapping), case.name, settings)


def _without_lines(text: str, name: str, settings: Sequence[str]) -> Case:
    """The case of a text that nobody has seen: its faults name no lines."""
    try:
        return read_case(text, SOURCE, name, settings)
    except CaseError as error:
        raise CaseError([Fault(fault.source, None, fault.key, fault.message) for fault in error.faults]) from None


def _plain(value: object, key: str) -> object:
    """A value as YAML takes it, arrays as lists."""
    if isinstance(value, Mapping):
        return {str(name): _plain(inner, f"{key}.{name}" if key else str(name)) for name, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), key)
    if isinstance(value, list | tuple):
        return [_plain(inner, f"{key}.{number}") for number, inner in enumerate(value)]
    if isinstance(value, PurePath):
        return str(value)
    if value is None or isinstance(value, str | int | float):
        return value
    raise TypeError(f"{key}: {type(value).__name__} given; wanted: a number, a text, true, false, a list or a mapping")
