"""Pictures of a run's frames: a field on the displaced specimen, its cracks open, in one scale for all steps.

They are drawn by matplotlib: no display, no graphics driver is needed. All of them make an animation: GIF, or MP4 where
ffmpeg is there.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from crackgrow.results.atomic import OutputError, remove_files, write_atomically, write_bytes
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.field_picture import USUAL, FieldPictures, Look
from crackgrow.results.folder import open_run, own_files
from crackgrow.results.log import load_words

MILLISECONDS = 250  # that a picture is shown
LAST_MILLISECONDS = 1500  # and the last one
COLOURS = 128


def render(
    folder: Path,
    field: str = "sigma_1",
    look: Look = USUAL,
    steps: Sequence[int | range] | None = None,
    out: Path | None = None,
) -> Iterator[Path]:
    """Draw a field of the frames of the run in `folder`, and yield each picture as it is done.

    field: displacement (its size), sigma_1, sigma_3, stress_xx, ..., or one of the cells: body, energy_error
    look: factor of displacements, size and limits of colours, the same for all steps
    steps: those to draw, or ranges of them; None: all that have frames
    out: folder of the pictures, `render` in that of the run if it is None; earlier pictures of the field go

    Raises FolderError where there is nothing to draw, CaseError for limits that the field cannot have, OutputError.
    """
    run = open_run(folder)
    frames = [drawn_frame(run, step, field) for step in run.frames_of(steps)]
    factors = zip(run.solved, run.table("steps")["load_factor"].tolist(), strict=True)
    loads = {step: load_words(run.case, factor) for step, factor in factors}
    pictures = FieldPictures(run.case.title, field, frames, loads, look)
    target = (folder / "render" if out is None else out) / field
    remove_files(own.path for own in own_files(target, names=["step_NNNN.png", "animation.gif", "animation.mp4"]))
    for frame in frames:
        path = target / f"step_{frame.step:04d}.png"
        write_bytes(path, pictures.png(frame))
        yield path


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
