"""A sweep: every combination of its values with its case, checked before anything starts, and run."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.case import Case
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import is_number
from crackgrow.errors import CaseError, Fault
from crackgrow.results.lock import locked
from crackgrow.study.plan import Run, Study, folder_names
from crackgrow.study.runs import TAKEN, Row, response_columns, run_study
from crackgrow.study.sweep_file import SweepFile, placed, read_sweep_file
from crackgrow.study.workers import Workers

Combination = tuple[str, ...]
"""A value of each parameter, in the order of the file."""

MOST_FAULTS: Final = 20  # that are told where no combination is a case
REFERENCE: Final = "reference"  # begins the name of a run that others are held against
EMPTY: Final = "none"  # in the name of a run: a value such as {}
_WORDS: Final = re.compile(r"\w")


def combinations(file: SweepFile) -> list[Combination]:
    """What is run: of a grid, the first parameter varies slowest.

    Of a Latin hypercube of n samples every one of n equal parts of the range of each parameter is met once, in random
    order and at a random place in it (McKay, Beckman, Conover 1979).
    """
    parameters = file.parameters.values()
    if file.samples is not None:
        n, rng = file.samples, np.random.default_rng(file.seed)
        return list(zip(*(values.at((rng.permutation(n) + rng.random(n)) / n) for values in parameters), strict=True))
    columns = [values.texts for values in parameters]
    return list(zip(*columns, strict=True)) if file.design == "zip" else list(itertools.product(*columns))


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
    settings = [dict(zip(file.parameters, values, strict=True)) for values in combinations(file)]
    runs = _runs(file, folder, settings)
    if file.reference:
        held = [{**given, **file.reference} for given in settings]  # what each is held against
        finer = {tuple(its.values()): its for its, run in zip(held, runs, strict=True) if run.case}  # each once
        numbers = {values: number for number, values in enumerate(finer, len(runs))}
        runs = [replace(run, reference=numbers.get(tuple(its.values()))) for its, run in zip(held, runs, strict=True)]
        runs += _runs(file, folder, [*finer.values()], len(runs))
    cases = [run.case for run in runs if run.case is not None]
    _check_responses(file, cases)
    names = short_names(tuple(file.parameters))
    return Study("sweep", path.stem, cases[0].title, folder, names, tuple(runs), file.responses)


def _runs(file: SweepFile, folder: Path, settings: Sequence[dict[str, str]], first: int = 0) -> list[Run]:
    """Runs with these values of keys; of references, which come behind others, with the number of the first one."""
    names, runs = short_names(tuple(file.parameters)), []
    values = [tuple(given[key] for key in file.parameters) for given in settings]
    titles = [f"{REFERENCE} {_name(names, texts)}" if first else _name(names, texts) for texts in values]
    for n, words in enumerate(folder_names(titles)):
        case_file = file.case_file(settings[n])
        runs.append(Run(first + n, titles[n], folder / words, values[n], case_file, *case_file.tried()))
    _refuse_all(file, [run.faults for run in runs])
    return runs


def _refuse_all(file: SweepFile, refused: list[tuple[Fault, ...]]) -> None:
    """Raise CaseError with the faults that all of some runs share, or with some of all where no run is left."""
    shared = [fault for fault in refused[0] if all(fault in faults for faults in refused)] if refused else []
    if refused and all(refused):
        shared = shared or list(dict.fromkeys(fault for faults in refused for fault in faults))[:MOST_FAULTS]
    if not shared:
        return
    raise CaseError(sorted(placed(file, shared), key=lambda fault: fault.line or 0))


def _check_responses(file: SweepFile, cases: Sequence[Case]) -> None:
    known, faults = response_columns(cases, bool(file.reference)), []
    for index, name in enumerate(file.responses or ()):
        if name not in known:
            line, near = file.places["responses", index].line, did_you_mean(name, known)
            message = f"{quoted(name)} is no column of the table{near}; there are {', '.join(known)}"
            faults.append(Fault(str(file.path), line, f"responses.{index}", message))
    if faults:
        raise CaseError(faults)


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
    there = Workers(workers, scheduler, memory, timeout)
    with locked(study.folder, study.words):
        table = yield from run_study(study, there, resume)
        from crackgrow.study.pictures import draw_sweep  # here: it loads matplotlib

        draw_sweep(study.folder / "sweep.png", table)


def short_names(keys: Sequence[str]) -> tuple[str, ...]:
    """The last parts of the keys, as many as tell them apart, and from the other columns of the table."""

    def shortest(key: str) -> str:
        parts, others = key.split("."), [f".{other}" for other in keys if other != key]
        tails = (".".join(parts[-n:]) for n in range(1, len(parts)))
        known = (t for t in tails if t not in TAKEN and not any(other.endswith(f".{t}") for other in others))
        return next(known, key)

    return tuple(map(shortest, keys))


def _name(names: Sequence[str], values: Sequence[str]) -> str:
    """What a run is called: "angle=30 friction=0.2"; a value without any letter or digit, such as {}, is EMPTY."""
    shown = (f"{float(v):.6g}" if is_number(v) else v if _WORDS.search(v) else EMPTY for v in values)
    return " ".join(f"{name}={value}" for name, value in zip(names, shown, strict=True))
