"""The sweep: what is missing is run, and the table is on disk as soon as a run has ended."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Final

from crackgrow.case import dump_case
from crackgrow.errors import reason_of
from crackgrow.results.atomic import OccupiedError, remove_files
from crackgrow.results.folder import FINISHED, FolderError, RunFolder
from crackgrow.results.leftovers import earlier_files
from crackgrow.results.lock import FolderLock, LockedError
from crackgrow.results.units import counted
from crackgrow.study.processes import Processes, Workers, as_they_end
from crackgrow.study.sweep.columns import Values, measured
from crackgrow.study.sweep.job import Job, run_job
from crackgrow.study.sweep.place import ClusterError, Place
from crackgrow.study.sweep.plan import Run, SweepPlan

REFUSED: Final = "refused"
LIVES: Final = 3  # workers that a run may lose before it is its own fault


@dataclass(frozen=True, slots=True, eq=False)
class SweepRow:
    """A run that has ended, with its row of the table."""

    run: Run
    values: Values
    new: bool  # whether this sweep has run it

    @property
    def done(self) -> bool:
        """Whether the run ended as runs should."""
        return self.values["status"] in FINISHED


def sweep(
    plan: SweepPlan,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    memory: str | None = None,
    resume: bool = False,
    function: Callable[[Job], Values] = run_job,
) -> Iterator[SweepRow]:
    """Run what is planned and yield the row of each run as it ends, then draw the picture.

    workers: processes of this machine; default: one a core, no more than runs
    scheduler: address of a Dask scheduler whose workers, however many, are used instead; they must see the same disk
    memory: such as "2GB", of each worker
    resume: leave runs alone that are done, and go on with those that were broken off
    function: what a worker does with a job

    Raises MissingPackageError, CaseError (a wrong `memory` or `scheduler`), LockedError where another study writes into
    the folder, ClusterError and OutputError; what has ended is in the table then. A run that fails is a row
    like any other.
    """
    place = Place.of(workers, scheduler, memory)
    with FolderLock(plan.folder, f"sweep {plan.name}").held():
        yield from _rows(plan, place, resume, function)


def _rows(plan: SweepPlan, place: Place, resume: bool, function: Callable[[Job], Values]) -> Iterator[SweepRow]:
    """As `sweep`, in a folder that is locked."""
    from crackgrow.study.sweep.picture import draw
    from crackgrow.study.sweep.table import SweepTable  # imports pyarrow

    table = SweepTable(plan, {})
    jobs = []
    settled = []
    for run in plan.runs:
        if run.case is None:
            table.found[run.number] = {"status": REFUSED, "reason": run.refusal}
            settled.append(SweepRow(run, table.row(run), True))
        elif resume and done(run):
            table.found[run.number] = measured(run.folder)
            settled.append(SweepRow(run, table.row(run), False))
        else:
            jobs.append(Job(run.number, run.folder.resolve(), run.case, place.memory))
    with _workers(place, len(jobs)) as workers:
        if not resume:  # only now: earlier results are kept where nothing can run
            _remove_earlier(plan)
        table.write()
        yield from settled
        for job, future in as_they_end(workers, function, jobs):
            run = plan.runs[job.number]
            table.found[run.number] = _values(future)
            table.write()
            yield SweepRow(run, table.row(run), True)
    draw(plan.folder / "sweep.png", table)


def _workers(place: Place, n_jobs: int) -> contextlib.AbstractContextManager[Workers]:
    """The workers of the scheduler, or as many processes of this machine as there are jobs for."""
    if place.scheduler is None or not n_jobs:
        return Processes(max(1, min(place.workers, n_jobs)), lives=LIVES)
    from crackgrow.study.sweep.cluster import connected  # imports Dask

    return connected(place.scheduler)


def _values(future: Future[Values]) -> Values:
    """What a job returned, or why it didn't; raises ClusterError where that was lost with all others."""
    try:
        return future.result()
    except ClusterError:
        raise
    except Exception as error:
        return {"status": "failed", "reason": reason_of(error)}


def _remove_earlier(plan: SweepPlan) -> None:
    """Remove what an earlier sweep has left in the folders of the runs; raises OutputError."""
    for run in plan.runs:
        if run.case is not None and run.folder.is_dir():
            # Where it must not be changed, the run itself is refused, and the others are made.
            with contextlib.suppress(OccupiedError, LockedError), FolderLock(run.folder, f"sweep {plan.name}").held():
                remove_files(earlier_files(run.folder, run.case.name))


def done(run: Run) -> bool:
    """Whether the folder of a run holds its results, of the same case to the last digit."""
    if run.case is None:
        return False
    found = RunFolder(run.folder)
    try:
        return found.finished and found.case_text == dump_case(run.case) and bool(measured(run.folder))
    except (FolderError, ValueError, KeyError, TypeError):  # damaged, or of another version: it is run again
        return False


def sweep_line(row: SweepRow) -> str:
    """A row on a line of the terminal."""
    start = f"{row.run.number:03d} {row.run.name}: {row.values['status']}"
    if not row.done:
        return f"{start}: {row.values['reason']}"
    steps = counted(row.values["steps"], "step")
    return f"{start}, {steps}, {row.values['seconds']:.1f} s, {row.values['peak_memory_mb']:.0f} MB"
