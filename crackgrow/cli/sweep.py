"""`crackgrow sweep`."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.cli.console import EXIT_DONE, EXIT_INTERRUPTED, EXIT_UNSOLVED, complain, count, say, spelled
from crackgrow.cli.parser import Commands, add_command, path
from crackgrow.results.units import counted

if TYPE_CHECKING:
    from crackgrow.study.sweep.plan import SweepPlan

HELP = """\
Run a case for each combination of parameters, several at a time: a folder for each run, and all of it in sweep.csv,
sweep.parquet and sweep.png. Every combination is checked before anything runs; one that is refused or fails is a row.
"""
EXAMPLES = """\
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


def add(commands: Commands) -> None:
    what = "run a case for each combination of parameters"
    command = add_command(commands, sweep, "sweep", what, (HELP, EXAMPLES))
    command.add_argument("sweep", type=path, metavar="SWEEP.yaml", help="the sweep file")
    place = command.add_mutually_exclusive_group()
    place.add_argument("--workers", type=count, metavar="N", help="processes of this machine (default: one a core)")
    place.add_argument("--scheduler", metavar="ADDRESS", help="use the workers of this Dask scheduler: tcp://HOST:PORT")
    command.add_argument("--memory", metavar="SIZE", help="of each worker, such as 2GB")
    command.add_argument("--resume", action="store_true", help="run what is missing, go on with what was broken off")
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the results (default outputs/<sweep>)")
