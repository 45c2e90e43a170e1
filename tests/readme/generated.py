"""The parts of the READMEs that are made of declarations, or of what a command has measured; never written by hand.

python -m tests.readme.generated [--measured] [--pictures]

A part lies between `<!-- generated: NAME -->` and `<!-- end -->`. With --measured also the tables that `make verify`
and `make stability` have written to outputs/, with --pictures the pictures of README.md.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

from crackgrow.case.accuracy import TARGETS, cells_along
from crackgrow.cli.command_line import command_line
from crackgrow.cli.parser import GROUPS, commands_of, helps_of
from crackgrow.cli.reference import FOLDERS, column_entry, key_entry, sections
from crackgrow.results.declarations import File
from tests.readme.pictures import draw_all
from tests.stability.extremes.table import FILE as EXTREMES

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- generated: {} -->", "<!-- end -->"
KEY_FACTS: Final = ("meaning", "type", "unit", "default", "allowed")

CELL_RULES: Final = {
    "width": "smaller side of the narrowest body",
    "tip": "length of a crack; of cells at its tips, and where contact status changes",
    "stretch": "part of a crack behind a tip or beside a kink; of cells there",
    "kink": "length of a crack; of cells at its kinks",
    "end": "length of a crack; of cells at its ends on other lines, and where it meets another",
    "room": "way from a tip to the nearest other crack, interface or outline",
    "increment": "growth increment; of cells at tips",
    "radius": "averaging radius of the tip stress; of cells at tips",
    "feature": "width of a hole, diameter of a re-entrant corner or curve",
    "bridge": "rock between holes, outline and re-entrant corners",
    "distance": "way from the nearest tip to a re-entrant corner or the end of a held part; of cells there",
    "support": "supported part of an edge or interface",
    "load": "loaded part of an edge; length over which a pressure on faces varies",
}
"""Lengths that have a number of cells to begin with."""

MEASURED: Final = {
    ("tests/verification/README.md", "verification"): "outputs/verification/table.md",
    ("tests/stability/README.md", "stability"): "outputs/stability/stability.md",
}
"""Parts by file and name, and the file that a command has written them to: its first table with what is below it."""


def commands() -> str:
    """The commands by group, with what they do."""
    helps = helps_of(commands_of(command_line()))
    rows = [[group, f"`crackgrow {name}`", helps[name]] for group, names in GROUPS.items() for name in names]
    return table(("group", "command", "what it does"), rows)


def keys() -> str:
    """Every key of a case, a table for each that a case begins with."""
    parts = []
    for name, found in sections():
        rows = [[f"`{key.name}`", *(key_entry(key).facts.get(fact, "") for fact in KEY_FACTS)] for key in found]
        parts.append(f"### `{name}`\n\n{table(('key', *KEY_FACTS), rows)}")
    return "\n".join(parts)


def presets() -> str:
    """How many cells a run begins with along a length, for each name, and the target that it stands for."""
    rows = [["error estimate, over the largest value", *(f"{100 * target:g} %" for target in TARGETS.values())]]
    rows += [[words, *(f"{cells_along(kind, name):g}" for name in TARGETS)] for kind, words in CELL_RULES.items()]
    return table(("cells along, to begin with", *(f"`{name}`" for name in TARGETS)), rows)


def files() -> str:
    """The files of a run."""
    return table(("file", "content"), [[f"`{file.name}`", file.doc] for file in FOLDERS["run"]])


def columns(files: Iterable[File]) -> Callable[[], str]:
    """The columns of files, a table for each that has some."""

    def part() -> str:
        tables = [f"### `{file.name}`\n\n{columns_of(file)}" for file in files if file.columns]
        return "\n".join(tables)

    return part


def columns_of(file: File) -> str:
    """A table of the columns of a file."""
    facts = [(column.name, column_entry(file, column).facts) for column in file.columns]
    rows = [[f"`{name}`", known.get("unit", ""), known["meaning"]] for name, known in facts]
    return table(("name", "unit", "meaning"), rows)


PARTS: Final[dict[tuple[str, str], Callable[[], str]]] = {
    ("README.md", "commands"): commands,
    ("cases/README.md", "presets"): presets,
    ("cases/README.md", "keys"): keys,
    ("cases/sweeps/README.md", "columns"): columns(FOLDERS["sweep"]),
    ("outputs/README.md", "files"): files,
    ("outputs/README.md", "columns"): columns(FOLDERS["run"]),
    ("outputs/README.md", "compare"): columns(FOLDERS["compare"]),
    ("tests/benchmarks/README.md", "columns"): columns(FOLDERS["trade"]),
    ("tests/benchmarks/README.md", "converge"): columns(FOLDERS["converge"]),
    ("tests/stability/README.md", "columns"): columns([EXTREMES]),
}
"""What is made of declarations, by file and name."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def part_of(text: str, name: str) -> str:
    """The part that a README has; raises ValueError where it has none of that name."""
    found = re.search(f"{BEGIN.format(name)}\n(.*?){END}", text, re.DOTALL)
    if found is None:
        raise ValueError(f"no part {BEGIN.format(name)} ... {END}")
    return found[1]


def with_part(text: str, name: str, part: str) -> str:
    """The README with another part."""
    begin = BEGIN.format(name)
    return text.replace(f"{begin}\n{part_of(text, name)}{END}", f"{begin}\n\n{part.strip()}\n\n{END}")


def measured(path: Path) -> str:
    """What a command has written, up to its second table."""
    return re.split(r"\n(?=\|[^\n]*\|\n\|[ |-]*\|\n)", path.read_text(encoding="utf-8"))[0]


def main(argv: Sequence[str] | None = None) -> int:
    """Write all parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measured", action="store_true", help="what make verify and stability wrote, too")
    parser.add_argument("--pictures", action="store_true", help="the pictures of README.md, too: it takes a minute")
    made = {place: make() for place, make in PARTS.items()}
    arguments = parser.parse_args(argv)
    if arguments.measured:
        made |= {place: measured(ROOT / at) for place, at in MEASURED.items() if (ROOT / at).is_file()}
    for (file, name), part in made.items():
        path = ROOT / file
        path.write_text(with_part(path.read_text(encoding="utf-8"), name, part), encoding="utf-8")
    if arguments.pictures:
        draw_all()
    return 0


if __name__ == "__main__":
    sys.exit(main())
