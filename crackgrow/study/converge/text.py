"""What was found, for people, as CSV and as plain data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, Final

from crackgrow.case.accuracy import name_of
from crackgrow.case.units import Metres
from crackgrow.results.tables import csv_text
from crackgrow.results.units import aligned, or_null
from crackgrow.study.converge.columns import FILES, RANKS, TABLE
from crackgrow.study.converge.findings import MODES, Convergence, Quantity, Ran
from crackgrow.study.converge.plan import ConvergencePlan

MOST_ROWS: Final = 24
"""Rows that are printed: those of the first and the last state and of the worst; converge.csv has all."""


def convergence_csv(found: Convergence) -> str:
    """All rows."""
    return csv_text(FILES[0].header, (_values(found.plan, quantity) for quantity in found.quantities))


def convergence_record(found: Convergence) -> dict[str, Any]:
    """All that was found as plain data, SI; null where there is no value."""
    plan = found.plan
    return {
        "case": plan.case.name,
        "settings": dict(zip(RANKS, _names(plan), strict=True)),
        "runs": [_run_record(run) for run in found.runs],
        "rows": [dict(zip(FILES[0].header, map(or_null, _values(plan, q)), strict=True)) for q in found.quantities],
        "paths": [asdict(apart) for apart in found.paths],
        "steps_not_compared": found.left_out,
        "tolerance": plan.tolerance,
        "path_tolerance": found.path_tolerance,
        "error": or_null(found.largest_error(plan.own.name)),
        "good_enough": found.good_enough,
        "verdict": verdict(found),
    }


def _run_record(run: Ran) -> dict[str, Any]:
    return {
        "setting": run.name,
        "status": run.cost.status,
        "reason": run.cost.reason,
        "n_dofs": run.n_dofs,
        "cpu_seconds": or_null(run.cost.cpu_seconds),
        "folder": str(run.folder),
    }


def convergence_text(found: Convergence) -> str:
    """The table, the paths, and whether the case's own setting is good enough."""
    lines = _table(found)
    if found.left_out:
        lines.append(f"{found.left_out} more states of the cracks are not in all runs, and not compared")
    if found.same_cells:
        lines.append(
            "at some tips two settings have the same cells: there errors are those that the run itself states; ask for "
            "settings further apart by --at"
        )
    if found.paths:
        lines += ["", *_paths(found)]
    return "\n".join([*lines, "", verdict(found)])


def run_line(run: Ran) -> str:
    """A run on a line."""
    cost = run.cost
    return f"{run.name:16} {run.n_dofs:>9,} unknowns {cost.cpu_seconds:8.2f} s CPU  {cost.status}: {cost.reason}"


def verdict(found: Convergence) -> str:
    """Whether the case's own setting is good enough, in a sentence."""
    plan, worst = found.plan, found.worst
    own, within = own_name(plan), f"{100.0 * plan.tolerance:.3g} %"
    if worst is None:
        return "not known: no quantity of the scene has a size that an error can be a share of"
    error = found.largest_error(plan.own.name)
    off = f"{_words(worst)} is off by {100.0 * error:.2g} %{' of the largest K' if worst.name in MODES else ''}"
    if error <= plan.tolerance:
        enough = "good enough" if found.paths_good_enough else "not good enough for paths"
        return f"{enough}: with {own} {off} at most, within the {within} asked for{_path_off(found)}"
    better = [setting for setting in plan.settings if _within(found, setting.name)]
    if better:
        return (
            f"not good enough: with {own} {off}, more than {within}; numerics.accuracy: {better[0].name} is within it"
        )
    finest = plan.settings[-1].name
    return (
        f"not good enough: with {own} {off}, more than {within}, and so is {finest} by "
        f"{100.0 * found.largest_error(finest):.2g} %; smaller cells are needed"
    )


def _within(found: Convergence, setting: str) -> bool:
    """Whether K of a setting is within the tolerance, and its path is as near to that on the finest cells."""
    path = found.path_of_setting(setting)
    near = path is None or path.share <= found.path_tolerance
    return near and found.largest_error(setting) <= found.plan.tolerance


