"""`crackgrow converge`."""

from __future__ import annotations

import argparse
from pathlib import Path

import crackgrow
from crackgrow.cli.case_file import load_case_file
from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE, hand_out_json, say
from crackgrow.cli.parser import Commands, add_command, path, takes_case

HELP = """\
Run a case on three settings of its cells and tell what K at each tip and step, and the critical load factor, tend to,
what each setting misses of it, and whether the case's own setting is good enough. Where cracks grow also how far apart
the paths are, and whether finer cells or a shorter increment would move them more.
It takes about as long as five runs of the case; `--steps` makes it shorter.
"""
EXAMPLES = """\
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
    from crackgrow.run.ending import Ending  # only now: they load numpy
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
    runs = Ending(crackgrow.converge(plan, arguments.timeout))
    for run in runs:
        if not arguments.json:
            say(run_line(run))
    found = runs.end
    if arguments.json:
        hand_out_json(convergence_record(found))
    else:
        say(f"\n{convergence_text(found)}\nresults in {folder}")
    return EXIT_DONE if found.good_enough else EXIT_DIFFERENT


def add(commands: Commands) -> None:
    what = "say whether a case's cells and increments are small enough"
    command = takes_case(add_command(commands, converge, "converge", what, (HELP, EXAMPLES)))
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
