"""The commands that learn from several runs: `crackgrow compare`, `sweep`, `converge` and `trade`."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.cli.console import (
    EXIT_DIFFERENT,
    EXIT_DONE,
    EXIT_INTERRUPTED,
    EXIT_UNSOLVED,
    complain,
    count,
    hand_out_json,
    say,
    spelled,
)
from crackgrow.cli.parser import Commands, add_command, load_case_file, path, takes_case
from crackgrow.results.atomic import write_text
from crackgrow.results.units import counted

if TYPE_CHECKING:
    from crackgrow.study.sweep.plan import SweepPlan

COMPARE_HELP = """\
Compare the crack paths of two result folders, or of a folder and a CSV file, crack by crack and tip by tip:
Hausdorff and Frechet distance of what has grown, distance of the tips, the place of the largest deviation.
"""
COMPARE_EXAMPLES = """\
A CSV has columns x and y in m, or x_mm and y_mm, and may have crack, vertex and step. Without step it may hold a
part of a path, such as one wing: then the part that both have is compared.

exit codes: 0 done; 2 or 3 a path cannot be read; 4 beyond the tolerance (1 in versions before this one).

examples:
  crackgrow compare outputs/before outputs/after --tolerance "0.15 mm"
  crackgrow compare outputs/compression30 paper.csv --crack flaw --tip end --columns x_mm_fem,y_mm
"""


def compare(arguments: argparse.Namespace) -> int:
    """`crackgrow compare`: how far apart the crack paths of two runs are."""
    from crackgrow.study.comparison_text import comparison_csv, comparison_record, comparison_text  # loads numpy

    comparison = crackgrow.compare_paths(
        arguments.a,
        arguments.b,
        tolerance=arguments.tolerance,
        crack=arguments.crack,
        tip=arguments.tip,
        columns=arguments.columns,
    )
    if arguments.json:
        hand_out_json(comparison_record(comparison))
    else:
        say(comparison_text(comparison))
    if arguments.csv is not None:
        write_text(arguments.csv, comparison_csv(comparison))
    return EXIT_DONE if comparison.agrees else EXIT_DIFFERENT


def add_compare(commands: Commands) -> None:
    what = "say how far apart the crack paths of two runs are"
    command = add_command(commands, compare, "compare", what, (COMPARE_HELP, COMPARE_EXAMPLES))
    for name in ("a", "b"):
        command.add_argument(name, metavar=name.upper(), help="a result folder or a CSV file")
    command.add_argument(
        "--tolerance", metavar="LENGTH", help='largest distance allowed: "0.15 mm", or a bare number in m'
    )
    command.add_argument("--csv", type=path, metavar="FILE", help="write the rows of the table, SI, to a file")
    command.add_argument("--json", action="store_true", help="print all of it as JSON, SI, in place of the table")
    command.add_argument("--crack", metavar="NAME", help="compare this crack alone")
    command.add_argument("--tip", choices=("start", "end"), help="compare what has grown at this tip alone")
    command.add_argument("--columns", type=_two_names, metavar="X,Y", help="columns of x and y of a CSV with several")


def _two_names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if len(names) != 2 or not all(names):
        raise argparse.ArgumentTypeError(f"{text!r}: two column names are wanted, that of x and that of y: X,Y")
    return names


SWEEP_HELP = """\
Run a case for each combination of parameters, several at a time: a folder for each run, and all of it in sweep.csv,
sweep.parquet and sweep.png. Every combination is checked before anything runs; one that is refused or fails is a row.
"""
SWEEP_EXAMPLES = """\
The sweep file: base (a case), parameters (keys of the case with lists or {from, to, n, scale}), design (grid, zip,
latin_hypercube), set, output, responses. cases/sweeps/angle_friction.yaml has all of them with comments.

examples:
  crackgrow sweep cases/sweeps/angle_friction.yaml --workers 2
  crackgrow sweep cases/sweeps/angle_friction.yaml --resume
  crackgrow sweep cases/sweeps/angle_friction.yaml --scheduler tcp://127.0.0.1:8786
