"""Pictures as one animation: GIF, or MP4 where ffmpeg is there."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from crackgrow.results.atomic import OutputError, write_atomically

MILLISECONDS = 250  # that a picture is shown
LAST_MILLISECONDS = 1500  # and the last one
COLOURS = 128


def write_gif(path: Path, pictures: Sequence[Path]) -> None:
    """Write pictures, in this order, as an animation that starts over; raises OutputError."""
    images = []
    for picture in pictures:
        with Image.open(picture) as image:
            images.append(image.convert("RGB"))
    palette = images[-1].quantize(COLOURS)  # one for all: colours don't flicker
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    times = [MILLISECONDS] * (len(frames) - 1) + [LAST_MILLISECONDS]

    def write(temporary: Path) -> None:
        frames[0].save(temporary, save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=False)

    write_atomically(path, write)


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
