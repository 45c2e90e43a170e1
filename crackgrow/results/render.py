"""The frames of a run to look at: pictures of a field on the displaced specimen, an animation of them, a window.

Pictures are drawn by matplotlib: no display, no graphics driver is needed. They make a GIF, or an MP4 where ffmpeg is
there.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import OutputError, remove_files, write_atomically, write_bytes
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.field_picture import FieldPictures
from crackgrow.results.folder import open_run, own_files
from crackgrow.results.log import load_words
from crackgrow.results.units import factor_text

if TYPE_CHECKING:
    import pyvista

MILLISECONDS = 250  # that a picture is shown
LAST_MILLISECONDS = 1500  # and the last one
COLOURS = 128


class NoDisplayError(CrackgrowError):
    """There is no display to open a window on; the message says what to do instead."""

    exit_code = 3


def render(
    folder: Path,
    field: str = "sigma_1",
    warp: float | None = None,
    size: tuple[int, int] | None = None,
    limits: tuple[str, str] | None = None,
    steps: Sequence[int | range] | None = None,
    animation: str = "",
    out: Path | None = None,
) -> Iterator[Path]:
    """Draw a field of the frames of the run in `folder`, and yield each picture as it is done, then the animation.

    field: displacement (its size), sigma_1, sigma_3, stress_xx, ..., or one of the cells: body, energy_error
    warp, size, limits: as of `FieldPictures`, the same for all steps
    steps: those to draw, or ranges of them; None: all that have frames
    animation: of several pictures, "gif" or "mp4"; empty: none
    out: folder of the pictures, `render` in that of the run if it is None; earlier pictures of the field go

    Raises FolderError where there is nothing to draw, CaseError for limits that the field cannot have, OutputError.
    """
    if animation == "mp4":
        find_ffmpeg()
    run = open_run(folder)
    frames = [drawn_frame(run, step, field) for step in run.frames_of(steps)]
    factors = zip(run.solved, run.table("steps")["load_factor"].tolist(), strict=True)
    loads = {step: load_words(run.case, factor) for step, factor in factors}
    pictures = FieldPictures(run.case.title, field, frames, loads, warp, size, limits)
    target = (folder / "render" if out is None else out) / field
    remove_files(own.path for own in own_files(target, names=["step_NNNN.png", "animation.gif", "animation.mp4"]))
    paths = [target / f"step_{frame.step:04d}.png" for frame in frames]
    for path, frame in zip(paths, frames, strict=True):
        write_bytes(path, pictures.png(frame))
        yield path
    if animation and len(paths) > 1:
        write = write_mp4 if animation == "mp4" else write_gif
        write(target / f"animation.{animation}", paths)
        yield target / f"animation.{animation}"


def write_gif(path: Path, pictures: Sequence[Path]) -> None:
    """Write pictures, in this order, as an animation that starts over; raises OutputError."""
    images = []
    for picture in pictures:
        with Image.open(picture) as image:
            images.append(image.convert("RGB"))
    palette = images[-1].quantize(COLOURS)  # one for all: colours don't flicker
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    times = [MILLISECONDS] * (len(frames) - 1) + [LAST_MILLISECONDS]
    how: dict[str, Any] = {"save_all": True, "append_images": frames[1:], "duration": times, "loop": 0}
    write_atomically(path, lambda temporary: frames[0].save(temporary, optimize=False, **how))


def write_mp4(path: Path, pictures: Sequence[Path]) -> None:
    """Write pictures, in this order, as a film by ffmpeg; raises OutputError, also where there is no ffmpeg."""
    program = find_ffmpeg()
    rate = f"{1000 / MILLISECONDS:g}"
    even = "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"  # what the format asks for
    command = [program, "-y", "-loglevel", "error", "-f", "image2pipe", "-framerate", rate, "-c:v", "png", "-i", "-",
               "-vf", even, "-pix_fmt", "yuv420p", "-movflags", "+faststart"]  # fmt: skip
    frames = b"".join(picture.read_bytes() for picture in pictures)

    def write(temporary: Path) -> None:
        done = subprocess.run([*command, str(temporary)], input=frames, capture_output=True, check=False)
        if done.returncode != 0:
            raise OutputError(f"cannot write {path}: ffmpeg: {done.stderr.decode(errors='replace').strip()}")

    write_atomically(path, write)


def find_ffmpeg() -> str:
    """Where ffmpeg is; raises OutputError where it is not."""
    program = shutil.which("ffmpeg")
    if program is None:
        raise OutputError("an MP4 needs ffmpeg, which is not found: install it, or leave out --mp4 for a GIF")
    return program


def view(folder: Path, field: str = "sigma_1", warp: float | None = None) -> None:
    """Open a window with a slider over the steps, and return when it is closed.

    Raises FolderError where there is nothing to see, NoDisplayError.
    """
    unix = sys.platform not in ("win32", "darwin")
    if unix and not os.environ.get("DISPLAY") and not os.environ.get("WAYLAND_DISPLAY"):
        raise NoDisplayError(
            f"there is no display to open a window on: `crackgrow render {folder}` draws pictures without one; or open "
            f"the .pvd in {folder} in ParaView where there is one, or log in by `ssh -X`"
        )
    import pyvista  # here: pictures need none of its window

    plotter = pyvista.Plotter(title=f"crackgrow: {folder}")
    fill(plotter, folder, field, warp)
    plotter.show()


def fill(plotter: pyvista.Plotter, folder: Path, field: str, warp: float | None) -> None:
    """Put the last frame into a plotter, with a slider that changes it; raises FolderError."""
    run = open_run(folder)
    steps = run.frames_of()
    pictures = FieldPictures(run.case.title, field, [drawn_frame(run, steps[-1], field)], {}, warp)
    factor, (size, unit), norm = pictures.warp, pictures.unit, pictures.norm
    label = f"{field} [{unit}]" if unit else field
    looks: dict[str, Any] = {"cmap": pictures.colormap, "clim": (norm.vmin, norm.vmax)}
    looks |= {"show_scalar_bar": False, "lighting": False}
    untyped: Any = plotter  # the declared types of some methods are not those of what they wrap

    def show(value: float) -> Any:
        step = min(steps, key=lambda other: abs(other - value))
        mesh = run.mesh(step)
        frame = drawn_frame(run, step, field, mesh)
        grid = mesh.warp_by_vector("displacement", factor=factor)
        (grid.point_data if frame.by_point else grid.cell_data)[label] = frame.values / size
        specimen = plotter.add_mesh(grid, name="specimen", scalars=label, **looks)
        edges = grid.extract_feature_edges(feature_edges=False, manifold_edges=False, non_manifold_edges=False)
        plotter.add_mesh(edges, name="edges", color="black", line_width=1)
        plotter.add_text(f"step {step}, displacement x {factor_text(factor)}", name="caption", font_size=10)
        return specimen

    colours = show(steps[-1]).mapper  # else the bar is that of the edges
    untyped.add_scalar_bar(label, mapper=colours, vertical=True, position_x=0.88, position_y=0.2, height=0.6)
    if len(steps) > 1:
        place = {"pointa": (0.03, 0.08), "pointb": (0.28, 0.08)}
        untyped.add_slider_widget(show, (steps[0], steps[-1]), value=steps[-1], title="step", fmt="%.0f", **place)
    plotter.camera_position = "xy"
