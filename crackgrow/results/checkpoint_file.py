"""checkpoint/step_NNNN.npz: what an interrupted run goes on from.

A file holds what the loop needs to make its step again (`crackgrow.run.checkpoint`), and how far the result files went
before that step. It is an npz archive of plain arrays and one text in JSON (UTF-8 in the array `header`), whose numbers
may be NaN; reading it executes nothing. Every member has a checksum. The header has

    format     number of this format
    program    version and git commit of the program that wrote it
    case       name of the case and its resolved YAML
    step       number of the step
    run        values of the loop; its arrays are the other members of the archive
    results    see `RunWriter`
"""

from __future__ import annotations

import json
import re
import time
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.npyio import NpzFile
from numpy.typing import NDArray

from crackgrow import __version__
from crackgrow.results.atomic import OutputError, remove_files, write_atomically
from crackgrow.run.result import Checkpoint

FORMAT = 10
FLUSHED_EVERY = 1.0  # s: so often a checkpoint is flushed to the disk, which can take longer than a small step
NAME = re.compile(r"step_(\d{4,})\.npz")
HALF_WRITTEN = re.compile(r"\.step_\d{4,}\.tmp\.npz")


class DamagedError(ValueError):
    """A checkpoint that can't be read; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredCheckpoint:
    """A checkpoint as a file holds it."""

    checkpoint: Checkpoint
    version: str
    commit: str | None
    case_name: str
    settings: str  # the resolved case as YAML
    results: Mapping[str, Any]  # how far the result files went


class CheckpointWriter:
    """Writes the checkpoints of one run, and removes old ones.

    A killed program leaves each of them whole; a loss of power too leaves those that were flushed to the disk.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._flushed = -1  # the step of the last one that was
        self._when = -FLUSHED_EVERY  # s

    def write(self, stored: StoredCheckpoint) -> None:
        """Write a checkpoint; then remove all but this one, the one before and the last that was flushed.

        Raises OutputError.
        """
        step, now = stored.checkpoint.step, time.monotonic()
        flush = now - self._when >= FLUSHED_EVERY
        arrays: dict[str, Any] = {"header": _header(stored), **stored.checkpoint.arrays}

        def write(temporary: Path) -> None:
            with temporary.open("wb") as file:
                np.savez(file, **arrays)

        write_atomically(_folder(self._folder) / f"step_{step:04d}.npz", write, durable=flush)
        if flush:
            self._flushed, self._when = step, now
        before = [older for older in steps_with_checkpoint(self._folder) if older < step][:1]
        remove_checkpoints(self._folder, {step, *before, self._flushed})


def _header(stored: StoredCheckpoint) -> NDArray[np.uint8]:
    """All that is no array, as JSON."""
    header = {
        "format": FORMAT,
        "program": {"version": stored.version, "commit": stored.commit},
        "case": {"name": stored.case_name, "settings": stored.settings},
        "step": stored.checkpoint.step,
        "run": dict(stored.checkpoint.values),
        "results": dict(stored.results),
    }
    return np.frombuffer(json.dumps(header, ensure_ascii=False).encode(), dtype=np.uint8)


def steps_with_checkpoint(folder: Path) -> list[int]:
    """The steps whose checkpoints are in the run's folder, the newest first."""
    found = (NAME.fullmatch(path.name) for path in _folder(folder).glob("*.npz"))
    return sorted((int(match[1]) for match in found if match), reverse=True)


def checkpoint_files(folder: Path) -> list[Path]:
    """The files of checkpoints in the run's folder, half written ones too."""
    files = sorted(_folder(folder).glob("*.npz"))
    return [path for path in files if NAME.fullmatch(path.name) or HALF_WRITTEN.fullmatch(path.name)]


def is_checkpoint(path: Path) -> bool:
    """Whether a file is a checkpoint of this program, of whatever version."""
    try:
        with path.open("rb") as file, NpzFile(file, allow_pickle=False) as archive:
            header = json.loads(archive["header"].tobytes())
    except (OSError, zipfile.BadZipFile, ValueError, KeyError, EOFError, RecursionError):
        return False
    return isinstance(header, dict) and {"format", "program", "case", "step", "run", "results"} <= header.keys()


def read_checkpoint(folder: Path, step: int) -> StoredCheckpoint:
    """The checkpoint of a step. Raises DamagedError, and OutputError where the system refuses."""
    path = _folder(folder) / f"step_{step:04d}.npz"
    try:
        with path.open("rb") as file, NpzFile(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(arrays.pop("header").tobytes())
        if header["format"] != FORMAT:
            raise DamagedError(
                f"{path} has format {header['format']}, this is crackgrow {__version__}: wanted {FORMAT}"
            )
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error
    except DamagedError:
        raise
    except (zipfile.BadZipFile, ValueError, KeyError, EOFError) as error:
        raise DamagedError(f"{path} is damaged: {error}") from error
    program, case = header["program"], header["case"]
    return StoredCheckpoint(
        Checkpoint(header["step"], header["run"], arrays),
        program["version"],
        program["commit"],
        case["name"],
        case["settings"],
        header["results"],
    )


def remove_checkpoints(folder: Path, keep: set[int] | frozenset[int] = frozenset()) -> None:
    """Remove the checkpoints in the run's folder but those of the steps `keep`; raises OutputError."""
    kept = {f"step_{step:04d}.npz" for step in keep}
    remove_files(path for path in checkpoint_files(folder) if path.name not in kept)


def _folder(folder: Path) -> Path:
    return folder / "checkpoint"
