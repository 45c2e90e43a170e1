"""The commands that learn from several runs: `crackgrow compare`, `sweep` and `trade`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

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
    from crackgrow.study.plan import Study
    from crackgrow.study.table import Row

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
Run a case for each combination of parameters, several at a time: a folder for each run, and all of it in sweep.csv and
sweep.png. Every combination is checked before anything runs; one that is refused or fails is a row.
"""
SWEEP_EXAMPLES = """\
The sweep file: base (a case), parameters (keys of the case with lists or {from, to, n, scale}), design (grid, zip,
latin_hypercube), set, reference, output, responses. cases/sweeps/angle_friction.yaml has them with comments.

examples:
  crackgrow sweep cases/sweeps/angle_friction.yaml --workers 2
  crackgrow sweep cases/sweeps/angle_friction.yaml --resume
  crackgrow sweep cases/sweeps/angle_friction.yaml --scheduler tcp://127.0.0.1:8786
  crackgrow sweep cases/sweeps/angle_friction.yaml --list
"""


def sweep(arguments: argparse.Namespace) -> int:
    """`crackgrow sweep`: a run for each combination of parameters."""
    study = crackgrow.plan_sweep(arguments.sweep, arguments.out)
    if arguments.list:
        return _list(study)
    say(f"{study.name}: {counted(len(study.runs), 'run')} over {', '.join(study.parameters)}")
    told = _Told(study)
    try:
        for row in crackgrow.sweep(study, **_asked(arguments)):
            told.show(row)
    except KeyboardInterrupt:
        return _interrupted(arguments, study, str(arguments.sweep))
    before = f", {told.n_before} of them done before" if told.n_before else ""
    say(f"{counted(told.n_done, 'run')} done{before}, {told.n - told.n_done} not\nresults in {study.folder}")
    return EXIT_DONE if told.n_done else EXIT_UNSOLVED


def add_sweep(commands: Commands) -> None:
    what = "run a case for each combination of parameters"
    command = add_command(commands, sweep, "sweep", what, (SWEEP_HELP, SWEEP_EXAMPLES))
    command.add_argument("sweep", type=path, metavar="SWEEP.yaml", help="the sweep file")
    _add_running(command, "one a core", None)
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the results (default outputs/<sweep>)")


TRADE_HELP = """\
Tell what accuracy costs in a case and whether its own setting is good enough: it is run on three settings or more of
its cells, and as it is; where cracks grow also with half the increment. The table says what each is off by (K at each
tip and step, and the critical load factor, against what they tend to; paths against that on the finest cells), its
CPU seconds and memory.
It takes about as long as six runs of the case; `--steps` makes it shorter.
"""
TRADE_EXAMPLES = """\
Settings are presets or targets of the error of K, the coarsest first. Results are in trade.csv, trade.png and
convergence.csv. To vary other keys of a case, and hold runs against finer ones, use `crackgrow sweep` with `reference`.

exit codes: 0 the case's own setting is good enough; 2 the case is wrong; 3 a run has not ended; 4 it is not.

examples:
  crackgrow trade cases/compression30.yaml --steps 4
  crackgrow trade cases/edge_tension.yaml --at 3% 1% 0.3% 0.1% --tolerance 0.5%
  crackgrow trade cases/two_flaws.yaml --increments "1 mm" "0.5 mm" --json
"""


def trade(arguments: argparse.Namespace) -> int:
    """`crackgrow trade`: what accuracy costs, and whether a case's own setting is good enough."""
    from crackgrow.run.loop import for_each  # only now: they load numpy
    from crackgrow.study.trade_text import trade_record, trade_text

    load_case_file(arguments)  # tells best what is wrong with the file
    plan = crackgrow.plan_trade(
        arguments.case,
        arguments.out,
        overrides=arguments.overrides,
        settings=arguments.at,
        tolerance=arguments.tolerance,
        increments=arguments.increments,
        steps=arguments.steps,
    )
    if arguments.list:
        return _list(plan.study)
    told = _Told(plan.study)
    try:
        show = (lambda row: None) if arguments.json else told.show
        found, table = for_each(crackgrow.trade(plan, **_asked(arguments)), show)
    except KeyboardInterrupt:
        return _interrupted(arguments, plan.study, str(arguments.case))
    if arguments.json:
        hand_out_json(trade_record(found, table))
    else:
        say(f"\n{trade_text(found, table)}\nresults in {plan.study.folder}")
    return EXIT_DONE if found.good_enough else EXIT_DIFFERENT


