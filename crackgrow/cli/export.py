"""`crackgrow export`."""

from __future__ import annotations

import argparse

import crackgrow
from crackgrow.cli.console import EXIT_DONE, say
from crackgrow.cli.parser import Commands, add_command, path
from crackgrow.results.units import aligned

FORMATS = {
    "msh": "Gmsh 4.1, with bodies as physical groups and all fields",
    "inp": "Abaqus: nodes, elements (CPS3, CPS4) and sets of them by body; it has no fields",
    "vtk": "legacy VTK, with all fields",
    "xdmf": "XDMF, with all fields",
}
HELP = """\
Write a frame of a result folder as a mesh file of another program: the cells of the specimen, with points double along
cracks and between bodies, displacement and stress at points and in cells, in m and Pa.
"""
EXAMPLES = """\
Stress is written component by component: stress_xx, stress_yy, stress_zz, stress_xy, with sigma_1 and sigma_3.

examples:
  crackgrow export outputs/compression30 --to msh
  crackgrow export outputs/compression30 --to xdmf --step 12 --out wing.xdmf
"""


def export(arguments: argparse.Namespace) -> int:
    """`crackgrow export`: a frame as a mesh file."""
    say(str(crackgrow.export(arguments.folder, arguments.to, arguments.step, arguments.out)))
    return EXIT_DONE


def add(commands: Commands) -> None:
    formats = "\n".join(aligned(FORMATS.items(), 2, "  "))
    what = "write a frame of a run as a mesh file of another program"
    command = add_command(commands, export, "export", what, (HELP, f"formats:\n{formats}\n\n{EXAMPLES}"))
    command.add_argument("folder", type=path, metavar="DIR", help="the folder that `crackgrow run` wrote")
    command.add_argument("--to", choices=tuple(FORMATS), required=True, help="the format")
    command.add_argument("--step", type=_step, metavar="N", help="the frame of this step (default: the last one)")
    command.add_argument("--out", type=path, metavar="FILE", help="the file (default DIR/export/step_NNNN.FORMAT)")


def _step(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r}: the number of a step is wanted, from 0 on")
    return int(text)
