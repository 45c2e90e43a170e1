"""`crackgrow explain`."""

from __future__ import annotations

import argparse

from crackgrow.cli.console import EXIT_DONE, hand_out
from crackgrow.cli.parser import Commands, add_command
from crackgrow.errors import CaseError

HELP = """\
Say what a key of a case means, its type, unit, default and what is allowed; or what a word means that a key takes; or
what is in a file or column of the results. Without a name: the first keys of a case, and the files of a run.
"""
EXAMPLES = """\
examples:
  crackgrow explain numerics.spacing
  crackgrow explain cracks                 # with all keys below it
  crackgrow explain friction               # every key of that name
  crackgrow explain loading.critical       # a word that a key takes
  crackgrow explain tips.csv
  crackgrow explain K_II
"""


def explain_name(arguments: argparse.Namespace) -> int:
    """`crackgrow explain`: print what is to be known of a key, a file or a column."""
    from crackgrow.cli.reference import explain, first_entries, nearest  # only now: they load numpy

    name: str = arguments.name
    found = explain(name) if name else first_entries()
    if not found:
        near = nearest(name)
        hint = f"; did you mean {' or '.join(near)}?" if near else "; `crackgrow explain` lists what there is"
        raise CaseError.at("explain", f"is no key of a case, file or column of results{hint}", name)
    hand_out("\n".join(line for entry in found for line in entry.lines()) + "\n")
    return EXIT_DONE


def add(commands: Commands) -> None:
    what = "say what a key of a case, or a column of the results, means"
    command = add_command(commands, explain_name, "explain", what, (HELP, EXAMPLES))
    command.add_argument(
        "name", nargs="?", default="", metavar="KEY|COLUMN", help="a key, a word that keys take, a file or a column"
    )
