"""What accuracy costs in a case, and whether its own setting is good enough: the runs, and what is told of them."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any, Final

from crackgrow.case.accuracy import name_of
from crackgrow.case.units import Metres
from crackgrow.errors import SolveError
from crackgrow.results.atomic import write_text
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.lock import locked
from crackgrow.results.tables import Value, csv_text
from crackgrow.results.units import INTENSITIES, aligned, or_null, unit_of
from crackgrow.study.findings import DISPLACEMENT, MODES, Findings, Quantity, findings
from crackgrow.study.runs import Row, Table, Values, run_study
from crackgrow.study.trade_plan import OWN, TradePlan
from crackgrow.study.workers import Workers

COLUMNS: Final = declared(columns_of("study")["trade"])[1].header
"""Of convergence.csv."""

HEADINGS: Final = ("setting", "unknowns", "CPU s", "MB", "off, %", "path off, mm", "of grown, %")


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
    there = Workers(workers, scheduler, memory, timeout)
    study = plan.study
    with locked(study.folder, study.words):
        table = yield from run_study(study, there, resume)
        for run in study.runs:
            row = table.row(run)
            if not table.done(run):
                what = f"the run '{run.name}' is {row['status']}: {row['reason']}"
                raise SolveError(f"{what}; mend that and --resume, or ask for fewer --steps, or other settings by --at")
        found = findings(plan)
        for run in study.runs:
            apart = found.paths.get(run.name)
            of_path: Values = {"path_apart": apart.distance, "path_share": apart.share} if apart else {}
            table.found[run.number] |= {"error": found.error(run.name), **of_path}
        table.write()
        write_text(study.folder / "convergence.csv", csv_text(COLUMNS, _rows(found)))
        from crackgrow.study.pictures import draw_trade  # here: it loads matplotlib

        draw_trade(study.folder / "trade.png", found, table)
    return found, table


def _rows(found: Findings) -> list[list[Value | None]]:
    """What convergence.csv has."""
    return [
        [q.step, q.crack, q.tip, q.name, name, value, q.error(name), q.limit.order, q.limit.value]
        for q in found.quantities
        for name, value in q.values.items()
    ]


def trade_record(found: Findings, table: Table) -> dict[str, Any]:
    """All that was found as plain data, SI; null where there is no value."""
    plan = found.plan
    rows = [(run, table.row(run)) for run in plan.study.runs]
    return {
        "case": plan.study.name,
        "own": plan.own,
        "runs": [
            {name: or_null(value) for name, value in row.items() if "." not in name} | {"folder": str(run.folder)}
            for run, row in rows
        ],
        "rows": [dict(zip(COLUMNS, map(or_null, row), strict=True)) for row in _rows(found)],
        "steps_not_compared": found.left_out,
        "tolerance": plan.tolerance,
        "path_tolerance": found.path_tolerance,
        "error": or_null(found.error(plan.own)),
        "good_enough": found.good_enough,
        "verdict": verdict(found),
    }


def trade_text(found: Findings, table: Table) -> str:
    """What each setting costs and misses, and whether the case's own one is good enough."""
    rows = [HEADINGS, *(_cells(found, table.row(run)) for run in found.plan.study.runs)]
    shown = len(HEADINGS) if found.paths else -2  # of a scene that does not grow without those of paths
    lines = aligned([row[:shown] for row in rows], 1)
    if found.worst is not None:
        lines.append(_worst_line(found, found.worst))
    if not found.quantities:
        lines.append("no state of the cracks and no quantity is in all runs: nothing can be compared")
    if found.left_out:
        lines.append(f"{found.left_out} more states of the cracks are not in all runs, and not compared")
    if any(quantity.same_cells for quantity in found.quantities):
        lines.append(
            "at some tips two settings have the same cells: there errors are those that the run itself states; ask for "
            "settings further apart by --at"
        )
    if len(found.moves) > 1:
        (least, near), (most, far) = sorted(found.moves.items(), key=lambda move: move[1].distance)
        far_mm, near_mm = 1e3 * far.distance, 1e3 * near.distance
        lines.append(f"{most} would move the path by {far_mm:.2g} mm, {least} by {near_mm:.2g} mm")
    return "\n".join([*lines, "", verdict(found)])


def _cells(found: Findings, row: Values) -> tuple[str, ...]:
    name, path = str(row["setting"]), found.paths.get(str(row["setting"]))
    numbers = (
        (row["n_dofs"], ",d"),
        (row["cpu_seconds"], ".2f"),
        (row["peak_memory_mb"], ".0f"),
        (100.0 * found.error(name), ".2g"),
        (path and 1e3 * path.distance, ".2g"),
        (path and 100.0 * path.share, ".2g"),
    )
    shown = ["-" if value is None or value != value else f"{value:{form}}" for value, form in numbers]
    return (f"{name} (the case's own)" if name == found.plan.own != OWN else name, *shown)


def _worst_line(found: Findings, worst: Quantity) -> str:
    """The values of the quantity by which the own setting is off most."""
    limit, order = worst.limit.value, worst.limit.order
    scale, unit = unit_of([limit], INTENSITIES) if worst.name in MODES else (1.0, "m" * (worst.name == DISPLACEMENT))
    values = ", ".join(f"{worst.values[name] / scale:.5g}" for name in found.plan.settings)
    told = "" if math.isnan(order) else f" with order {order:.2g}"
    return f"{_words(worst)}: {values} {unit}".rstrip() + f", which tend to {limit / scale:.5g}{told}"


def verdict(found: Findings) -> str:
    """Whether the case's own setting is good enough, in a sentence."""
    plan, worst = found.plan, found.worst
    if worst is None:
        return "not known: no quantity of the scene has a size that an error can be a share of"
    error, within = found.error(plan.own), f"{100.0 * plan.tolerance:.3g} %"
    of_K = " of the largest K" if worst.name in MODES else ""
    numerics = plan.case.numerics
    own = f"numerics.accuracy, {name_of(numerics.accuracy, numerics.goal)},"
    if numerics.auto_rule is None:
        own = f"spacing of {Metres(numerics.spacing):.4g}"
    off = f"with the case's own {own} {_words(worst)} is off by {100.0 * error:.2g} %{of_K}"
    if error <= plan.tolerance:
        enough = "good enough" if found.paths_good_enough else "not good enough for paths"
        return f"{enough}: {off} at most, within the {within} asked for{_path_off(found)}"
    better = next((name for name in plan.settings if found.within(name)), None)
    if better is not None:
        return f"not good enough: {off}, more than {within}; numerics.accuracy: {better} is within it"
    finest = plan.settings[-1]
    so_is = f"so is {finest} by {100.0 * found.error(finest):.2g} %"
    return f"not good enough: {off}, more than {within}, and {so_is}; smaller cells are needed"


def _path_off(found: Findings) -> str:
    """What would move the path most, and by how much of it; empty where nothing has grown."""
    if not found.moves:
        return ""
    what, apart = max(found.moves.items(), key=lambda move: move[1].share)
    word = "within" if found.paths_good_enough else "more than"
    allowed = f"{100.0 * found.path_tolerance:.3g} %"
    return f"; {what} would move the path by {100.0 * apart.share:.2g} % of what has grown, {word} {allowed}"


def _words(quantity: Quantity) -> str:
    if not quantity.crack:
        return f"the {quantity.name.replace('_', ' ')} of step {quantity.step}"
    return f"{quantity.name} at the {quantity.tip} of crack '{quantity.crack}' in step {quantity.step}"
