"""A study runs: what is missing is run, and the table is on disk as soon as a run has ended."""

from __future__ import annotations

import contextlib
from collections.abc import Generator
from concurrent.futures import CancelledError, Future, as_completed

from crackgrow.errors import reason_of
from crackgrow.results.atomic import OccupiedError, remove_files
from crackgrow.results.folder import FINISHED
from crackgrow.results.lock import FolderLock, LockedError, earlier_files
from crackgrow.results.resume import ResumeError, find_resumption
from crackgrow.study.plan import Run, Study
from crackgrow.study.table import Row, Table, Values, found_in
from crackgrow.study.workers import ClusterError, Workers

REFUSED = "refused"


def run_study(study: Study, workers: Workers, resume: bool) -> Generator[Row, None, Table]:
    """Run what is planned, yield the row of each run as it ends, and return the table; the folder is to be locked.

    resume: leave runs alone that are done, and go on with those that were broken off

    Raises ClusterError and OutputError; what has ended is in the table then. A run that fails is a row like any other.
    """
    table, settled, missing = Table(study, {}), [], []
    for run in study.runs:
        found = found_in(run) if resume else {}
        if run.case is None:
            settled.append(table.ended(run, {"status": REFUSED, "reason": run.refusal}))
        elif found.get("status") in FINISHED:
            settled.append(table.ended(run, found, new=False))
        else:
            missing.append(run)
    with workers.there() as submit:
        for run in missing:  # only now: earlier results are kept where nothing can run
            _remove_earlier(study, run, resume)
        table.write()
        yield from settled
        running = {submit(run.command): run for run in missing}
        for future in as_completed(running):
            run = running.pop(future)
            row = table.ended(run, _values(run, future))
            table.write()
            yield row
    return table


def locked(study: Study) -> contextlib.AbstractContextManager[None]:
    """The folder of a study is written by it alone; raises LockedError."""
    return FolderLock(study.folder, f"{study.command} {study.name}").held()


def _values(run: Run, future: Future[str]) -> Values:
    """What has become of a run; raises ClusterError where that was lost with all others."""
    try:
        reason = future.result()
    except CancelledError as error:
        told = "the Dask scheduler is gone; what has ended is in the table, go on with --resume"
        raise ClusterError(f"{told}: {error}") from error
    except Exception as error:  # of Dask: its worker died
        reason = f"worker lost: {reason_of(error)}"
    found = found_in(run)
    if not reason and found.get("status") not in FINISHED:
        reason = str(found.get("reason") or "it has left no results")
    return {**found, "status": "failed", "reason": reason} if reason else found


def _remove_earlier(study: Study, run: Run, resume: bool) -> None:
    """Remove what an earlier study has left in the folder of a run that begins anew; raises OutputError."""
    if run.case is None or not run.folder.is_dir():
        return
    with contextlib.suppress(ResumeError):  # of another case
        if resume:
            find_resumption(run.case, run.folder)
            return
    # Where it must not be changed, the run itself is refused, and the others are made.
    with (
        contextlib.suppress(OccupiedError, LockedError),
        FolderLock(run.folder, f"{study.command} {study.name}").held(),
    ):
        remove_files(earlier_files(run.folder, run.case.name))
