"""Where a run that was broken off goes on: the newest checkpoint in its folder, if the case is the same.

What may differ are settings that have no part in the results so far: title, source, pictures, the number of growth
steps, and the load factors or stages to come.
"""

from __future__ import annotations

import json
from dataclasses import astuple, dataclass
from pathlib import Path

from crackgrow import __version__
from crackgrow.case import dump_case
from crackgrow.case.dump import differing, read_settings
from crackgrow.case.load import read_case
from crackgrow.case.model import Case, LoadHistory, Stages
from crackgrow.errors import CaseError, CrackgrowError
from crackgrow.results.checkpoint_file import (
    DamagedError,
    StoredCheckpoint,
    read_checkpoint,
    steps_with_checkpoint,
)
from crackgrow.results.folder import RunFolder
from crackgrow.results.summary import program_commit
from crackgrow.results.tables import lines_before
from crackgrow.results.units import cut
from crackgrow.run.result import Checkpoint

FREE = ("title", "source", "output.figures", "output.report", "growth.steps")
MOST_DIFFERENCES = 20  # that are told
NOT_GIVEN = "not given"  # in place of a value


Differences = dict[str, tuple[str, str]]
"""Values then and now, by dotted key."""


class ResumeError(CrackgrowError):
    """A run that can't be gone on with; the message says why."""

    exit_code = 2


@dataclass(frozen=True, slots=True, eq=False)
class Resumption:
    """Where a run goes on."""

    stored: StoredCheckpoint
    finished: str | None  # how the run has ended, if there is nothing left to do
    remarks: tuple[str, ...]  # what the user should know

    @property
    def checkpoint(self) -> Checkpoint:
        """What the loop goes on from."""
        return self.stored.checkpoint


def find_resumption(case: Case, folder: Path) -> Resumption | None:
    """Where the run in `folder` goes on with the case; None: it has not got as far as a step.

    Raises ResumeError where the case is another one, or the files are not those that a checkpoint goes with.
    """
    remarks = []
    for step in steps_with_checkpoint(folder):
        try:
            stored = read_checkpoint(folder, step)
        except DamagedError as error:
            remarks.append(str(error))
            continue
        missing = _missing(folder, stored)
        if missing:
            remarks.append(f"the checkpoint of step {step} does not fit {', '.join(missing)}")
            continue
        differences = _differences(case, stored)
        run = RunFolder(folder)
        if not differences and run.finished:
            return Resumption(stored, f"{run.status}: {run.reason}", ())
        _check_same(case, folder, stored, differences)
        return Resumption(stored, None, (*remarks, *_version_remarks(stored)))
    if remarks:
        raise ResumeError(f"{folder} has nothing to go on from: {'; '.join(remarks)}; run without --resume")
    if RunFolder(folder).n_rows("steps"):
        raise ResumeError(f"{folder} has results but no checkpoint to go on from; run without --resume")
    return None


def _check_same(case: Case, folder: Path, stored: StoredCheckpoint, differences: Differences) -> None:
    """Raise ResumeError where the case is not that of the checkpoint, as far as its results go."""
    step = stored.checkpoint.step
    stages = _same_stages(case, stored)
    changed = {
        key: values
        for key, values in differences.items()
        if key not in FREE
        and not (stages and key.startswith("loading.stages."))
        and not _same_factors(key, values[0], case, step)
    }
    if changed:
        lines = [f"  {key}: {then} then, {now} now" for key, (then, now) in changed.items()]
        what = f"the case is not that of the run in {folder}; undo this, run without --resume or into another folder:"
        raise ResumeError("\n".join([what, *cut(lines, MOST_DIFFERENCES, "  and {} more")]))
    if case.last_step < step:
        raise ResumeError(f"{folder} has {step} steps already, {case.last_step} are asked for; run without --resume")


def _differences(case: Case, stored: StoredCheckpoint) -> Differences:
    """Settings that differ."""
    then = {"name": stored.case_name, **read_settings(stored.settings)}
    now = {"name": case.name, **read_settings(dump_case(case))}
    return differing(then, now, NOT_GIVEN)


def _same_factors(key: str, then: str, case: Case, step: int) -> bool:
    """Whether a setting is the history that was `then`, of which nothing has changed so far."""
    if key != "loading.history" or case.growth is not None or not isinstance(case.loading, LoadHistory):
        return False
    return then != NOT_GIVEN and case.loading.factors[: step + 1] == tuple(json.loads(then)[: step + 1])


def _same_stages(case: Case, stored: StoredCheckpoint) -> bool:
    """Whether nothing has changed of the stages so far: a load that a later one names is one of them from the start."""
    if case.growth is not None or not isinstance(case.loading, Stages):
        return False
    try:
        then = read_case(stored.settings, "the case of the run", stored.case_name).loading
    except CaseError:  # of another version
        return False
    return isinstance(then, Stages) and _so_far(then, stored) == _so_far(case.loading, stored)


def _so_far(loading: Stages, stored: StoredCheckpoint) -> list[tuple[object, ...]]:
    """What holds before the first stage, and at the end of each up to a checkpoint's."""
    return [astuple(stage) for stage in (loading.before, *loading.stages[: stored.checkpoint.step + 1])]


def _missing(folder: Path, stored: StoredCheckpoint) -> list[str]:
    """Result files that a checkpoint counts on and that are not there, or without rows of the steps before it."""
    results, step = stored.results, stored.checkpoint.step
    broken = [name for name, n in results["tables"].items() if _n_rows_before(folder / name, step) != n]
    frames = [name for series in ("frames", "cracks") for _, name in results[series]]
    return [*broken, *(name for name in frames if not (folder / name).is_file())]


def _n_rows_before(table: Path, step: int) -> int | None:
    """How many rows a table has of the steps before one; None where it can't be gone on with."""
    try:
        return len(lines_before(table, step)) - 1
    except (OSError, ValueError):
        return None


def _version_remarks(stored: StoredCheckpoint) -> list[str]:
    """What to say where another version of the program goes on."""
    ours, theirs = (__version__, program_commit()), (stored.version, stored.commit)
    if ours == theirs:
        return []
    words = [f"{version}{f' ({commit})' if commit else ''}" for version, commit in (theirs, ours)]
    return [
        f"begun by crackgrow {words[0]}, gone on with by {words[1]}: not the same bits as an unbroken run's, perhaps"
    ]
