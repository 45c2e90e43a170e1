"""What a trade has found, for people, as CSV and as plain data."""

from __future__ import annotations

import math
from typing import Any

from crackgrow.case.accuracy import name_of
from crackgrow.case.units import Metres
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.tables import Value, csv_text
from crackgrow.results.units import INTENSITIES, aligned, or_null, unit_of
from crackgrow.study.findings import DISPLACEMENT, MODES, Findings, Quantity
from crackgrow.study.table import Table, Values
from crackgrow.study.trade_plan import OWN, TradePlan

COLUMNS = declared(columns_of("study")["trade"])[1].header
"""Of convergence.csv."""

HEADINGS = ("setting", "unknowns", "CPU s", "MB", "off, %", "path off, mm", "of grown, %")


def convergence_csv(found: Findings) -> str:
    """All rows."""
    return csv_text(COLUMNS, _rows(found))


def _rows(found: Findings) -> list[list[Value | None]]:
    return [
        [q.step, q.crack, q.tip, q.name, name, value, q.error(name), q.order, q.limit]
        for q in found.quantities
        for name, value in q.values.items()
    ]


def trade_values(found: Findings) -> dict[str, Values]:
    """The cells of the table that the findings give, by setting."""
    paths = {name: {"path_apart": apart.distance, "path_share": apart.share} for name, apart in found.paths.items()}
    return {run.name: {"error": found.error(run.name), **paths.get(run.name, {})} for run in found.plan.study.runs}


def trade_record(found: Findings, table: Table) -> dict[str, Any]:
    """All that was found as plain data, SI; null where there is no value."""
    plan = found.plan
    runs = [
        {name: or_null(value) for name, value in table.row(run).items() if "." not in name} for run in plan.study.runs
    ]
    return {
        "case": plan.study.name,
        "own": plan.own,
        "runs": [{**row, "folder": str(run.folder)} for row, run in zip(runs, plan.study.runs, strict=True)],
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
    rows = [_cells(found, table.row(run)) for run in found.plan.study.runs]
    shown = len(HEADINGS) if found.paths else -2  # of a scene that does not grow without those of paths
    lines = aligned([row[:shown] for row in [HEADINGS, *rows]], 1)
    if found.worst is not None:
        lines.append(_worst_line(found, found.worst))
    if not found.quantities:
        lines.append("no state of the cracks and no quantity is in all runs: nothing can be compared")
    if found.left_out:
        lines.append(f"{found.left_out} more states of the cracks are not in all runs, and not compared")
    if found.same_cells:
        lines.append(
            "at some tips two settings have the same cells: there errors are those that the run itself states; ask for "
            "settings further apart by --at"
        )
    if len(found.moves) > 1:
        (least, near), (most, far) = sorted(found.moves.items(), key=lambda move: move[1].distance)
        far_mm, near_mm = 1e3 * far.distance, 1e3 * near.distance
        lines.append(f"{most} would move the path by {far_mm:.2g} mm, {least} by {near_mm:.2g} mm")
    return "\n".join([*lines, "", verdict(found)])


def _cells(found: Findings, row: Values) -> list[str]:
    name = str(row["setting"])
    numbers = [
        (row["n_dofs"], ",d"), (row["cpu_seconds"], ".2f"), (row["peak_memory_mb"], ".0f"),
        (100.0 * found.error(name), ".2g"),
    ]  # fmt: skip
    path = found.paths.get(name)
    numbers += [(None, ""), (None, "")] if path is None else [(1e3 * path.distance, ".2g"), (100.0 * path.share, ".2g")]
    shown = ["-" if value is None or value != value else f"{value:{form}}" for value, form in numbers]
    return [f"{name} (the case's own)" if name == found.plan.own != OWN else name, *shown]


def _worst_line(found: Findings, worst: Quantity) -> str:
    """The values of the quantity by which the own setting is off most."""
    scale, unit = (
        unit_of([worst.limit], INTENSITIES) if worst.name in MODES else (1.0, "m" * (worst.name == DISPLACEMENT))
    )
    values = ", ".join(f"{worst.values[name] / scale:.5g}" for name in found.plan.settings)
    order = "" if math.isnan(worst.order) else f" with order {worst.order:.2g}"
    return f"{_words(worst)}: {values} {unit}".rstrip() + f", which tend to {worst.limit / scale:.5g}{order}"


def verdict(found: Findings) -> str:
    """Whether the case's own setting is good enough, in a sentence."""
    plan, worst = found.plan, found.worst
    own, within = own_name(plan), f"{100.0 * plan.tolerance:.3g} %"
    if worst is None:
        return "not known: no quantity of the scene has a size that an error can be a share of"
    error = found.error(plan.own)
    off = f"{_words(worst)} is off by {100.0 * error:.2g} %{' of the largest K' if worst.name in MODES else ''}"
    if error <= plan.tolerance:
        enough = "good enough" if found.paths_good_enough else "not good enough for paths"
        return f"{enough}: with {own} {off} at most, within the {within} asked for{_path_off(found)}"
    better = next((name for name in plan.settings if found.within(name)), None)
    if better is not None:
        return f"not good enough: with {own} {off}, more than {within}; numerics.accuracy: {better} is within it"
    finest = plan.settings[-1]
    return (
        f"not good enough: with {own} {off}, more than {within}, and so is {finest} by "
        f"{100.0 * found.error(finest):.2g} %; smaller cells are needed"
    )


def _path_off(found: Findings) -> str:
    """What would move the path most, and by how much of it; empty where nothing has grown."""
    if not found.moves:
        return ""
    what, apart = max(found.moves.items(), key=lambda move: move[1].share)
    word = "within" if found.paths_good_enough else "more than"
    allowed = f"{100.0 * found.path_tolerance:.3g} %"
    return f"; {what} would move the path by {100.0 * apart.share:.2g} % of what has grown, {word} {allowed}"


def own_name(plan: TradePlan) -> str:
    """What the case's own setting is called."""
    numerics = plan.case.numerics
    if numerics.auto_rule is None:
        return f"the case's own spacing of {Metres(numerics.spacing):.4g}"
    return f"the case's own numerics.accuracy, {name_of(numerics.accuracy, numerics.goal)},"


def _words(quantity: Quantity) -> str:
    if not quantity.crack:
        return f"the {quantity.name.replace('_', ' ')} of step {quantity.step}"
    return f"{quantity.name} at the {quantity.tip} of crack '{quantity.crack}' in step {quantity.step}"
