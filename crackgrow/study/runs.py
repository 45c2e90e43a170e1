"""The runs of a study: what is missing is run, and as soon as a run has ended the table has its row, on disk, too."""

from __future__ import annotations

import contextlib
from collections.abc import Generator, Iterable, Mapping
from concurrent.futures import CancelledError, Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from crackgrow.case import dump_case
from crackgrow.case.model import Case
from crackgrow.errors import reason_of
from crackgrow.results.atomic import FolderError, OccupiedError, remove_files, write_text
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.folder import SUMMARY, RunFolder
from crackgrow.results.lock import LockedError, earlier_files, locked
from crackgrow.results.resume import ResumeError, find_resumption
from crackgrow.results.run import FINISHED
from crackgrow.results.tables import csv_text
from crackgrow.results.units import counted
from crackgrow.study.errors import ERRORS, errors_of
from crackgrow.study.plan import Run, Study
from crackgrow.study.workers import ClusterError, Workers

FIRST: Final = ("run", "folder")
ENDING: Final = ("status", "reason")
_NAMES: Final = declared(columns_of("study")["sweep"])[0].header
OF_TIPS: Final = tuple(name.removeprefix("CRACK.TIP.") for name in _NAMES if name.startswith("CRACK."))
COSTS: Final = tuple(name for name in _NAMES if name not in (*FIRST, *ENDING, *ERRORS, "PARAMETER") and "." not in name)
TAKEN: Final = frozenset({*FIRST, *ENDING, *COSTS, *ERRORS})  # no parameter can be called so
REFUSED: Final = "refused"
WAITING: Final = "waiting"

Values = dict[str, str | float | int | None]
"""Cells of the table by column, SI; None where there is no value."""


def response_columns(cases: Iterable[Case], judged: bool) -> list[str]:
    """All columns with numbers that runs of these cases may have; `judged`: held against a reference."""
    ends = [
        f"{crack.name}.{end}" for case in cases for crack in case.cracks for end in ("start", "end")
        if getattr(crack, f"tip_at_{end}")
    ]  # fmt: skip
    of_ends = (f"{end}.{what}" for end in ends for what in OF_TIPS)
    return list(dict.fromkeys([*COSTS, *(ERRORS if judged else ()), *of_ends]))


def found_in(run: Run) -> Values:
    """What the folder of a run tells; nothing where it is not of the same case to the last digit, or damaged."""
    try:
        same = run.case is not None and RunFolder(run.folder).case_text == dump_case(run.case)
        return measured(run.folder) if same else {}
    except (FolderError, ValueError, KeyError, TypeError):  # damaged, or of another version
        return {}


def measured(folder: Path) -> Values:
    """How a run has ended, what it cost, and what its tips bear; nothing where it has not begun.

    Columns of a tip, CRACK.TIP.WHAT: K_I_first and K_II_first at the first step, K_I_last and K_II_last at the last
    one (Pa sqrt(m)), x and y of its end (m). A tip that has met something has no K at the last step.
    """
    run = RunFolder(folder)
    if not run.has(SUMMARY):
        return {}
    summary, steps = run.summary, run.table("steps")
    estimate = summary["error_estimate"]
    found: Values = {
        "status": run.status,
        "reason": run.reason,
        "steps": summary["steps_done"],
        "load_factor": float(steps["load_factor"][-1]) if steps.n_rows else None,
        "n_dofs": summary["n_dofs"]["last"] if summary["n_dofs"] else None,
        "seconds": summary["wall_seconds"]["total"],
        "cpu_seconds": summary.get("cpu_seconds"),
        "peak_memory_mb": summary["peak_memory_mb"],
        "energy_error_percent": estimate["energy_norm_percent"]["last"],
        "K_spread_percent": estimate["K_spread_percent"],
    }
    tips = run.table("tips")
    by_tip, steps_met, paths = tips.by("crack", "tip"), tips["step"].tolist(), run.table("paths").by("crack")
    for (crack, tip), table in by_tip.items():
        for end, step in (("first", steps_met[0]), ("last", steps_met[-1])):
            of_end = table.of_steps([step])
            found |= {f"{crack}.{tip}.{K}_{end}": float(of_end[K][0]) for K in ("K_I", "K_II") if of_end.n_rows}
    for crack, tip in by_tip:
        if (crack,) in paths:
            vertex = 0 if tip == "start" else -1
            found |= {f"{crack}.{tip}.{axis}": float(paths[(crack,)][axis][vertex]) for axis in ("x", "y")}
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """A run that has ended, with its row of the table."""

    run: Run
    values: Values
    new: bool  # whether this study has run it

    @property
    def done(self) -> bool:
        """Whether the run ended as runs should."""
        return self.values["status"] in FINISHED

    def __str__(self) -> str:
        start = f"{self.run.number:03d} {self.run.name}: {self.values['status']}"
        if not self.done:
            return f"{start}: {self.values['reason']}"
        steps, seconds = counted(self.values["steps"], "step"), self.values["seconds"]
        return f"{start}, {steps}, {seconds:.1f} s, {self.values['peak_memory_mb']:.0f} MB"


@dataclass(slots=True)
class Table:
    """The rows of all runs; those that are not done are waiting."""

    study: Study
    found: dict[int, Values]  # of the runs that have ended, or were refused

    def ended(self, run: Run, values: Values, new: bool = True) -> Row:
        """Take in what has become of a run, and hold what can be held against a reference."""
        self.found[run.number] = values
        for one in self.study.runs:
            if one.reference is not None and self.done(one) and ERRORS[0] not in self.found[one.number]:
                reference = self.study.runs[one.reference]
                if self.done(reference):
                    grows = one.case is not None and one.case.growth is not None
                    self.found[one.number] |= errors_of(one.folder, reference.folder, grows=grows)
        return Row(run, self.row(run), new)

    def done(self, run: Run) -> bool:
        """Whether a run has ended as runs should."""
        return self.found.get(run.number, {}).get("status") in FINISHED

    def write(self) -> None:
        """Bring the file up to date; raises OutputError."""
        columns, rows = self.columns(), map(self.row, self.study.runs)
        text = csv_text(columns, ([row.get(name) for name in columns] for row in rows))
        write_text(self.study.folder / f"{self.study.command}.csv", text)

    def columns(self) -> list[str]:
        """Names of all columns: the tips' last, as they were met."""
        names = [*FIRST, *self.study.parameters, *ENDING, *COSTS]
        met = [name for number in sorted(self.found) for name in self.found[number]]
        return list(dict.fromkeys([*names, *(name for name in met if "." not in name), *met]))

    def row(self, run: Run) -> Values:
        """The row of a run."""
        given = dict(zip(self.study.parameters, run.values, strict=True))
        found = self.found.get(run.number, {"status": WAITING})
        return {"run": run.number, "folder": run.folder.name, **given, **found}


def run_study(
    study: Study, workers: Workers, resume: bool, known: Mapping[int, Values] | None = None
) -> Generator[Row, None, Table]:
    """Run what is planned, yield the row of each run as it ends, and return the table; the folder is to be locked.

    resume: leave runs alone that are done, and go on with those that were broken off
    known: what has become of runs before, which are left alone

    Raises ClusterError and OutputError; what has ended is in the table then. A run that fails is a row like any other.
    """
    table, settled, missing = Table(study, dict(known or {})), [], []
    for run in study.runs:
        if run.number in table.found:
            continue
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
    with contextlib.suppress(OccupiedError, LockedError), locked(run.folder, study.words):
        remove_files(earlier_files(run.folder, run.case.name))
