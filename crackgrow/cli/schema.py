"""`crackgrow schema`."""

from __future__ import annotations

import argparse

from crackgrow.cli.console import EXIT_DONE, hand_out
from crackgrow.cli.parser import Commands, add_command, path
from crackgrow.results.atomic import write_text

HELP = """\
Print the JSON Schema (draft 7) of case files: with it an editor completes keys and words, shows what a key means and
in which units, and marks mistakes as they are typed. It is made from what the reader itself checks with.
"""
EXAMPLES = """\
examples:
  crackgrow schema --out cases/case.schema.json

VS Code with the YAML plugin, and any editor with yaml-language-server, then follow a comment at the top of a case,
  # yaml-language-server: $schema=case.schema.json
which names the schema relative to the case. What it cannot tell, such as names and geometry, `crackgrow check` does.
"""


def schema(arguments: argparse.Namespace) -> int:
    """`crackgrow schema`: print or write the JSON Schema of case files."""
    from crackgrow.case.json_schema import case_schema  # only now: it loads numpy

    text = case_schema()
    if arguments.out is None:
        hand_out(text)
    else:
        write_text(arguments.out, text)
    return EXIT_DONE


def add(commands: Commands) -> None:
    what = "print the JSON Schema of case files, for editors"
    command = add_command(commands, schema, "schema", what, (HELP, EXAMPLES))
    command.add_argument("--out", type=path, metavar="FILE", help="write it to a file")
