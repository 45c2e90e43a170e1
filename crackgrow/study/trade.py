"""What accuracy costs in a case, and whether its own setting is good enough: the runs, and what is written of them."""

from __future__ import annotations

from collections.abc import Generator

from crackgrow.errors import SolveError
from crackgrow.results.atomic import write_text
from crackgrow.study.findings import Findings, findings
from crackgrow.study.runner import locked, run_study
from crackgrow.study.table import Row, Table
from crackgrow.study.trade_plan import TradePlan
from crackgrow.study.trade_text import convergence_csv, trade_values
from crackgrow.study.workers import Workers


def trade(
    plan: TradePlan,
    *,
    workers: int | None = 1,
    scheduler: str | None = None,
    memory: str | None = None,
    timeout: float | None = None,
    resume: bool = False,
) -> Generator[Row, None, tuple[Findings, Table]]:
    """Run what is planned, yield the row of each run as it ends, write what they tell, and return it.

    workers: processes of this machine; with one the seconds are those of a run alone. The rest as for `sweep`.

    Raises what `sweep` raises, and SolveError where a run has not come to its end: what it lacks would not be compared.
    """
    there = Workers.of(workers, scheduler, memory, timeout)
    study = plan.study
    with locked(study):
        table = yield from run_study(study, there, resume)
        for run in study.runs:
            row = table.row(run)
            if not table.done(run):
                what = f"the run '{run.name}' is {row['status']}: {row['reason']}"
                raise SolveError(f"{what}; mend that and --resume, or ask for fewer --steps, or other settings by --at")
        found = findings(plan)
        values = trade_values(found)
        for run in study.runs:
            table.found[run.number] |= values[run.name]
        table.write()
        write_text(study.folder / "convergence.csv", convergence_csv(found))
        from crackgrow.study.trade_picture import draw  # here: it loads matplotlib

        draw(study.folder / "trade.png", found, table)
    return found, table
