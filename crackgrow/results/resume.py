"""Checkpoints, and where a run that was broken off goes on: at the newest one in its folder, if the case is the same.

What may differ are settings that have no part in the results so far: title, source, pictures, the number of growth
steps, and the load factors or stages to come.

A file checkpoint/step_NNNN.npz holds what the loop needs to make its step again (`crackgrow.run.checkpoint`), and how
far the result files went before that step. It is an npz archive of plain arrays and one text in JSON (UTF-8 in the
array `header`), whose numbers may be NaN; reading it executes nothing. Every member has a checksum. The header has

    format     number of this format
    program    version and git commit of the program that wrote it
    case       name of the case and its resolved YAML
    step       number of the step
    run        values of the loop; its arrays are the other members of the archive
    results    see `RunWriter`
"""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib.npyio import NpzFile

from crackgrow import __version__
from crackgrow.case import dump_case
from crackgrow.case.dump import differing, read_settings
from crackgrow.case.load import read_case
from crackgrow.case.model import Case, LoadHistory, Stages
from crackgrow.errors import CaseError, CrackgrowError
from crackgrow.results.atomic import OutputError, remove_files, write_atomically
from crackgrow.results.folder import CHECKPOINT, FACES, FRAME, RunFolder, of_step, own_files
from crackgrow.results.summary import program_commit
from crackgrow.results.tables import lines_before
from crackgrow.results.units import cut
from crackgrow.run.result import Checkpoint

FORMAT: Final = 11
KEYS: Final = {"format", "program", "case", "step", "run", "results"}  # of the header
FLUSHED_EVERY: Final = 1.0  # s: so often a checkpoint is flushed to the disk, which can take longer than a small step

FREE: Final = ("title", "source", "output.figures", "output.report", "growth.steps")
MOST_DIFFERENCES: Final = 20  # that are told
NOT_GIVEN: Final = "not given"  # in place of a value


class DamagedError(ValueError):
    """A checkpoint that can't be read; the message says why."""


class ResumeError(CrackgrowError):
    """A run that can't be gone on with; the message says why."""

    exit_code = 2


@dataclass(frozen=True, slots=True, eq=False)
class Resumption:
    """Where a run goes on."""

    checkpoint: Checkpoint  # what the loop goes on from
    results: Mapping[str, Any]  # how far the result files went
    finished: str | None  # how the run has ended, if there is nothing left to do
    remarks: tuple[str, ...]  # what the user should know


class CheckpointWriter:
    """Writes the checkpoints of one run, and removes old ones.

    A killed program leaves each of them whole; a loss of power too leaves those that were flushed to the disk.
    """

    def __init__(self, folder: Path, case_name: str, settings: str) -> None:
        """`settings` is the resolved case as YAML."""
        self._folder, self._case = folder, {"name": case_name, "settings": settings}
        self._flushed = -1  # the step of the last one that was
        self._when = -FLUSHED_EVERY  # s

    def write(self, checkpoint: Checkpoint, results: Mapping[str, Any]) -> None:
        """Write a checkpoint; then remove all but this one, the one before and the last that was flushed.

        Raises OutputError.
        """
        step, now = checkpoint.step, time.monotonic()
        flush = now - self._when >= FLUSHED_EVERY
        program = {"version": __version__, "commit": program_commit()}
        header = {"format": FORMAT, "program": program, "case": self._case, "step": step}
        header |= {"run": dict(checkpoint.values), "results": results}
        told = np.frombuffer(json.dumps(header, ensure_ascii=False).encode(), dtype=np.uint8)
        arrays: dict[str, Any] = {"header": told, **checkpoint.arrays}

        path = self._folder / of_step(CHECKPOINT, step)
        write_atomically(path, lambda temporary: np.savez(temporary, **arrays), durable=flush)
        if flush:
            self._flushed, self._when = step, now
        before = [older for older in steps_with_checkpoint(self._folder) if older < step][:1]
        kept = {self._folder / of_step(CHECKPOINT, number) for number in (step, *before, self._flushed)}
        remove_files({own.path for own in own_files(self._folder, names=[CHECKPOINT])} - kept)


def steps_with_checkpoint(folder: Path) -> list[int]:
    """The steps whose checkpoints are in the run's folder, the newest first."""
    return sorted((own.step for own in own_files(folder, names=[CHECKPOINT]) if own.whole), reverse=True)


def is_checkpoint(path: Path) -> bool:
    """Whether a file is a checkpoint of this program, of whatever version."""
    try:
        header, _ = _read(path)
    except (OutputError, DamagedError):
        return False
    return header.keys() >= KEYS


