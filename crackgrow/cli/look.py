"""`crackgrow render`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from crackgrow.cli.console import say


def do_render(
    folder: Path,
    field: str,
    warp: float | None,
    size: tuple[int, int] | None,
    limits: tuple[str, str] | None,
    steps: Sequence[range] | None,
    animation: str,
    out: Path | None,
) -> None:
    """`crackgrow render`: pictures of the frames of a run, and an animation."""
    from crackgrow.results.field_picture import Look
    from crackgrow.results.render import find_ffmpeg, render, write_gif, write_mp4  # only now: they load much

    if animation == "mp4":
        find_ffmpeg()
    pictures = []
    for picture in render(folder, field, Look(warp, size, limits), steps, out):
        pictures.append(picture)
        say(str(picture))
    if len(pictures) > 1:
        path = pictures[0].parent / f"animation.{animation}"
        write = write_mp4 if animation == "mp4" else write_gif
        write(path, pictures)
        say(str(path))
