"""What an earlier run left in a folder: only files of the program's own names are ever removed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from crackgrow.results.atomic import OccupiedError, OutputError, temporary_path
from crackgrow.results.checkpoint_file import remove_checkpoints, steps_with_checkpoint
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
    """Remove the files of an earlier run, half written ones too, of this case or of another.

    Raises OutputError, and OccupiedError where nothing shows that a run wrote them.
    """
    for place in (folder, *folder.parents):
        if place.exists() and not place.is_dir():
            raise OutputError(f"cannot write results into {folder}: {place} is a file; choose another folder")
    earlier = _summary(folder)
    names = [*FILES, *FIGURES, *series_names(case_name)]
    if earlier is None and not steps_with_checkpoint(folder):
        _refuse_to_replace(folder, names)
    elif earlier is not None and isinstance(earlier.get("case"), str):
        names += [name for name in series_names(earlier["case"]) if Path(name).name == name]
    _remove(folder, ["summary.json"])  # nothing is lost of a folder that is read-only
    remove_checkpoints(folder)  # before the results without which they lead nowhere
    _remove(folder, names)
    remove_half_written(folder, case_name)
    remove_frames(folder, 0)


def _summary(folder: Path) -> dict[str, Any] | None:
    """The summary of a run in a folder, empty if it is damaged; None if there is none, or one of something else."""
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except OSError:
        return None
    except ValueError:
        return {}
    return summary if isinstance(summary, dict) and "stop_reason" in summary else None


def _refuse_to_replace(folder: Path, names: Iterable[str]) -> None:
    """Raise OccupiedError where a folder has one of these files, or frames."""
    frames = [f"{sub}/{path.name}" for sub, path in _series_files(folder)]
    found = [name for name in (*names, *frames) if (folder / name).exists()]
    if found:
        others = f" and {len(found) - 1} more" if len(found) > 1 else ""
        raise OccupiedError(
            f"{folder / found[0]}{others} would be replaced, and nothing in {folder} (summary.json, checkpoint) shows "
            "that a run wrote it; choose another folder, or remove the file if it is not needed"
        )


def remove_half_written(folder: Path, case_name: str) -> None:
    """Remove temporary files that a killed run has left; raises OutputError."""
    names = (temporary_path(Path(name)) for name in (*FILES, *FIGURES, *series_names(case_name)))
    _remove(folder, [str(name) for name in names])


def remove_frames(folder: Path, first: int) -> None:
    """Remove the frames of the steps from `first` on, half written ones, and all pictures made of frames.

    Raises OutputError.
    """
    _remove(folder, [str(path.relative_to(folder)) for path in rendered_files(folder)])
    for sub, path in _series_files(folder):
        match = SERIES[sub].fullmatch(path.name)
        if match and (path.name.startswith(".") or int(match[1]) >= first):
            _remove(folder, [f"{sub}/{path.name}"])


def _series_files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Files of frames, half written ones too, with the folders that they are in."""
    for sub, pattern in SERIES.items():
        yield from ((sub, path) for path in sorted((folder / sub).glob("*")) if pattern.fullmatch(path.name))


def remove_file(path: Path) -> None:
    """Remove a file if it is there; raises OutputError."""
    _remove(path.parent, [path.name])


def _remove(folder: Path, names: Iterable[str]) -> None:
    try:
        for name in names:
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot remove earlier results in {folder}: {error.strerror or error}") from error
