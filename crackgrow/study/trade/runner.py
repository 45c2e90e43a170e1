"""The trade: the reference, then one row after another, each on disk as soon as it is known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from crackgrow.case import load_case
from crackgrow.errors import CrackgrowError, SolveError
from crackgrow.results.atomic import write_text
from crackgrow.results.folder import FINISHED
from crackgrow.results.lock import FolderLock
from crackgrow.study.energy_distance import EnergyReference
from crackgrow.study.setting import Setting, folder_names
from crackgrow.study.timed_run import run_in_processes
from crackgrow.study.trade.measures import check_results, errors_of
from crackgrow.study.trade.picture import draw
from crackgrow.study.trade.plan import FINER, Plan
from crackgrow.study.trade.row import REFERENCE, Row, Run, csv_text, read_rows, row_of

TABLE, PICTURE = "trade.csv", "trade.png"
JUDGED = FINER * (1 - 1e-9)  # of the reference's spacing: runs from there on are held against it
NOT_JUDGED = f"not judged: the spacing is less than {FINER:g} times that of the reference"


def trade(plan: Plan, *, repeat: int = 1, resume: bool = False, timeout: float | None = None) -> Iterator[Row]:
    """Run what is planned, yield every new row, and draw the picture at the end.

    repeat: runs of each setting, of which the median counts
    resume: keep the rows that an earlier study of the same plan has left, and run only what is missing
    timeout: seconds after which a run is given up

    Raises CaseError where there is nothing to resume or the reference is gone, SolveError where the reference can't be
    solved, LockedError where another study writes into the folder, OutputError.
    A setting that fails is a row like any other.
    """
    table = plan.folder / TABLE
    rows: list[Row] = []
    with FolderLock(plan.folder, f"trade {plan.file.path.stem}").held():
        if resume:
            plan.check_same()
            rows = read_rows(table) if table.is_file() else []
        else:
            plan.write()
            write_text(table, csv_text(rows))
        known = {row.name for row in rows}
        if isinstance(plan.reference, tuple) and REFERENCE not in known:
            rows.append(_reference(plan, plan.reference, timeout))
            write_text(table, csv_text(rows))
            yield rows[-1]
        check_results(plan.reference_folder)
        energy = EnergyReference(load_case(plan.reference_folder / "case.yaml"))
        folders = folder_names(setting.name for setting in plan.settings)
        for setting, words in zip(plan.settings, folders, strict=True):
            if setting.name not in known:
                run = _run(plan, setting, plan.folder / "runs" / words, repeat, timeout)
                rows.append(_judged(plan, run, energy))
                write_text(table, csv_text(rows))
                yield rows[-1]
        draw(plan.folder / PICTURE, plan.file.load().title, rows)


def _reference(plan: Plan, overrides: tuple[str, ...], timeout: float | None) -> Row:
    """Make the run that the others are held against. Raises SolveError where it ends otherwise than it should."""
    run = _run(plan, Setting(REFERENCE, overrides), plan.reference_folder, 1, timeout)
    if run.cost.status not in FINISHED:
        given = " ".join(overrides)
        raise SolveError(
            f"the reference ({given}) is {run.cost.status}: {run.cost.reason}; give another by --reference"
        )
    return row_of(run)


def _run(plan: Plan, setting: Setting, folder: Path, repeat: int, timeout: float | None) -> Run:
    """Run a setting; one that is no case is refused by its own run."""
    overrides = plan.run_overrides(setting.overrides)
    cost = run_in_processes(plan.file, overrides, folder, repeat, timeout)
    case, _ = plan.file.tried(*overrides)
    return Run(setting, case, cost, folder, repeat)


def _judged(plan: Plan, run: Run, energy: EnergyReference) -> Row:
    """The row of a run, held against the reference where it was solved and the reference is fine enough."""
    if run.case is None or not run.cost.cpu_steps:
        return row_of(run)
    if run.case.numerics.spacing < JUDGED * energy.spacing:
        return row_of(run.with_note(NOT_JUDGED))
    errors = errors_of(run.folder, plan.reference_folder, grows=plan.grows)
    try:
        return row_of(run, {**errors, "true_energy_error": energy.error(run.case)})
    except CrackgrowError as error:  # bodies that differ, such as those of a reference from elsewhere
        return row_of(run.with_note(f"no distance in energy: {error}"), errors)
