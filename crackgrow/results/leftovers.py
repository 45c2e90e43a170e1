"""What an earlier run left in a folder: only files of the program's own names are ever removed."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from crackgrow.results.atomic import OutputError, temporary_path
from crackgrow.results.checkpoint_file import remove_checkpoints
from crackgrow.results.rendered import rendered_files

REPORT = "report.html"
FILES = ("case.yaml", "summary.json", "tips.csv", "paths.csv", "contact.csv", "reactions.csv", "steps.csv",
         "events.csv", "run.log", REPORT)  # fmt: skip
FIGURES = ("figures/path.png", "figures/sigma_1_first.png", "figures/sigma_1_last.png", "figures/contact.png",
           "figures/load_curve.png")  # fmt: skip
SERIES = {
    "frames": re.compile(r"\.?step_(\d{4,})(?:\.tmp)?\.vtu"),
    "cracks": re.compile(r"\.?step_(\d{4,})(?:\.tmp)?\.vtp"),
}


def frame_name(step: int) -> str:
    """Path of a step's frame, relative to the run's folder."""
    return f"frames/step_{step:04d}.vtu"


def cracks_name(step: int) -> str:
    """Path of a step's crack faces, relative to the run's folder."""
    return f"cracks/step_{step:04d}.vtp"


def series_names(case_name: str) -> tuple[str, str]:
    """Paths of the two time series, of the specimen and of its cracks."""
    return f"{case_name}.pvd", f"{case_name}_cracks.pvd"


def remove_leftovers(folder: Path, case_name: str) -> None:
    """Remove the files of an earlier run of this case, half written ones too; raises OutputError."""
    _remove(folder, ["summary.json"])  # nothing is lost of a folder that is read-only
    remove_checkpoints(folder)  # before the results without which they lead nowhere
    _remove(folder, (*FILES, *FIGURES, *series_names(case_name)))
    remove_half_written(folder, case_name)
    remove_frames(folder, 0)


def remove_half_written(folder: Path, case_name: str) -> None:
    """Remove temporary files that a killed run has left; raises OutputError."""
    names = (temporary_path(Path(name)) for name in (*FILES, *FIGURES, *series_names(case_name)))
    _remove(folder, [str(name) for name in names])


def remove_frames(folder: Path, first: int) -> None:
    """Remove the frames of the steps from `first` on, half written ones, and all pictures made of frames.

    Raises OutputError.
    """
    _remove(folder, [str(path.relative_to(folder)) for path in rendered_files(folder)])
    for sub, pattern in SERIES.items():
        for path in sorted((folder / sub).glob("*")):
            match = pattern.fullmatch(path.name)
            if match and (path.name.startswith(".") or int(match[1]) >= first):
                _remove(folder, [f"{sub}/{path.name}"])


def remove_file(path: Path) -> None:
    """Remove a file if it is there; raises OutputError."""
    _remove(path.parent, [path.name])


def _remove(folder: Path, names: Iterable[str]) -> None:
    try:
        for name in names:
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot remove earlier results in {folder}: {error.strerror or error}") from error
