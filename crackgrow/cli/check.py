"""`crackgrow check`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from crackgrow.cli.case_file import load_case_file
from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE, hand_out_json, say
from crackgrow.cli.parser import Commands, add_command, takes_case

HELP = """\
Validate a case and print the plan of its run: bodies, cracks and tips, what is modelled and why, the unknowns of the
first step, counted on its cover, what a step costs in seconds and memory, and what to beware of. Nothing is solved
unless --unique asks whether friction leaves the contact one solution at every load factor, or --invariance whether the
first step is in balance and the same in other units, on another lattice, turned, mirrored and moved.
"""
EXAMPLES = """\
exit codes: 0 the case can be run; 2 it is wrong, all faults are listed; 3 its cracks cannot be covered, or with
--unique its loads not be solved; 4 with --invariance: something changes that must not, and no warning says so (a NO).
verdicts of --invariance: yes: within the tolerance; said: no good, or refused, and the program says so; NO: neither.

examples:
  crackgrow check cases/compression30.yaml
  crackgrow check cases/two_flaws.yaml --set numerics.spacing=1 --picture two_flaws.svg
  crackgrow check cases/confined30.yaml --unique
  crackgrow check cases/junction_static.yaml --invariance
"""


def check(arguments: argparse.Namespace) -> int:
    """`crackgrow check`: validate a case, say what it models, and draw it if asked to."""
    case = load_case_file(arguments)
    from crackgrow.plan.text import plan_record, plan_text  # only now: it loads numpy

    tell = (lambda text: None) if arguments.json else say
    record = plan_record(case) if arguments.json else {}
    if not arguments.json:
        say(plan_text(case))
    if arguments.picture is not None:
        from crackgrow.plan.picture import draw_scene  # only now: it loads matplotlib

        draw_scene(arguments.picture, case)
        tell(f"picture in {arguments.picture}")
    if arguments.unique:
        from crackgrow.study.uniqueness import unique_text  # only now: it loads the solver

        tell("\nsolutions of the contact")
        record["unique"] = list(_told(unique_text(case), tell))
    rows = []
    if arguments.invariance:
        # only now: they load the solver
        from crackgrow.study.invariance.axes import invariance, line_of, record_of

        tell("\nwhat must not change")
        for row in invariance(case):
            rows.append(row)
            tell(line_of(row))
        record["invariance"] = [record_of(row) for row in rows]
    if arguments.json:
        hand_out_json(record)
    return EXIT_DIFFERENT if any(row.verdict == "NO" for row in rows) else EXIT_DONE


def _told(lines: Iterable[str], tell: Callable[[str], None]) -> Iterator[str]:
    """The same lines, each told as soon as it is there."""
    for line in lines:
        tell(line)
        yield line


def add(commands: Commands) -> None:
    what = "validate a case, say what it models and costs"
    command = takes_case(add_command(commands, check, "check", what, (HELP, EXAMPLES)))
    command.add_argument("--picture", type=_picture, metavar="FILE.png|svg", help="draw the scene, too")
    command.add_argument("--json", action="store_true", help="print the plan as JSON")
    command.add_argument(
        "--unique", action="store_true", help="solve the first step: does friction leave one solution?"
    )
    command.add_argument(
        "--invariance",
        action="store_true",
        help="solve it in other units, on other lattices, turned, mirrored, moved: is it the same?",
    )


def _picture(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in (".png", ".svg"):
        raise argparse.ArgumentTypeError(f"{text!r}: a name that ends in .png or .svg is wanted")
    return path