"""


def sweep(arguments: argparse.Namespace) -> int:
    """`crackgrow sweep`: a run for each combination of parameters."""
    plan = crackgrow.plan_sweep(arguments.sweep, arguments.out)
    try:
        n_done = _run(plan, arguments)
    except KeyboardInterrupt:
        complain(
            f"crackgrow: interrupted, what has ended is in {plan.folder}; go on with: {_resuming(arguments, plan)}"
        )
        return EXIT_INTERRUPTED
    return EXIT_DONE if n_done else EXIT_UNSOLVED


def _run(plan: SweepPlan, arguments: argparse.Namespace) -> int:
    """Run the sweep and tell of each run; returns how many are done."""
    from crackgrow.study.sweep.runner import sweep_line  # only now: it loads numpy

    n_runs, n_before, n_failed = len(plan.runs), 0, 0
    say(f"{plan.name}: {counted(n_runs, 'run')} over {', '.join(plan.parameters)}")
    rows = crackgrow.sweep(
        plan,
        workers=arguments.workers,
        scheduler=arguments.scheduler,
        memory=arguments.memory,
        resume=arguments.resume,
    )
    for number, row in enumerate(rows, start=1):
        n_before += not row.new
        n_failed += not row.done
        if row.new:
            say(f"[{number}/{n_runs}] {sweep_line(row)}")
    before = f", {n_before} of them done before" if n_before else ""
    say(f"{counted(n_runs - n_failed, 'run')} done{before}, {n_failed} not\nresults in {plan.folder}")
    return n_runs - n_failed


def _resuming(arguments: argparse.Namespace, plan: SweepPlan) -> str:
    """The command that goes on."""
    given = {"--workers": arguments.workers, "--scheduler": arguments.scheduler, "--memory": arguments.memory}
    settings = [word for name, value in given.items() if value is not None for word in (name, str(value))]
    return spelled("sweep", str(arguments.sweep), "--out", str(plan.folder), *settings, "--resume")


def add_sweep(commands: Commands) -> None:
    what = "run a case for each combination of parameters"
    command = add_command(commands, sweep, "sweep", what, (SWEEP_HELP, SWEEP_EXAMPLES))
    command.add_argument("sweep", type=path, metavar="SWEEP.yaml", help="the sweep file")
    place = command.add_mutually_exclusive_group()
    place.add_argument("--workers", type=count, metavar="N", help="processes of this machine (default: one a core)")
    place.add_argument("--scheduler", metavar="ADDRESS", help="use the workers of this Dask scheduler: tcp://HOST:PORT")
    command.add_argument("--memory", metavar="SIZE", help="of each worker, such as 2GB")
    command.add_argument("--resume", action="store_true", help="run what is missing, go on with what was broken off")
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the results (default outputs/<sweep>)")


CONVERGE_HELP = """\
Run a case on three settings of its cells and tell what K at each tip and step, and the critical load factor, tend to,
what each setting misses of it, and whether the case's own setting is good enough. Where cracks grow also how far apart
the paths are, and whether finer cells or a shorter increment would move them more.
It takes about as long as five runs of the case; `--steps` makes it shorter.
"""
CONVERGE_EXAMPLES = """\
Settings are presets or targets of the error of K, the coarsest first. Results are in runs/ of the folder, all rows in
converge.csv. To choose among other settings of a case, or hold many of them against time, use `crackgrow trade`.

exit codes: 0 the case's own setting is good enough; 2 the case is wrong; 3 a setting has no first step; 4 it is not.

examples:
  crackgrow converge cases/compression30.yaml --steps 4
  crackgrow converge cases/edge_tension.yaml --at 3% 1% 0.3% --tolerance 0.5%
  crackgrow converge cases/two_flaws.yaml --no-increments --json
"""


def converge(arguments: argparse.Namespace) -> int:
    """`crackgrow converge`: whether a case's own setting is good enough."""
    from crackgrow.run.loop import through  # only now: they load numpy
    from crackgrow.study.converge.text import convergence_record, convergence_text, run_line

    case = load_case_file(arguments)
    folder = arguments.out or Path("outputs/converge") / case.name
    plan = crackgrow.plan_convergence(
        arguments.case,
        folder,
        overrides=arguments.overrides,
        settings=arguments.at,
        tolerance=arguments.tolerance,
        increments=arguments.increments,
        steps=arguments.steps,
    )
    found = through(
        crackgrow.converge(plan, arguments.timeout), lambda run: None if arguments.json else say(run_line(run))
    )
    if arguments.json:
        hand_out_json(convergence_record(found))
    else:
        say(f"\n{convergence_text(found)}\nresults in {folder}")
    return EXIT_DONE if found.good_enough else EXIT_DIFFERENT