def _read(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Header and arrays of a checkpoint. Raises DamagedError, and OutputError where the system refuses."""
    try:
        with path.open("rb") as file, NpzFile(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(arrays.pop("header").tobytes())
        if not isinstance(header, dict):
            raise ValueError("its header is no mapping")
        if header.get("format") == FORMAT and (missing := KEYS - header.keys()):
            raise ValueError(f"its header has no {', '.join(sorted(missing))}")
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error
    except (zipfile.BadZipFile, ValueError, KeyError, EOFError, RecursionError) as error:
        raise DamagedError(f"{path} is damaged: {error}") from error
    return header, arrays


def find_resumption(case: Case, folder: Path) -> Resumption | None:
    """Where the run in `folder` goes on with the case; None: it has not got as far as a step.

    Raises ResumeError where the case is another one, or the files are not those that a checkpoint goes with.
    """
    remarks = []
    for step in steps_with_checkpoint(folder):
        path = folder / of_step(CHECKPOINT, step)
        try:
            header, arrays = _read(path)
        except DamagedError as error:
            remarks.append(str(error))
            continue
        found = header.get("format")
        if found != FORMAT:
            remarks.append(f"{path} has format {found}, this is crackgrow {__version__}: wanted {FORMAT}")
            continue
        results = header["results"]
        missing = _missing(folder, step, results)
        if missing:
            remarks.append(f"the checkpoint of step {step} does not fit {', '.join(missing)}")
            continue
        checkpoint = Checkpoint(step, header["run"], arrays)
        then = {"name": header["case"]["name"], **read_settings(header["case"]["settings"])}
        differences = differing(then, {"name": case.name, **read_settings(dump_case(case))}, NOT_GIVEN)
        run = RunFolder(folder)
        if not differences and run.finished:
            return Resumption(checkpoint, results, f"{run.status}: {run.reason}", ())
        _check_same(case, folder, step, header["case"], differences)
        theirs, ours = header["program"], {"version": __version__, "commit": program_commit()}
        if theirs != ours:
            words = [f"{of['version']} ({of['commit']})" if of["commit"] else of["version"] for of in (theirs, ours)]
            what = "not the same bits as an unbroken run's, perhaps"
            remarks.append(f"begun by crackgrow {words[0]}, gone on with by {words[1]}: {what}")
        return Resumption(checkpoint, results, None, tuple(remarks))
    if remarks:
        raise ResumeError(f"{folder} has nothing to go on from: {'; '.join(remarks)}; run without --resume")
    if RunFolder(folder).n_rows("steps"):
        raise ResumeError(f"{folder} has results but no checkpoint to go on from; run without --resume")
    return None


def _missing(folder: Path, step: int, results: Mapping[str, Any]) -> list[str]:
    """Result files that a checkpoint counts on and that are not there, or without rows of the steps before it."""
    missing = []
    for name, n_rows in results["tables"].items():
        table = folder / f"{name}.csv"
        try:
            fits = len(lines_before(table, step)) - 1 == n_rows
        except (OSError, ValueError):
            fits = False
        missing += [] if fits else [table.name]
    series = ((FRAME, results["tally"]["frames"]), (FACES, results["tally"]["cracks"]))
    frames = [of_step(name, number) for name, numbers in series for number in numbers]
    return missing + [name for name in frames if not (folder / name).is_file()]


def _check_same(
    case: Case, folder: Path, step: int, stored: Mapping[str, str], differences: Mapping[str, tuple[str, str]]
) -> None:
    """Raise ResumeError where the case is not that of the checkpoint, as far as its results go.

    stored: its name and its settings
    differences: values then and now, by dotted key
    """
    changed = {key: values for key, values in differences.items() if key not in FREE}
    then, _ = changed.get("loading.history", (NOT_GIVEN, ""))
    if case.growth is None and isinstance(case.loading, LoadHistory) and then != NOT_GIVEN:
        if case.loading.factors[: step + 1] == tuple(json.loads(then)[: step + 1]):  # nothing has changed so far
            del changed["loading.history"]
    elif case.growth is None and isinstance(case.loading, Stages) and _same_stages(case.loading, step, stored):
        changed = {key: values for key, values in changed.items() if not key.startswith("loading.stages.")}
    if changed:
        lines = [f"  {key}: {then} then, {now} now" for key, (then, now) in changed.items()]
        what = f"the case is not that of the run in {folder}; undo this, run without --resume or into another folder:"
        raise ResumeError("\n".join([what, *cut(lines, MOST_DIFFERENCES, "  and {} more")]))
    if case.last_step < step:
        raise ResumeError(f"{folder} has {step} steps already, {case.last_step} are asked for; run without --resume")


def _same_stages(now: Stages, step: int, stored: Mapping[str, str]) -> bool:
    """Whether nothing has changed of the stages so far: a load that a later one names is one of them from the start."""
    try:
        then = read_case(stored["settings"], "the case of the run", stored["name"]).loading
    except CaseError:  # of another version
        return False
    if not isinstance(then, Stages):
        return False
    old, new = ([astuple(stage) for stage in (of.before, *of.stages[: step + 1])] for of in (then, now))
    return old == new
