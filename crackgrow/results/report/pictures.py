"""Pictures of steps, as data in the page: those of `crackgrow render`, or else the run's figures."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

from crackgrow.results.folder import FolderError, RunFolder
from crackgrow.results.rendered import rendered

MOST_PICTURES = 40  # of a rendered series
MOST_PIXELS = 720  # of the longer side of those
MOST_PIXELS_OF_FIGURES = 1400
QUALITY = 80  # of JPEG
MOST_BYTES = 1_500_000  # of all pictures of the page


def pictures(run: RunFolder) -> list[dict[str, Any]]:
    """Step, caption and data of each picture, in the order of the steps; those of a series at most MOST_BYTES.

    Raises FolderError for one that is damaged.
    """
    series = rendered(run.folder)
    for field in series:
        return _thinned(field, series[field], run)
    found = []
    for name, step in (("sigma_1_first", run.solved[:1]), ("sigma_1_last", run.solved[-1:])):
        path = run.folder / "figures" / f"{name}.png"
        if path.is_file() and step:
            found.append(_picture(step[0], "major principal stress", path, MOST_PIXELS_OF_FIGURES))
    return found


def _thinned(field: str, files: dict[int, Path], run: RunFolder) -> list[dict[str, Any]]:
    """Evenly spaced pictures of a series, the last one among them, made small."""
    steps = sorted(step for step in files if step in run.solved)[::-1]
    chosen = steps[:: -(-len(steps) // MOST_PICTURES)] if steps else []
    found = [_picture(step, field, files[step], MOST_PIXELS) for step in chosen]
    size = sum(len(picture["uri"]) for picture in found)
    return found[:: -(-size // MOST_BYTES)][::-1] if found else []


def _picture(step: int, words: str, path: Path, most_pixels: int) -> dict[str, Any]:
    """A picture as JPEG: of smooth colours PNG takes several times as much."""
    from PIL import Image  # here: reports without pictures do not need it

    try:
        with Image.open(path) as image:
            small = image.convert("RGB")
    except OSError as error:
        raise FolderError(f"{path} is damaged: {error}") from error
    small.thumbnail((most_pixels, most_pixels))
    data = io.BytesIO()
    small.save(data, format="JPEG", quality=QUALITY, optimize=True)
    uri = f"data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}"
    return {"step": step, "words": words, "uri": uri}
