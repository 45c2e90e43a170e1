"""`crackgrow report`."""

from __future__ import annotations

import argparse

from crackgrow.cli.console import EXIT_DONE, say
from crackgrow.cli.parser import Commands, add_command, path

HELP = """\
Write report.html of a result folder: the scene, crack paths, stress intensity, loads, tractions along the faces,
energies, checks with their limits, warnings and the case, on one page that needs no network. Every run ends with one,
unless output.report is false; this makes it again, from the files of the folder alone.
"""
EXAMPLES = """\
With pictures that `crackgrow render` has made before, the slider of the page moves those too.

examples:
  crackgrow report outputs/compression30
  crackgrow render outputs/compression30 && crackgrow report outputs/compression30
"""


def report(arguments: argparse.Namespace) -> int:
    """`crackgrow report`: the page about a run, made again."""
    from crackgrow.results.report import write_report  # only now: it loads numpy

    say(str(write_report(arguments.folder)))
    return EXIT_DONE


def add(commands: Commands) -> None:
    what = "write report.html of a result folder again"
    command = add_command(commands, report, "report", what, (HELP, EXAMPLES))
    command.add_argument("folder", type=path, metavar="DIR", help="the folder that `crackgrow run` wrote")