def add_trade(commands: Commands) -> None:
    what = "say what accuracy costs in a case, and whether its setting is good enough"
    command = takes_case(add_command(commands, trade, "trade", what, (TRADE_HELP, TRADE_EXAMPLES)))
    command.add_argument(
        "--at",
        nargs="+",
        default=["draft", "standard", "fine"],
        metavar="SETTING",
        help="presets or targets (draft standard fine)",
    )
    command.add_argument("--tolerance", default="1 %", metavar="SHARE", help="of K, over the largest of a step (1 %%)")
    command.add_argument(
        "--increments",
        nargs="+",
        default=["half"],
        metavar="LENGTH",
        help="other increments, with steps to the same length: lengths, half (the default), or none",
    )
    command.add_argument("--steps", type=int, metavar="N", help="growth steps (default: those of the case)")
    command.add_argument("--json", action="store_true", help="print all of it as JSON, SI, in place of the table")
    _add_running(command, "1, for seconds that nothing else has a part in", 1)
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the results (default outputs/trade/<case>)")


class _Told:
    """Tells of each run of a study as it ends, and counts."""

    def __init__(self, study: Study) -> None:
        self.n = len(study.runs)
        self.n_met = self.n_done = self.n_before = 0

    def show(self, row: Row) -> None:
        self.n_met += 1
        self.n_done += row.done
        self.n_before += not row.new
        if row.new:
            say(f"[{self.n_met}/{self.n}] {row}")


def _list(study: Study) -> int:
    """Print the command of each run."""
    for run in study.runs:
        if run.case is None:
            complain(f"{run.name}: refused: {run.refusal}")
        else:
            say(spelled(*run.command))
    return EXIT_DONE


OPTIONS = ("workers", "scheduler", "memory", "timeout")


def _asked(arguments: argparse.Namespace) -> dict[str, Any]:
    """How the runs of a study are to be made."""
    return {name: getattr(arguments, name) for name in (*OPTIONS, "resume")}


def _interrupted(arguments: argparse.Namespace, study: Study, file: str) -> int:
    """Say how to go on."""
    settings = [] if study.command == "sweep" else _of_trade(arguments)
    given = {f"--{name}": getattr(arguments, name) for name in OPTIONS}
    settings += [word for name, value in given.items() if value is not None for word in (name, str(value))]
    command = spelled(study.command, file, "--out", str(study.folder), *settings, "--resume")
    complain(f"crackgrow: interrupted, what has ended is in {study.folder}; go on with: {command}")
    return EXIT_INTERRUPTED


def _of_trade(arguments: argparse.Namespace) -> list[str]:
    sets = [word for setting in arguments.overrides for word in ("--set", setting)]
    steps = [] if arguments.steps is None else ["--steps", str(arguments.steps)]
    tolerance = ["--tolerance", arguments.tolerance]
    return [*sets, "--at", *arguments.at, *tolerance, "--increments", *arguments.increments, *steps]


def _add_running(command: argparse.ArgumentParser, default: str, workers: int | None) -> None:
    """The options of how runs are made, which all studies have."""
    place = command.add_mutually_exclusive_group()
    place.add_argument(
        "--workers", type=count, default=workers, metavar="N", help=f"processes of this machine (default: {default})"
    )
    place.add_argument("--scheduler", metavar="ADDRESS", help="use the workers of this Dask scheduler: tcp://HOST:PORT")
    place.add_argument("--list", action="store_true", help="print the command of each run, for job arrays; run nothing")
    command.add_argument("--memory", metavar="SIZE", help="of each run, such as 2GB")
    command.add_argument("--timeout", type=float, metavar="SECONDS", help="give up a run after so long")
    command.add_argument("--resume", action="store_true", help="run what is missing, go on with what was broken off")
