"""A run of a sweep, in its worker."""

from __future__ import annotations

from pathlib import Path

from crackgrow.case.model import Case
from crackgrow.errors import reason_of
from crackgrow.results.atomic import OccupiedError
from crackgrow.results.lock import LockedError
from crackgrow.results.resume import ResumeError, find_resumption
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.study.one_run import write_run
from crackgrow.study.sweep.job import Values
from crackgrow.study.sweep.measured import measured


def solve(case: Case, folder: Path) -> Values:
    """Run a case into a folder, from the last checkpoint there if one is of this case; return what the folder tells.

    Whatever a run raises is its reason to fail: it has no part in the runs beside it.
    """
    try:
        return _solve(case, folder)
    except (OccupiedError, LockedError) as error:  # nothing in the folder is this run's
        return {"status": "failed", "reason": reason_of(error)}
    except Exception as error:
        return {**measured(folder), "status": "failed", "reason": reason_of(error)}


def _solve(case: Case, folder: Path) -> Values:
    writer = RunWriter(case, folder)
    with writer.held():
        try:
            found = find_resumption(case, folder)
        except ResumeError:  # the folder is that of another sweep
            found = None
        if found is None or found.finished is None:
            if found is None:
                writer.begin()
            else:
                writer.resume(found)
            write_run(writer, grow(case, None if found is None else found.checkpoint))
        return measured(folder)
