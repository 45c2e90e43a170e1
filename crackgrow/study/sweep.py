"""A sweep: every combination of its values with its case, checked before anything starts, and run."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.case import Case
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import is_number
from crackgrow.errors import CaseError, Fault
from crackgrow.study.plan import CaseFile, Run, Study, folder_names
from crackgrow.study.runner import locked, run_study
from crackgrow.study.sweep_file import SweepFile, read_sweep_file
from crackgrow.study.table import TAKEN, Row, response_columns
from crackgrow.study.workers import Workers

Combination = tuple[str, ...]
"""A value of each parameter, in the order of the file."""

MOST_FAULTS: Final = 20  # that are told where no combination is a case
REFERENCE: Final = "reference"  # begins the name of a run that others are held against
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


def plan_sweep(path: str | Path, folder: str | Path | None = None) -> Study:
    """Read a sweep file and check every combination.

    folder: of the results; default outputs/<name of the file>

    Combinations that the case refuses are part of the plan; behind them come the runs that they are held against.
    Raises CaseError with all faults of the file, with those that all combinations share, such as a key that doesn't
    exist, and where there is no combination left.
    """
    path = Path(path)
    folder = Path("outputs") / path.stem if folder is None else Path(folder)
    file = read_sweep_file(path)
    keys, names = tuple(file.parameters), short_names(tuple(file.parameters))
    given = [dict(zip(keys, values, strict=True)) for values in combinations(file)]
    tried = [_case_file(file, settings).tried() for settings in given]
    finer: dict[Combination, dict[str, str]] = {}
    for settings, (case, _) in zip(given, tried, strict=True):
        if file.reference and case is not None:
            held = {**settings, **file.reference}
            finer.setdefault(tuple(held.values()), held)
    tried += [_case_file(file, settings).tried() for settings in finer.values()]
    settings_of = [*given, *finer.values()]
    titles = [_name(names, [settings[key] for key in keys]) for settings in settings_of]
    titles[len(given) :] = [f"{REFERENCE} {title}" for title in titles[len(given) :]]
    places = {held: len(given) + number for number, held in enumerate(finer)}
    runs = []
    for number, (settings, (case, faults), words) in enumerate(
        zip(settings_of, tried, folder_names(titles), strict=True)
    ):
        refusal = "; ".join(f"{fault.key}: {fault.message}" if fault.key else fault.message for fault in faults)
        against = places.get(tuple({**settings, **file.reference}.values())) if number < len(given) else None
        values = tuple(settings[key] for key in keys)
        one = _case_file(file, settings)
        runs.append(Run(number, titles[number], folder / words, values, one, case, refusal, against))
    refused = [faults for _, faults in tried]
    for group in (refused[: len(given)], refused[len(given) :]):
        shared = [fault for fault in group[0] if all(fault in faults for faults in group)] if group else []
        if group and (shared or all(group)):
            every = shared or list(dict.fromkeys(fault for faults in group for fault in faults))[:MOST_FAULTS]
            raise CaseError(_placed(file, every))
    _check_responses(file, [run.case for run in runs if run.case is not None])
    title = next(run.case.title for run in runs if run.case is not None)
    return Study("sweep", path.stem, title, folder, names, tuple(runs), file.responses)


def sweep(
    study: Study,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    memory: str | None = None,
    timeout: float | None = None,
    resume: bool = False,
) -> Iterator[Row]:
    """Run what is planned and yield the row of each run as it ends, then draw the picture.

    workers: processes of this machine; default: one a core
    scheduler: address of a Dask scheduler whose workers, however many, are used instead; they must see the same disk
    memory: such as "2GB", of each run
    timeout: seconds after which a run is given up
    resume: leave runs alone that are done, and go on with those that were broken off

    Raises CaseError (a wrong `memory` or `scheduler`), LockedError where another study writes into the folder,
    ClusterError and OutputError; what has ended is in the table then. A run that fails is a row like any other.
    """
    there = Workers.of(workers, scheduler, memory, timeout)
    with locked(study):
        table = yield from run_study(study, there, resume)
        from crackgrow.study.pictures import draw_sweep  # here: it loads matplotlib

        draw_sweep(study.folder / "sweep.png", table)


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


def _case_file(file: SweepFile, settings: Mapping[str, str]) -> CaseFile:
    return CaseFile(file.base, (*file.fixed, *(f"{key}={value}" for key, value in settings.items())))


def _name(names: Sequence[str], values: Sequence[str]) -> str:
    """What a run is called: "angle=30 friction=0.2"."""
    return " ".join(f"{name}={_shown(value)}" for name, value in zip(names, values, strict=True))


def _shown(value: str) -> str:
    if is_number(value):
        return f"{float(value):.6g}"
    return value if _WORDS.search(value) else EMPTY


def _check_responses(file: SweepFile, cases: Sequence[Case]) -> None:
    known, faults = response_columns(cases, bool(file.reference)), []
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
        place = (
            file.places.get(("parameters", key)) or file.places.get(("reference", key)) or file.places.get(("set", key))
        )
        if fault.source.startswith(_FROM_OVERRIDE) and place is not None:
            found.append(replace(fault, source=place.source, line=place.line))
        else:
            found.append(fault)
    return sorted(found, key=lambda fault: fault.line or 0)