def _path_off(found: Convergence) -> str:
    """What would move the path most, and by how much of it; empty where nothing has grown."""
    moved = {"finer cells": found.path_of_cells, "a shorter increment": found.path_of_increments}
    known = {what: apart for what, apart in moved.items() if apart is not None}
    if not known:
        return ""
    what = max(known, key=lambda name: known[name].share)
    word = "within" if found.paths_good_enough else "more than"
    allowed = f"{100.0 * found.path_tolerance:.3g} %"
    return f"; {what} would move the path by {100.0 * known[what].share:.2g} % of what has grown, {word} {allowed}"


def own_name(plan: ConvergencePlan) -> str:
    """What the case's own setting is called."""
    numerics = plan.case.numerics
    if numerics.auto_rule is None:
        return f"the case's own spacing of {Metres(numerics.spacing):.4g}"
    return f"the case's own numerics.accuracy, {name_of(numerics.accuracy, numerics.goal)},"


def _table(found: Convergence) -> list[str]:
    """The rows of the first and the last state, and that of the worst."""
    quantities = list(found.quantities)
    if not quantities:
        return ["no state of the cracks and no quantity is in all runs: nothing can be compared"]
    if len(quantities) > MOST_ROWS:
        worst = found.worst
        shown = {quantities[0].step, quantities[-1].step, *([] if worst is None else [worst.step])}
        quantities = [quantity for quantity in quantities if quantity.step in shown][:MOST_ROWS]
    names = _names(found.plan)[: 3 if found.plan.own in found.plan.settings else 4]
    heading = ["crack", "tip", "step", "quantity", *names, "order", "extrapolated", *(f"% {name}" for name in names)]
    rows = [[*_cells(quantity, names)] for quantity in quantities]
    more = len(found.quantities) - len(quantities)
    lines = ["K in MPa sqrt(m); errors in percent of the largest K of the step", *aligned([heading, *rows], 2)]
    return [*lines, *([f"and {more} more rows in {found.plan.folder / TABLE}"] if more else [])]


def _cells(quantity: Quantity, names: Sequence[str]) -> list[str]:
    scale = 1e-6 if quantity.name in MODES else 1.0
    return [
        quantity.crack or "-",
        quantity.tip or "-",
        str(quantity.step),
        quantity.name,
        *(f"{scale * quantity.values[name]:.5g}" for name in names),
        "-" if math.isnan(quantity.order) else f"{quantity.order:.2g}",
        f"{scale * quantity.limit:.5g}",
        *(f"{100.0 * quantity.error(name):.2g}" for name in names),
    ]


def _paths(found: Convergence) -> list[str]:
    """How far apart the paths are, and what would move them more."""
    lines = ["paths, largest distance over what both have grown:"]
    lines += [f"  {a.first} and {a.second}: {1e3 * a.distance:.3g} mm" for a in found.paths]
    cells, increments = found.path_of_cells, found.path_of_increments
    if increments is None:
        return [*lines, *([found.why_no_half] if found.why_no_half else [])]
    if cells is None:
        return lines
    shorter = increments.distance > cells.distance
    first, second = ("a shorter increment", "finer cells") if shorter else ("finer cells", "a shorter increment")
    most, least = sorted((cells.distance, increments.distance), reverse=True)
    return [*lines, f"{first} would move the path by {1e3 * most:.2g} mm, {second} by {1e3 * least:.2g} mm"]


def _words(quantity: Quantity) -> str:
    if not quantity.crack:
        return f"the {quantity.name.replace('_', ' ')} of step {quantity.step}"
    return f"{quantity.name} at the {quantity.tip} of crack '{quantity.crack}' in step {quantity.step}"


def _names(plan: ConvergencePlan) -> list[str]:
    return [*(setting.name for setting in plan.settings), plan.own.name]


def _values(plan: ConvergencePlan, quantity: Quantity) -> list[str | float | int | None]:
    names = _names(plan)
    return [
        quantity.step,
        quantity.crack,
        quantity.tip,
        quantity.name,
        *(quantity.values[name] for name in names),
        quantity.order,
        quantity.limit,
        *(quantity.error(name) for name in names),
    ]
