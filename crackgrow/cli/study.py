"""The commands that learn from several runs: `crackgrow compare`, `sweep`, `fit` and `trade`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import crackgrow
from crackgrow.cli.console import (
    EXIT_DIFFERENT,
    EXIT_DONE,
    EXIT_INTERRUPTED,
    EXIT_UNSOLVED,
    complain,
    hand_out_json,
    load_case_file,
    say,
    spelled,
)
from crackgrow.results.atomic import write_text
from crackgrow.results.units import counted

if TYPE_CHECKING:
    from crackgrow.study.plan import Study
    from crackgrow.study.runs import Row


def do_compare(
    a: str,
    b: str,
    tolerance: str | None,
    csv_file: Path | None,
    as_json: bool,
    crack: str | None,
    tip: Literal["start", "end"] | None,
    columns: tuple[str, str] | None,
) -> int:
    """`crackgrow compare`: how far apart the crack paths of two runs are."""
    from crackgrow.study.comparison_text import comparison_csv, comparison_record, comparison_text  # loads numpy

    comparison = crackgrow.compare_paths(a, b, tolerance=tolerance, crack=crack, tip=tip, columns=columns)
    if as_json:
        hand_out_json(comparison_record(comparison))
    else:
        say(comparison_text(comparison))
    if csv_file is not None:
        write_text(csv_file, comparison_csv(comparison))
    return EXIT_DONE if comparison.agrees else EXIT_DIFFERENT


def do_sweep(sweep: Path, out: Path | None, listed: bool, again: str, **how: Any) -> int:
    """`crackgrow sweep`: a run for each combination of parameters; `how` its runs are made is for all studies alike."""
    study = crackgrow.plan_sweep(sweep, out)
    if listed:
        return _list(study)
    say(f"{study.name}: {counted(len(study.runs), 'run')} over {', '.join(study.parameters)}")
    rows: list[Row] = []
    try:
        for row in crackgrow.sweep(study, **how):
            rows.append(row)
            _show(rows, study)
    except KeyboardInterrupt:
        return _interrupted(study.folder, again)
    n_done, n_before = sum(row.done for row in rows), sum(not row.new for row in rows)
    before = f", {n_before} of them done before" if n_before else ""
    say(f"{counted(n_done, 'run')} done{before}, {len(study.runs) - n_done} not\nresults in {study.folder}")
    return EXIT_DONE if n_done else EXIT_UNSOLVED


def do_fit(fit: Path, out: Path | None, again: str, **how: Any) -> int:
    """`crackgrow fit`: keys of a case by what was measured; `how` as of `sweep`."""
    plan = crackgrow.plan_fit(fit, out)
    say(f"{fit.stem}: {', '.join(plan.names)} by {counted(len(plan.points), 'measured point')}")
    try:
        found = crackgrow.fit(plan, lambda row: say(str(row)), **how)
    except KeyboardInterrupt:
        return _interrupted(plan.folder, again)
    say(f"{found}\nresults in {plan.folder}")
    return EXIT_DONE


def do_trade(
    case: Path,
    overrides: list[str],
    at: list[str],
    tolerance: str,
    increments: list[str],
    steps: int | None,
    as_json: bool,
    out: Path | None,
    listed: bool,
    again: str,
    **how: Any,
) -> int:
    """`crackgrow trade`: what accuracy costs, and whether a case's own setting is good enough; `how` as of `sweep`."""
    from crackgrow.run.loop import for_each  # only now: they load numpy
    from crackgrow.study.trade import trade_record, trade_text

    load_case_file(case, overrides)  # tells best what is wrong with the file
    plan = crackgrow.plan_trade(
        case, out, overrides=overrides, settings=at, tolerance=tolerance, increments=increments, steps=steps
    )
    if listed:
        return _list(plan.study)
    rows: list[Row] = []

    def show(row: Row) -> None:
        rows.append(row)
        if not as_json:
            _show(rows, plan.study)

    try:
        found, table = for_each(crackgrow.trade(plan, **how), show)
    except KeyboardInterrupt:
        return _interrupted(plan.study.folder, again)
    if as_json:
        hand_out_json(trade_record(found, table))
    else:
        say(f"\n{trade_text(found, table)}\nresults in {plan.study.folder}")
    return EXIT_DONE if found.good_enough else EXIT_DIFFERENT


def _show(rows: list[Row], study: Study) -> None:
    """Tell of the run that has ended last, if it was run now."""
    if rows[-1].new:
        say(f"[{len(rows)}/{len(study.runs)}] {rows[-1]}")


def _list(study: Study) -> int:
    """Print the command of each run."""
    for run in study.runs:
        if run.case is None:
            complain(f"{run.name}: refused: {run.refusal}")
        else:
            say(spelled(*run.command))
    return EXIT_DONE


def _interrupted(folder: Path, again: str) -> int:
    complain(f"crackgrow: interrupted, what has ended is in {folder}; go on with: {again}")
    return EXIT_INTERRUPTED
