"""`crackgrow render` and `crackgrow view`."""

from __future__ import annotations

import argparse
import math
import re

from crackgrow.cli.console import EXIT_DONE, say
from crackgrow.cli.parser import Commands, add_command, path

RENDER_HELP = """\
Draw the frames of a result folder: a field on the displaced specimen with its cracks open, a PNG for each step and an
animation, all in one colour scale. No display is needed. A report that is made afterwards shows the pictures.
"""
RENDER_EXAMPLES = """\
fields: sigma_1, sigma_3, stress_xx, stress_yy, stress_zz, stress_xy, displacement (its size), energy_error, body.
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


def add(commands: Commands) -> None:
    what = "draw the frames of a run as pictures and an animation"
    command = add_command(commands, render, "render", what, (RENDER_HELP, RENDER_EXAMPLES))
    window = add_command(commands, view, "view", "open a window on the frames of a run", (VIEW_HELP, VIEW_EXAMPLES))
    for each in (command, window):
        each.add_argument("folder", type=path, metavar="DIR", help="the folder that `crackgrow run` wrote")
        each.add_argument("--field", default="sigma_1", metavar="NAME", help="what colours mean (default sigma_1)")
        each.add_argument("--warp", type=_warp, metavar="auto|NUMBER",
                          help="factor of the displacements (default auto: a visible one)")  # fmt: skip
    command.add_argument("--steps", type=_span, nargs="+", metavar="N|N-M", help="these steps alone (default: all)")
    limits = "limits of the colours, in the unit of the colour bar or with one: '-20 MPa' '5 MPa'"
    command.add_argument("--range", nargs=2, metavar=("LOW", "HIGH"), help=limits)
    command.add_argument("--size", type=_size, metavar="WxH", help="pixels (default: 1000 along the longer side)")
    choice = command.add_mutually_exclusive_group()
    for kind, words in (("gif", "animate as GIF (default)"), ("mp4", "animate as MP4, by ffmpeg")):
        choice.add_argument(f"--{kind}", dest="animation", action="store_const", const=kind, help=words)
    command.add_argument("--out", type=path, metavar="DIR", help="folder of the pictures (default DIR/render)")
    command.set_defaults(animation="gif")


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
