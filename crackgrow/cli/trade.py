"""`crackgrow trade`."""

from __future__ import annotations

import argparse
from pathlib import Path

from crackgrow.cli.case_file import load_case_file
from crackgrow.cli.console import EXIT_DONE, EXIT_UNSOLVED, count, say
from crackgrow.cli.parser import Commands, add_command, path, takes_case

HELP = """\
Run a scene over a grid of settings and hold each run against a finer one: trade.csv has errors, seconds and memory of
every setting, trade.png draws errors over time with the Pareto front and the presets draft, standard and fine.
Whether the cells and the increment of a case are small enough `crackgrow converge` tells, in three to five runs.
"""
EXAMPLES = """\
axes: spacing, support, quadrature, contact_spacing, stiffness, solver, tip_radius, increment, accuracy (presets and
targets), tips, kinks, corners (halvings of cells there), tip_functions; every combination of their values is run, each
in a process of its own, one after another. Without --axis: spacings round the automatic one, and what else matters to
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


def add(commands: Commands) -> None:
    what = "measure what accuracy costs over a grid of settings"
    command = takes_case(add_command(commands, trade, "trade", what, (HELP, EXAMPLES)))
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
