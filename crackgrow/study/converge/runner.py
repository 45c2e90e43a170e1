"""The runs of a convergence study, one after another, and what they tell."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

from crackgrow.errors import SolveError
from crackgrow.results.atomic import write_text
from crackgrow.results.folder import RunFolder
from crackgrow.results.lock import FolderLock
from crackgrow.study.converge.columns import TABLE
from crackgrow.study.converge.findings import Convergence, Ran, findings
from crackgrow.study.converge.plan import HALF, ConvergencePlan
from crackgrow.study.converge.text import convergence_csv
from crackgrow.study.setting import Setting, folder_name
from crackgrow.study.timed_run import run_in_processes

DEARER = 2.5
"""CPU time of half increments over that of the same run with whole ones, about."""


def converge(plan: ConvergencePlan, timeout: float | None = None) -> Generator[Ran, None, Convergence]:
    """Run what is planned, yield each run as it ends, and return what they tell; converge.csv is in the folder.

    timeout: seconds after which a run is given up

    Raises SolveError where a run has no first step, LockedError where another study writes into the folder,
    OutputError.
    """
    with FolderLock(plan.folder, f"converge {plan.file.path.stem}").held():
        settings = list(plan.settings)
        if plan.own not in settings:
            settings.append(plan.own)
        runs: list[Ran] = []
        for setting in settings:
            runs.append(_run(plan, setting, timeout))
            yield runs[-1]
        why = "" if plan.half is None else _too_expensive(plan, runs)
        if plan.half is not None and not why:
            runs.append(_run(plan, plan.half, timeout))
            yield runs[-1]
        found = findings(plan, runs, why)
        write_text(plan.folder / TABLE, convergence_csv(found))
        return found


def _run(plan: ConvergencePlan, setting: Setting, timeout: float | None) -> Ran:
    """Run a setting; raises SolveError where there is nothing to compare."""
    folder: Path = plan.folder / "runs" / folder_name(setting.name)
    cost = run_in_processes(plan.file, setting.overrides, folder, 1, timeout)
    if not cost.cpu_steps:
        raise SolveError(f"the run '{setting.name}' is {cost.status}: {cost.reason}; ask for other settings by --at")
    return Ran(setting.name, folder, cost, int(RunFolder(folder).table("steps").numbers("n_dofs")[-1]))


def _too_expensive(plan: ConvergencePlan, runs: list[Ran]) -> str:
    """Why half increments are not run, in words; empty where they are."""
    own = next(run.cost.cpu_seconds for run in runs if run.name == plan.own.name)
    whole = sum(run.cost.cpu_seconds for run in runs)
    if plan.half_asked or DEARER * own <= whole:
        return ""
    return f"{HALF} were not run: they take about {DEARER * own:.2g} s, more than all else; ask by --increments"
