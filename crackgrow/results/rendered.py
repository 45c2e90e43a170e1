"""Names of the pictures that `crackgrow render` makes, and which of them are there."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from crackgrow.results.atomic import remove_files

FOLDER = "render"  # in that of the run
FIRST_FIELD = "sigma_1"  # of which a report has pictures rather than of others
ANIMATIONS = {"gif": "animation.gif", "mp4": "animation.mp4"}
PICTURE = re.compile(r"step_(\d{4,})\.png")


def picture_name(field: str, step: int) -> str:
    """Path of a step's picture, relative to the folder of the pictures."""
    return f"{field}/step_{step:04d}.png"


def rendered(folder: Path) -> dict[str, dict[int, Path]]:
    """Pictures in a run's folder by field and step, FIRST_FIELD first."""
    found: dict[str, dict[int, Path]] = {}
    for path in sorted(rendered_files(folder), key=lambda path: (path.parent.name != FIRST_FIELD, path)):
        match = PICTURE.fullmatch(path.name)
        if match:
            found.setdefault(path.parent.name, {})[int(match[1])] = path
    return found


def remove_rendered(pictures: Path) -> None:
    """Remove the pictures and animations of one field from their folder; raises OutputError."""
    remove_files(_own_files(pictures))


def rendered_files(folder: Path) -> Iterator[Path]:
    """Pictures, and animations, that were made of the run in a folder."""
    for field in sorted((folder / FOLDER).glob("*/")):
        yield from _own_files(field)


def _own_files(pictures: Path) -> Iterator[Path]:
    yield from (path for path in sorted(pictures.glob("step_*.png")) if PICTURE.fullmatch(path.name))
    yield from (path for name in ANIMATIONS.values() if (path := pictures / name).is_file())