def add_converge(commands: Commands) -> None:
    what = "say whether a case's cells and increments are small enough"
    command = takes_case(add_command(commands, converge, "converge", what, (CONVERGE_HELP, CONVERGE_EXAMPLES)))
    command.add_argument(
        "--at",
        nargs=3,
        default=["draft", "standard", "fine"],
        metavar="SETTING",
        help="presets or targets (draft standard fine)",
    )
    command.add_argument("--tolerance", default="1 %", metavar="SHARE", help="of K, over the largest of a step (1 %%)")
    command.add_argument(
        "--increments",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="run half the increment, too (default: where that takes no longer than the rest)",
    )
    command.add_argument("--steps", type=int, metavar="N", help="growth steps (default: those of the case)")
    command.add_argument("--timeout", type=float, metavar="SECONDS", help="give up a run after so long")
    command.add_argument("--json", action="store_true", help="print all of it as JSON, SI, in place of the table")
    command.add_argument(
        "--out", type=path, metavar="DIR", help="folder of the results (default outputs/converge/<case>)"
    )


TRADE_HELP = """\
Run a scene over a grid of settings and hold each run against a finer one: trade.csv has errors, seconds and memory of
every setting, trade.png draws errors over time with the Pareto front and the presets draft, standard and fine.
Whether the cells and the increment of a case are small enough `crackgrow converge` tells, in three to five runs.
"""
TRADE_EXAMPLES = """\
axes: spacing, support, quadrature, contact_spacing, stiffness, solver, tip_radius, increment, accuracy (names and
targets), tips, kinks, corners (refinement levels), tip_functions; every combination of their values is run, each in a
process of its own, one after another. Without --axis: spacings round the automatic one, and what else matters to
the scene. The reference is a run at half the finest spacing, a result folder, or settings of the case. A setting that
fails is a row with its reason.

examples:
  crackgrow trade cases/compression30.yaml --axis spacing=3,2,1.5,1 support=1.5,2 --steps 4
  crackgrow trade cases/edge_tension.yaml --reference numerics.spacing=0.3 --repeat 3
  crackgrow trade cases/compression30.yaml --reference outputs/very_fine --resume
"""


def trade(arguments: argparse.Namespace) -> int:
    """`crackgrow trade`: errors and seconds over a grid of settings."""
    from crackgrow.study.setting import CaseFile  # only now: they load the solver
    from crackgrow.study.trade.plan import plan_trade
    from crackgrow.study.trade.row import trade_line
    from crackgrow.study.trade.runner import trade as trials

    case = load_case_file(arguments)
    folder = arguments.out or Path("outputs/trade") / case.name
    plan = plan_trade(
        CaseFile(arguments.case, tuple(arguments.overrides)),
        folder,
        axes=arguments.axis,
        reference=arguments.reference,
        steps=arguments.steps,
    )
    say(f"{case.name}: {len(plan.settings)} settings")
    rows = []
    for row in trials(plan, repeat=arguments.repeat, resume=arguments.resume, timeout=arguments.timeout):
        rows.append(row)
        say(trade_line(row))
    say(f"{len(rows)} new rows, {sum(not row.solved for row in rows)} not solved\nresults in {folder}")
    names = {setting.name for setting in plan.settings}
    solved = [row.solved for row in rows if row.name in names]  # not the reference, which is solved or ends it all
    return EXIT_UNSOLVED if solved and not any(solved) else EXIT_DONE


def add_trade(commands: Commands) -> None:
    what = "measure what accuracy costs over a grid of settings"
    command = takes_case(add_command(commands, trade, "trade", what, (TRADE_HELP, TRADE_EXAMPLES)))
    command.add_argument("--axis", nargs="+", default=[], metavar="NAME=A,B,C", help="settings to vary, with values")
    command.add_argument(
        "--reference",
        nargs="+",
        default=["finest"],
        metavar="WHAT",
        help="finest (default: half the finest spacing), a result folder, or KEY=VALUE...",
    )
    command.add_argument(
        "--steps", type=int, metavar="N", help="growth steps of the case's increment (default: its own)"
    )
    command.add_argument("--repeat", type=count, default=1, metavar="N", help="runs of each setting; the median counts")
    command.add_argument("--timeout", type=float, metavar="SECONDS", help="give up a run after so long")
    command.add_argument("--resume", action="store_true", help="keep the rows that are there, run what is missing")
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the results (default outputs/trade/<case>)")
