"""`crackgrow list`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import yaml

from crackgrow.cli.console import EXIT_DONE, hand_out
from crackgrow.cli.new import templates
from crackgrow.cli.parser import Commands, add_command, path
from crackgrow.errors import CaseError
from crackgrow.results.units import aligned

HELP = "List the cases of a folder with their titles, its sweeps, and the templates of `crackgrow new`."
EXAMPLES = """\
examples:
  crackgrow list
  crackgrow list studies/shear
"""


def list_cases(arguments: argparse.Namespace) -> int:
    """`crackgrow list`: what there is to run, and to start from."""
    folder: Path = arguments.folder or Path("cases")
    if arguments.folder is not None and not folder.is_dir():
        raise CaseError.at(folder, "is no folder")
    lines = [*_listed(folder, "cases", "run"), *_listed(folder / "sweeps", "sweeps", "sweep")]
    lines += ["templates: crackgrow new NAME --template ...", *aligned(templates().items(), 2, "  ")]
    hand_out("\n".join(lines) + "\n")
    return EXIT_DONE


def _listed(folder: Path, what: str, command: str) -> Iterator[str]:
    """A line for each YAML file of a folder, if there are any."""
    files = sorted(folder.glob("*.yaml"))
    if files:
        yield f"{what} in {folder}: crackgrow {command} FILE"
        yield from aligned([(str(file), _title(file)) for file in files], 2, "  ")


def _title(file: Path) -> str:
    """The title of a case, or the comment at the top; nothing where neither is a line that can be read."""
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return "(cannot be read)"
    for line in lines:
        if line.startswith("title:"):
            try:
                return str(yaml.safe_load(line)["title"])
            except yaml.YAMLError:
                return ""
    return lines[0].removeprefix("#").strip() if lines and lines[0].startswith("#") else ""


def add(commands: Commands) -> None:
    what = "list the cases that are here, and the templates"
    command = add_command(commands, list_cases, "list", what, (HELP, EXAMPLES))
    command.add_argument("folder", nargs="?", type=path, metavar="DIR", help="a folder of cases (default: cases)")
