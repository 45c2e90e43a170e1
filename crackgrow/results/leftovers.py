"""What an earlier run left in a folder: only files of the program's own names are ever removed.

And only where something that no stranger has shows that a run wrote them: a summary.json with the program's own keys;
where there is none, or an empty one as after a loss of power, a checkpoint or a log of the program.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from crackgrow.results.atomic import OccupiedError, OutputError, remove_files, temporary_path
from crackgrow.results.checkpoint_file import checkpoint_files, is_checkpoint
from crackgrow.results.folder import FIGURES, FILES, LOG, SERIES, SUMMARY, RunFolder, series_names
from crackgrow.results.lock import check_place, existing_part, is_too_long
from crackgrow.results.log import is_log
from crackgrow.results.rendered import rendered_files

OWN_KEYS = (
    "case",
    "status",
    "stop_reason",
    "steps_done",
    "n_solves",
    "version",
    "git_commit",
    "wall_seconds",
    "peak_memory_mb",
    "worst_checks",
)  # of a summary, all of them in that of every version


def check_folder(folder: Path, case_name: str) -> None:
    """Make sure that a run may write into a folder, which need not be there; changes nothing.

    Raises OutputError where the system can't have such files, OccupiedError as `check_place` and `earlier_files`.
    """
    check_place(folder)
    for name in map(Path, series_names(case_name)):
        if is_too_long(existing_part(folder) / temporary_path(name)) or is_too_long(folder / temporary_path(name)):
            raise OutputError(f"cannot write {folder / name}: the name is too long; rename the case")
    earlier_files(folder, case_name)


def earlier_files(folder: Path, case_name: str) -> list[Path]:
    """The files in a folder that a run would remove or replace, half written ones too, of this case or of another.

    Checkpoints come before the results without which they lead nowhere, the summary, which shows whose the files are,
    comes last. Raises OccupiedError where nothing shows that a run wrote them.
    """
    summary = RunFolder(folder).found_summary
    is_own = all(key in summary for key in OWN_KEYS)
    cases = {case_name, str(summary["case"]) if is_own else case_name}
    series = [name for case in cases for name in series_names(case) if Path(name).name == name]
    named = [folder / name for name in (*FILES, *FIGURES, *series) if name != SUMMARY]
    pieces = [path for _, path in _series_files(folder)]
    files = [*checkpoint_files(folder), *named, *map(temporary_path, [*named, folder / SUMMARY])]
    files += [*pieces, *rendered_files(folder), folder / SUMMARY]
    found = [path for path in files if path.is_symlink() or path.exists()]
    if found and not is_own and not _is_own_without_summary(folder):
        first = found[-1] if found[-1].name == SUMMARY else found[0]
        others = f" and {len(found) - 1} more" if len(found) > 1 else ""
        raise OccupiedError(
            f"{first}{others} would be replaced, and nothing in {folder} (summary.json, checkpoint, run.log) shows "
            "that a run wrote it; choose another folder, or remove the file if it is not needed"
        )
    return found


def _is_own_without_summary(folder: Path) -> bool:
    """Whether a checkpoint or the log is of the program, and no summary of something else is in the way."""
    path = folder / SUMMARY
    if path.is_symlink() or (path.exists() and (not path.is_file() or path.stat().st_size > 0)):
        return False
    return is_log(folder / LOG) or any(map(is_checkpoint, checkpoint_files(folder)))


def remove_half_written(folder: Path, case_name: str) -> None:
    """Remove temporary files that a killed run has left; raises OutputError."""
    remove_files(temporary_path(folder / name) for name in (*FILES, *FIGURES, *series_names(case_name)))


def remove_frames(folder: Path, first: int) -> None:
    """Remove the frames of the steps from `first` on, half written ones, and all pictures made of frames.

    Raises OutputError.
    """
    remove_files(rendered_files(folder))
    for sub, path in list(_series_files(folder)):
        match = SERIES[sub].fullmatch(path.name)
        if match and (path.name.startswith(".") or int(match[1]) >= first):
            remove_files([path])


def _series_files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Files of frames, half written ones too, with the folders that they are in."""
    for sub, pattern in SERIES.items():
        yield from ((sub, path) for path in sorted((folder / sub).glob("*")) if pattern.fullmatch(path.name))
