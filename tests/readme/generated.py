"""The parts of the READMEs that are made of declarations; never written by hand.

python -m tests.readme.generated [--pictures]

A part lies between `<!-- generated: NAME -->` and `<!-- end -->`. With --pictures also the pictures of README.md.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

from crackgrow.case.accuracy import TARGETS, cells_along
from crackgrow.case.keys import Key, case_keys
from crackgrow.case.scalars import units_of
from crackgrow.case.units import UNITS
from crackgrow.cli.command_line import groups
from crackgrow.cli.reference import FOLDERS, key_entry
from tests.readme.pictures import draw_all

ROOT = Path(__file__).resolve().parents[2]
NO_DEFAULT: Final = ("may be left out", "that of its keys", "empty")
SHORTER: Final = (
    (r' or a formula in x and y such as "0.09\*x - 0.1"', " or formula"),
    (", .msh, .vtu, .vtk, .inp, .xdmf, .med, .mesh, .bdf, .nas, .su2", " or of a mesh"),
    ("`m`; `cm`; `mm`; `um`; `km`; `in`; `ft`", "a unit of length"),
    ("`Pa`; `kPa`; `MPa`; `GPa`; `psi`; `ksi`", "a unit of stress"),
    (r"^list of 2, each a (\w+ or formula), or mapping", r"[x, y] or {x, y}, each a \1"),
    (r"^(word or )?mapping, or a name from \w+,", "name, or mapping"),
    (r"^(mapping with the keys of laws.NAME): (`\w+`)", r"\2, \1"),
    (r"^list, each mapping: with", "list, each"),
    (r"^(word|mapping): (with )?", ""),
    (r"^word or ([^:]*): (.*), or ([^,]*)$", r"\2, or \1 \3"),
    (r"^word or mapping: ", ""),
    (r"^([\w, ]+): ([<>])", r"\1 \2"),
    ("whole number", "integer"),
)
"""What the page of keys says in fewer words: some of it once, at its top."""

FIRST: Final = ("new", "check", "run", "render", "compare", "explain")
"""Commands that matter first."""

FOLDED: Final = ("traction", "displacement", "columns")
"""Mappings whose keys have no rows of their own."""

BEGIN, END = "<!-- generated: {} -->", "<!-- end -->"

CELL_RULES: Final = {
    "width": "smaller side of the narrowest body",
    "tip": "length of a crack; cells at tips and changes of contact status",
    "stretch": "part of a crack behind a tip or beside a kink; cells there",
    "kink": "length of a crack; cells at its kinks",
    "end": "length of a crack; cells where it meets others",
    "room": "way from a tip to the nearest crack, interface or outline",
    "increment": "growth increment; cells at tips",
    "radius": "averaging radius of the tip stress; cells at tips",
    "feature": "width of a hole, diameter of a re-entrant corner or curve",
    "bridge": "rock between holes, outline and re-entrant corners",
    "distance": "way from a tip to a re-entrant corner or end of a support; cells there",
    "support": "supported part of an edge or interface",
    "load": "loaded part of an edge; length over which face pressure varies",
}
"""Lengths that have a number of cells to begin with."""


def commands() -> str:
    """The commands that matter first with what they do, and the names of the others."""
    helps = {name: told["what"] for of_group in groups().values() for name, told in of_group.items()}
    rows = table(("command", "what it does"), [[f"`crackgrow {name}`", helps[name]] for name in FIRST])
    others = [f"`{name}`" for name in helps if name not in FIRST]
    return f"{rows}\nAlso {', '.join(others)}.\n"


def keys() -> str:
    """The units of quantities, and every key of a case, a table for each that a case begins with."""
    units = {kind: units_of(kind) for kind in UNITS}
    units["stiffness"] = "a unit of stress over one of length, such as MPa/mm"
    parts, names = [table(("quantity", "units"), units.items())], {key.name for key in case_keys()}
    single = [found[0] for _, found in sections() if len(found) == 1]
    for name, found in (("title", single), *((name, found) for name, found in sections() if len(found) > 1)):
        rows, about = [], ""
        before = next((each for each in (f"{name}.NAME", f"{name}.N") if found[-1].name.startswith(f"{each}.")), name)
        for key in found:
            takes, meaning = takes_of(key), key.doc.replace(", [x, y]", "")
            told = key.name.removeprefix(before) if "." in key.name else key.name
            default = "-" if key.default in NO_DEFAULT else key.default
            if key.name.rpartition(".")[0].endswith(FOLDED):
                continue
            if key.name == name and takes == "mapping" and default == "-":
                about = f"{meaning}\n\n"
            elif key.name.replace(".holes.N", "") not in names - {key.name}:  # holes are shapes
                rows.append([f"`{told}`", meaning, takes, default])
        heading = " ".join(f"`{before if key.name == name else key.name}`" for key in found if "." not in key.name)
        parts.append(f"## {heading}\n\n{about}{table(('key', 'meaning', 'takes', 'default'), rows)}")
    return "\n".join(parts)


def sections() -> Iterator[tuple[str, list[Key]]]:
    """The keys by the one that they begin with; those below a mapping that has been told before are left out."""
    keys = [key for key in case_keys() if not key.again]
    starts = [place for place, key in enumerate(keys) if "." not in key.name]
    for begin, end in pairwise([*starts, len(keys)]):
        yield keys[begin].name, keys[begin:end]


def takes_of(key: Key) -> str:
    """What a key takes, in few words."""
    facts = key_entry(key).facts
    takes = ": ".join(filter(None, (facts["type"], facts.get("allowed"))))
    for pattern, words in SHORTER:
        takes = re.sub(pattern, words, takes)
    return takes


def presets() -> str:
    """How many cells a run begins with along a length, for each name, and the target that it stands for."""
    rows = [["error estimate, over the largest value", *(f"{100 * target:g} %" for target in TARGETS.values())]]
    rows += [[words, *(f"{cells_along(kind, name):g}" for name in TARGETS)] for kind, words in CELL_RULES.items()]
    return table(("cells along, to begin with", *(f"`{name}`" for name in TARGETS)), rows)


def files() -> str:
    """The files of a run."""
    return table(("file", "content"), [[f"`{file.name}`", file.doc] for file in FOLDERS["run"]])


PARTS: Final[dict[tuple[str, str], Callable[[], str]]] = {
    ("README.md", "commands"): commands,
    ("cases/ACCURACY.md", "presets"): presets,
    ("cases/KEYS.md", "keys"): keys,
    ("outputs/README.md", "files"): files,
}
"""What is made of declarations, by file and name."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in (head, *rows)]
    return "".join([lines[0], f"|{'---|' * len(head)}\n", *lines[1:]])


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


def main(argv: Sequence[str] | None = None) -> int:
    """Write all parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", action="store_true", help="the pictures of README.md, too: it takes a minute")
    made = {place: make() for place, make in PARTS.items()}
    arguments = parser.parse_args(argv)
    for (file, name), part in made.items():
        path = ROOT / file
        path.write_text(with_part(path.read_text(encoding="utf-8"), name, part), encoding="utf-8")
    if arguments.pictures:
        draw_all()
    return 0


if __name__ == "__main__":
    sys.exit(main())
