"""The parts of the READMEs that are made of declarations; never written by hand.

python -m tests.readme.generated [--pictures]

A part lies between `<!-- generated: NAME -->` and `<!-- end -->`. With --pictures also the pictures of README.md.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
import pyvista

from crackgrow.api import run_case
from crackgrow.case import load_case
from crackgrow.case.accuracy import TARGETS, cells_along
from crackgrow.case.keys import Key, case_keys, units_of
from crackgrow.case.units import UNITS
from crackgrow.cli.command_line import groups
from crackgrow.cli.reference import FOLDERS, key_entry
from crackgrow.cli.start import template_text
from crackgrow.results.render import render
from tests.scenes import shipped_case

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


PICTURES = ROOT / ".readme"
TUTORIAL: Final = re.compile(r"\*Scale Factor\* of (\S+),.*?rescale its range to (\S+) to (\S+) Pa", re.DOTALL)
"""What the tutorial says of its picture: factor of the displacements, limits of the colours."""

SIZE: Final = (800, 800)
BACKGROUND: Final = "#525870"  # ParaView's


def draw_all() -> None:
    """Run the cases in a folder that goes again, and draw the pictures."""
    with tempfile.TemporaryDirectory() as folder:
        runs = Path(folder)
        run_case(shipped_case("compression30"), runs / "compression30")
        *_, last = render(runs / "compression30")
        shutil.copy(last, PICTURES / "compression30.png")
        (runs / "my_rock.yaml").write_text(template_text("compression"), encoding="utf-8")
        run_case(load_case(runs / "my_rock.yaml"), runs / "my_rock")
        run_case(shipped_case("joint_map"), runs / "joint_map")
        shutil.copy(runs / "joint_map" / "figures" / "path.png", PICTURES / "joint_map.png")
        draw_laws(PICTURES / "joint_laws.png")
        draw_series(runs / "my_rock" / "my_rock.pvd", PICTURES / "paraview.png")


LAWS = (
    # scene, settings, displacement at factor 1 (mm), column of its force (N/m), width of the specimen (m)
    ("vein_in_tension", [], 0.04, "supports.1.force_y", 0.05),
    ("rough_joint_sheared", ["loading.follow=events"], 6.0, "supports.1.force_x", 0.4),
    ("barton_bandis", ["loading.follow=events"], 2.0, "supports.1.force_x", 0.4),
)


def draw_laws(picture: Path) -> None:
    """Draw the stress that joints of three laws carry over the displacement that their scenes give them."""
    figure, axes = plt.subplots(1, len(LAWS), figsize=(10.0, 3.0), layout="constrained")
    for plot, (scene, settings, most, column, width) in zip(axes, LAWS, strict=True):
        run = run_case(shipped_case(scene, settings))
        told = [result.history for result in run.results if result.history is not None]
        factor = np.concatenate([[0.0], *(each.load_factor for each in told)])
        force = np.concatenate([[0.0], *(each.values[:, each.columns.index(column)] for each in told)])
        plot.plot(most * factor, force / width / 1e6)
        plot.set(xlabel="given displacement [mm]", ylabel="stress [MPa]", title=f"{scene}.yaml")
        plot.grid(alpha=0.3)
    figure.savefig(picture, dpi=100)


def tutorial_settings() -> tuple[float, float, float]:
    """Factor of the displacements and limits of the colours (Pa) in the tutorial; raises ValueError without them."""
    found = TUTORIAL.search((ROOT / "README.md").read_text(encoding="utf-8"))
    if found is None:
        raise ValueError(f"README.md says nowhere: {TUTORIAL.pattern}")
    factor, low, high = map(float, found.groups())
    return factor, low, high


def draw_series(series: Path, picture: Path) -> None:
    """Draw the last frame of a .pvd file with `sigma_1` of its points, displaced, as the tutorial says."""
    factor, low, high = tutorial_settings()
    reader = pyvista.PVDReader(str(series))
    reader.set_active_time_value(reader.time_values[-1])
    (grid,) = reader.read()
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.set_background(BACKGROUND)
    bar = {"title": "sigma_1", "vertical": True, "position_x": 0.82, "position_y": 0.3, "height": 0.4, "color": "w"}
    warped = grid.warp_by_vector("displacement", factor=factor)
    looks = {"cmap": "coolwarm", "clim": (low, high), "lighting": False, "scalar_bar_args": bar}
    plotter.add_mesh(warped, scalars="sigma_1", preference="point", **looks)
    plotter.enable_parallel_projection()
    plotter.view_xy()
    plotter.screenshot(picture)
    plotter.close()


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
