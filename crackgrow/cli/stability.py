"""`crackgrow stability`."""

from __future__ import annotations

import argparse
from pathlib import Path

from crackgrow.cli.case_file import load_case_file
from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE, say

HELP = """\
Take a scene to extremes, one axis at a time and some pairs, and hold the results against references and invariants:
stability.csv, stability.md and stability.png. Without a case: the scenes of the folder `cases`, and all axes. With one:
what holds for any scene, that is balance, units, where the lattice lies, the scene turned, mirrored and moved.
"""
EXAMPLES = """\
verdicts: yes: within the tolerance; said: no good, or refused, and the program says so; NO: neither. Exit code 4: a NO.

examples:
  crackgrow stability --short
  crackgrow stability --axis poisson contrast
  crackgrow stability my_case.yaml --out outputs/my_stability
"""


def stability(arguments: argparse.Namespace) -> int:
    """`crackgrow stability`: a scene at the extremes."""
    from crackgrow.study.stability.runner import stability as trials  # only now: they load the solver
    from crackgrow.study.stability.table import stability_line
    from crackgrow.study.stability.writer import write_stability

    case = None if arguments.case is None else load_case_file(arguments)
    rows = []
    for row in trials(case, arguments.axis, short=arguments.short):
        rows.append(row)
        say(stability_line(row))
    write_stability(arguments.out, rows)
    good = all(row.verdict != "NO" for row in rows)
    say(f"{len(rows)} rows, {sum(row.verdict == 'NO' for row in rows)} NO\nresults in {arguments.out}")
    return EXIT_DONE if good else EXIT_DIFFERENT


def add_stability(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command and its arguments."""
    command = commands.add_parser(
        "stability",
        help="take a scene to extremes and hold the results against references and invariants",
        description=HELP,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("case", type=Path, nargs="?", metavar="CASE.yaml", help="a case file of your own")
    command.add_argument("--axis", nargs="+", default=[], metavar="NAME", help="these axes alone")
    command.add_argument("--short", action="store_true", help="coarse scenes, and few values of every axis")
    command.add_argument(
        "--out", type=Path, default=Path("outputs/stability"), metavar="DIR", help="folder of the results"
    )
    command.set_defaults(command=stability, overrides=[])
