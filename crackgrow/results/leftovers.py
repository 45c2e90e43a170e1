"""What an earlier run left in a folder: only files of the program's own names are ever removed."""

from __future__ import annotations

import re
from pathlib import Path

from crackgrow.results.atomic import OutputError, temporary_path

FILES = ("case.yaml", "summary.json", "tips.csv", "paths.csv", "contact.csv", "reactions.csv", "steps.csv",
         "events.csv", "run.log")  # fmt: skip
FIGURES = ("figures/path.png", "figures/sigma_1_first.png", "figures/sigma_1_last.png", "figures/contact.png",
           "figures/load_curve.png")  # fmt: skip
SERIES = {"frames": re.compile(r"\.?step_\d{4,}(\.tmp)?\.vtu"), "cracks": re.compile(r"\.?step_\d{4,}(\.tmp)?\.vtp")}


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
    try:
        for name in (*FILES, *FIGURES, *series_names(case_name)):
            (folder / name).unlink(missing_ok=True)
            temporary_path(folder / name).unlink(missing_ok=True)
        for sub, pattern in SERIES.items():
            for path in sorted((folder / sub).glob("*")):
                if pattern.fullmatch(path.name):
                    path.unlink()
    except OSError as error:
        raise OutputError(f"cannot remove earlier results in {folder}: {error.strerror or error}") from error
