"""Pictures of a run's frames: a field on the displaced specimen, its cracks open, in one scale for all steps.

They are drawn by matplotlib: no display, no graphics driver is needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from crackgrow.results.atomic import write_bytes
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.field_picture import USUAL, FieldPictures, Look
from crackgrow.results.folder import open_run
from crackgrow.results.rendered import FOLDER, picture_name, remove_rendered


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
    factors = dict(zip(run.solved, run.table("steps").numbers("load_factor").tolist(), strict=True))
    pictures = FieldPictures(run.case.title, field, frames, factors, look)
    target = folder / FOLDER if out is None else out
    remove_rendered(target / field)
    for frame in frames:
        path = target / picture_name(field, frame.step)
        write_bytes(path, pictures.png(frame))
        yield path
