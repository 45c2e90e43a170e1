"""The commands that look at the results of a run: `crackgrow report`, `render`, `view` and `export`."""

from __future__ import annotations

import argparse
import math
import re

import crackgrow
from crackgrow.cli.console import EXIT_DONE, say
from crackgrow.cli.parser import Commands, add_command, path, takes_results
from crackgrow.results.units import aligned

REPORT_HELP = """\
Write report.html of a result folder: the scene, crack paths, stress intensity, loads, tractions along the faces,
energies, checks with their limits, warnings and the case, on one page that needs no network. Every run ends with one,
unless output.report is false; this makes it again, from the files of the folder alone.
"""
REPORT_EXAMPLES = """\
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


def add_report(commands: Commands) -> None:
    what = "write report.html of a result folder again"
    takes_results(add_command(commands, report, "report", what, (REPORT_HELP, REPORT_EXAMPLES)))


RENDER_HELP = """\
Draw the frames of a result folder: a field on the displaced specimen with its cracks open, a PNG for each step and an
animation, all in one colour scale. No display is needed. A report that is made afterwards shows the pictures.
"""
RENDER_EXAMPLES = """\
fields: sigma_1, sigma_3, stress_xx, stress_yy, stress_zz, stress_xy, displacement (its size), body, and energy_error if
`output.fields` of the case names it.
Pictures go to DIR/render/FIELD/step_NNNN.png and animation.gif (or .mp4), in place of earlier ones of the field.

examples:
  crackgrow render outputs/compression30
  crackgrow render outputs/compression30 --field displacement --warp 1 --steps 0 10-22 --size 800x1200
  crackgrow render outputs/compression30 --field sigma_3 --range -200 0
  crackgrow render outputs/compression30 --mp4 --out pictures
"""
VIEW_HELP = """\
Open a window on the frames of a result folder, with a slider over the steps. Without a display: exit code 3, and what
to do instead.
"""
VIEW_EXAMPLES = """\
examples:
  crackgrow view outputs/compression30
  crackgrow view outputs/compression30 --field sigma_3 --warp 20
