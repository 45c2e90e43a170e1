"""What a sweep is going to run: every combination of its values with its case, checked before anything starts."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.case import Case
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import is_number
from crackgrow.errors import CaseError, Fault
from crackgrow.study.setting import CaseFile, folder_names
from crackgrow.study.sweep.columns import TAKEN, response_columns
from crackgrow.study.sweep.sweep_file import SweepFile, read_sweep_file

Combination = tuple[str, ...]
"""A value of each parameter, in the order of the file."""

MOST_FAULTS: Final = 20  # that are told where no combination is a case
EMPTY: Final = "none"  # in the name of a run: a value such as {}
_WORDS: Final = re.compile(r"\w")
_FROM_OVERRIDE: Final = "--set "


def combinations(file: SweepFile) -> list[Combination]:
    """What is run: of a grid, the first parameter varies slowest."""
    if file.design == "latin_hypercube":
        assert file.samples is not None  # the reader has seen to it
        return _latin_hypercube(file, file.samples)
    columns = [values.texts for values in file.parameters.values()]
    return list(zip(*columns, strict=True)) if file.design == "zip" else list(itertools.product(*columns))


def _latin_hypercube(file: SweepFile, samples: int) -> list[Combination]:
    """As many runs as samples: of each parameter, every one of `samples` equal parts of its range is met once.

    McKay, Beckman, Conover 1979: parts in random order, a random place in each.
    """
    rng = np.random.default_rng(file.seed)
    columns = []
    for values in file.parameters.values():
        parts = (rng.permutation(samples) + rng.random(samples)) / samples
        columns.append(values.at(parts))
    return list(zip(*columns, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One combination."""

    number: int
    name: str  # "angle=30 friction=0.2"
    folder: Path
    values: tuple[str, ...]  # of the parameters
    case: Case | None  # None where the combination is no case
    refusal: str  # why not


@dataclass(frozen=True, slots=True, eq=False)
class SweepPlan:
    """All runs of a sweep."""

    name: str
    title: str  # of the base case
    folder: Path
    parameters: tuple[str, ...]  # short names of the keys
    runs: tuple[Run, ...]
    responses: tuple[str, ...] | None  # columns that the picture shows; None: it chooses


def plan_sweep(path: str | Path, folder: str | Path | None = None) -> SweepPlan:
    """Read a sweep file and check every combination.

    folder: of the results; default outputs/<name of the file>

    Combinations that the case refuses are part of the plan. Raises CaseError with all faults of the file, with those
    that all combinations share, such as a key that doesn't exist, and where there is no combination left.
    """
    path = Path(path)
    folder = Path("outputs") / path.stem if folder is None else Path(folder)
    file = read_sweep_file(path)
    names = short_names(tuple(file.parameters))
    base, runs, refused = CaseFile(file.base, file.fixed), [], []
    combined = combinations(file)
    shown = ([f"{name}={_shown(v)}" for name, v in zip(names, values, strict=True)] for values in combined)
    run_names = [" ".join(words) for words in shown]
    for number, (name, words, values) in enumerate(zip(run_names, folder_names(run_names), combined, strict=True)):
        overrides = [f"{key}={value}" for key, value in zip(file.parameters, values, strict=True)]
        case, faults = base.tried(*overrides)
        refusal = "; ".join(f"{fault.key}: {fault.message}" if fault.key else fault.message for fault in faults)
        runs.append(Run(number, name, folder / words, values, case, refusal))
        refused.append(faults)
    shared = [fault for fault in refused[0] if all(fault in faults for faults in refused)]
    if shared or all(refused):
        every = shared or list(dict.fromkeys(fault for faults in refused for fault in faults))[:MOST_FAULTS]
        raise CaseError(_placed(file, every))
    _check_responses(file, [run.case for run in runs if run.case is not None])
    title = next(run.case.title for run in runs if run.case is not None)
    return SweepPlan(path.stem, title, folder, names, tuple(runs), file.responses)


def short_names(keys: Sequence[str]) -> tuple[str, ...]:
    """The last parts of the keys, as many as tell them apart, and from the other columns of the table."""
    return tuple(_shortest(key, [other for other in keys if other != key]) for key in keys)


def _shortest(key: str, others: Iterable[str]) -> str:
    parts = key.split(".")
    for n in range(1, len(parts)):
        tail = ".".join(parts[-n:])
        if tail not in TAKEN and not any(other == tail or other.endswith(f".{tail}") for other in others):
            return tail
    return key


def _shown(value: str) -> str:
    if is_number(value):
        return f"{float(value):.6g}"
    return value if _WORDS.search(value) else EMPTY


def _check_responses(file: SweepFile, cases: Sequence[Case]) -> None:
    known, faults = response_columns(cases), []
    for index, name in enumerate(file.responses or ()):
        if name not in known:
            line = file.places["responses", index].line
            message = (
                f"{quoted(name)} is no column of the table{did_you_mean(name, known)}; there are {', '.join(known)}"
            )
            faults.append(Fault(str(file.path), line, f"responses.{index}", message))
    if faults:
        raise CaseError(faults)


def _placed(file: SweepFile, faults: Iterable[Fault]) -> list[Fault]:
    """The faults of values with the line of the sweep file that gives them."""
    found = []
    for fault in faults:
        key = fault.source.removeprefix(_FROM_OVERRIDE)
        place = file.places.get(("parameters", key)) or file.places.get(("set", key))
        if fault.source.startswith(_FROM_OVERRIDE) and place is not None:
            found.append(replace(fault, source=place.source, line=place.line))
        else:
            found.append(fault)
    return sorted(found, key=lambda fault: fault.line or 0)
