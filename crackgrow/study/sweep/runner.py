"""The sweep: what is missing is run, and the table is on disk as soon as a run has ended."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from crackgrow.case import dump_case
from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import OccupiedError
from crackgrow.results.folder import FINISHED, FolderError, RunFolder
from crackgrow.results.leftovers import earlier_files, remove_files
from crackgrow.results.lock import FolderLock, LockedError
from crackgrow.results.log import counted
from crackgrow.study.sweep.job import Job, Values, job_of, run_job
from crackgrow.study.sweep.measured import measured
from crackgrow.study.sweep.plan import Run, SweepPlan

if TYPE_CHECKING:
    from crackgrow.study.sweep.cluster import Place

NEEDED: Final = ("dask", "distributed", "pyarrow")
REFUSED: Final = "refused"


class MissingPackageError(CrackgrowError):
    """A package that only sweeps need is not installed."""

    exit_code = 3


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
    """Run what is planned and yield the row of each run as it ends, then draw the overview.

    workers: processes of this machine; default: one a core, no more than runs
    scheduler: address of a Dask scheduler whose workers, however many, are used instead; they must see the same disk
    memory: such as "2GB", of each worker
    resume: leave runs alone that are done, and go on with those that were broken off
    function: what a worker does with a job

    Raises MissingPackageError, CaseError (a wrong `memory` or `scheduler`), LockedError where another study writes into
    the folder, ClusterError and OutputError; what has ended is in the table then. A run that fails is a row
    like any other.
    """
    check_packages()
    from crackgrow.study.sweep.cluster import Place, available_cores, bytes_of  # imports Dask

    size = None if memory is None else bytes_of(memory)
    place = Place(scheduler, workers or available_cores(), size)
    with FolderLock(plan.folder, f"sweep {plan.name}").held():
        yield from _rows(plan, place, resume, function)


def _rows(plan: SweepPlan, place: Place, resume: bool, function: Callable[[Job], Values]) -> Iterator[SweepRow]:
    """As `sweep`, in a folder that is locked."""
    from crackgrow.study.sweep.cluster import connected, run_all  # as above
    from crackgrow.study.sweep.overview import draw
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
            jobs.append(job_of(run.number, run.folder, run.case, place.memory))
    with contextlib.ExitStack() as stack:
        client = stack.enter_context(connected(place, len(jobs))) if jobs else None
        if not resume:  # only now: earlier results are kept where nothing can run
            _remove_earlier(plan)
        table.write()
        yield from settled
        for job, values in run_all(client, jobs, function) if client is not None else ():
            run = plan.runs[job.number]
            table.found[run.number] = values
            table.write()
            yield SweepRow(run, table.row(run), True)
    draw(plan.folder / "sweep.png", table)


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


def check_packages() -> None:
    """Raise MissingPackageError where one is not installed."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        names = " and ".join(missing)
        raise MissingPackageError(f"sweeps need {names}, not installed here: pip install 'crackgrow[sweep]'")


def sweep_line(row: SweepRow) -> str:
    """A row on a line of the terminal."""
    start = f"{row.run.number:03d} {row.run.name}: {row.values['status']}"
    if not row.done:
        return f"{start}: {row.values['reason']}"
    steps = counted(row.values["steps"], "step")
    return f"{start}, {steps}, {row.values['seconds']:.1f} s, {row.values['peak_memory_mb']:.0f} MB"