"""
MOST_PIXELS = 8000  # of a side


def render(arguments: argparse.Namespace) -> int:
    """`crackgrow render`: pictures of the frames of a run, and an animation."""
    from crackgrow.results.field_picture import Look
    from crackgrow.results.render import find_ffmpeg, write_gif, write_mp4  # only now: they load much
    from crackgrow.results.render import render as drawn

    if arguments.animation == "mp4":
        find_ffmpeg()
    pictures = []
    look = Look(arguments.warp, arguments.size, arguments.range)
    for picture in drawn(arguments.folder, arguments.field, look, arguments.steps, arguments.out):
        pictures.append(picture)
        say(str(picture))
    if len(pictures) > 1:
        path = pictures[0].parent / f"animation.{arguments.animation}"
        write = write_mp4 if arguments.animation == "mp4" else write_gif
        write(path, pictures)
        say(str(path))
    return EXIT_DONE


def view(arguments: argparse.Namespace) -> int:
    """`crackgrow view`: a window on the frames of a run."""
    from crackgrow.results.view import view as shown  # only now: it loads pyvista

    shown(arguments.folder, arguments.field, arguments.warp)
    return EXIT_DONE


def add_render(commands: Commands) -> None:
    what = "draw the frames of a run as pictures and an animation"
    command = _takes_field(add_command(commands, render, "render", what, (RENDER_HELP, RENDER_EXAMPLES)))
    command.add_argument("--steps", type=_span, nargs="+", metavar="N|N-M", help="these steps alone (default: all)")
    limits = "limits of the colours, in the unit of the colour bar or with one: '-20 MPa' '5 MPa'"
    command.add_argument("--range", nargs=2, metavar=("LOW", "HIGH"), help=limits)
    command.add_argument("--size", type=_size, metavar="WxH", help="pixels (default: 1000 along the longer side)")
    choice = command.add_mutually_exclusive_group()
    for kind, words in (("gif", "animate as GIF (default)"), ("mp4", "animate as MP4, by ffmpeg")):
        choice.add_argument(f"--{kind}", dest="animation", action="store_const", const=kind, help=words)
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the pictures (default DIR/render)")
    command.set_defaults(animation="gif")


def add_view(commands: Commands) -> None:
    what = "open a window on the frames of a run"
    _takes_field(add_command(commands, view, "view", what, (VIEW_HELP, VIEW_EXAMPLES)))


def _takes_field(command: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """The command, with a folder of results, a field and a magnification for arguments."""
    takes_results(command)
    command.add_argument("--field", default="sigma_1", metavar="NAME", help="what colours mean (default sigma_1)")
    command.add_argument("--warp", type=_warp, metavar="auto|NUMBER",
                         help="factor of the displacements (default auto: a visible one)")  # fmt: skip
    return command


def _warp(text: str) -> float | None:
    if text == "auto":
        return None
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not math.isfinite(factor) or factor < 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: auto, or a number from 0 on is wanted")
    return factor


def _span(text: str) -> range:
    match = re.fullmatch(r"(\d+)(?:-(\d+))?", text)
    if match is None or int(match[2] or match[1]) < int(match[1]):
        raise argparse.ArgumentTypeError(f"{text!r}: a step such as 4, or a span such as 4-10 is wanted")
    return range(int(match[1]), int(match[2] or match[1]) + 1)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if not all(100 <= side <= MOST_PIXELS for side in size):
        raise argparse.ArgumentTypeError(f"{text!r}: WIDTHxHEIGHT in pixels, each from 100 to {MOST_PIXELS}, is wanted")
    return size


FORMATS = {
    "msh": "Gmsh 4.1, with bodies as physical groups and all fields",
    "inp": "Abaqus: nodes, elements (CPS3, CPS4) and sets of them by body; it has no fields",
    "vtk": "legacy VTK, with all fields",
    "xdmf": "XDMF, with all fields",
    "geojson": "the crack paths for maps, in m: lines and tips with step, length, slip, opening, K_I, K_II",
    "dxf": "the same for drawings, attributes as extended data; needs ezdxf: pip install 'crackgrow[maps]'",
}
EXPORT_HELP = """\
Write a frame of a result folder as a mesh file of another program: the cells of the specimen, with points double along
cracks and between bodies, displacement and stress at points and in cells, in m and Pa; or its crack paths as lines.
"""
EXPORT_EXAMPLES = """\
Stress is written component by component: stress_xx, stress_yy, stress_zz, stress_xy, with sigma_1 and sigma_3.

examples:
  crackgrow export outputs/compression30 --to msh
  crackgrow export outputs/compression30 --to xdmf --step 12 --out wing.xdmf
  crackgrow export outputs/compression30 --to geojson
"""


def export(arguments: argparse.Namespace) -> int:
    """`crackgrow export`: a frame as a mesh file, or crack paths."""
    say(str(crackgrow.export(arguments.folder, arguments.to, arguments.step, arguments.out)))
    return EXIT_DONE


def add_export(commands: Commands) -> None:
    formats = "\n".join(aligned(FORMATS.items(), 2, "  "))
    what = "write a frame or the crack paths of a run for another program"
    texts = EXPORT_HELP, f"formats:\n{formats}\n\n{EXPORT_EXAMPLES}"
    command = takes_results(add_command(commands, export, "export", what, texts))
    command.add_argument("--to", choices=tuple(FORMATS), required=True, help="the format")
    command.add_argument("--step", type=_step, metavar="N", help="this step (default: the last one)")
    command.add_argument("--out", type=path, metavar="FILE", help="the file (default DIR/export/step_NNNN.FORMAT)")


def _step(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r}: the number of a step is wanted, from 0 on")
    return int(text)
