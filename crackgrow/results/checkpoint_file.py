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
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from crackgrow import __version__
from crackgrow.results.atomic import OutputError, write_atomically
from crackgrow.run.result import Checkpoint

FORMAT = 1
KEPT = 2  # the newest ones: the last but one is kept until the next is whole, and longer
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


def write_checkpoint(folder: Path, stored: StoredCheckpoint) -> None:
    """Write the checkpoint to the run's folder, onto the disk itself; then remove all but the newest ones before it.

    Raises OutputError.
    """
    checkpoint = stored.checkpoint
    header = {
        "format": FORMAT,
        "program": {"version": stored.version, "commit": stored.commit},
        "case": {"name": stored.case_name, "settings": stored.settings},
        "step": checkpoint.step,
        "run": dict(checkpoint.values),
        "results": dict(stored.results),
    }
    text = np.frombuffer(json.dumps(header, ensure_ascii=False).encode(), dtype=np.uint8)
    arrays: dict[str, Any] = {"header": text, **checkpoint.arrays}
    path = _folder(folder) / f"step_{checkpoint.step:04d}.npz"

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez(file, **arrays)

    write_atomically(path, write, durable=True)
    older = [step for step in steps_with_checkpoint(folder) if step < checkpoint.step]
    remove_checkpoints(folder, {checkpoint.step, *older[: KEPT - 1]})


def steps_with_checkpoint(folder: Path) -> list[int]:
    """The steps whose checkpoints are in the run's folder, the newest first."""
    found = (NAME.fullmatch(path.name) for path in _folder(folder).glob("*.npz"))
    return sorted((int(match[1]) for match in found if match), reverse=True)


def read_checkpoint(folder: Path, step: int) -> StoredCheckpoint:
    """The checkpoint of a step. Raises DamagedError, and OutputError where the system refuses."""
    path = _folder(folder) / f"step_{step:04d}.npz"
    try:
        with np.load(path, allow_pickle=False) as archive:
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
    for path in sorted(_folder(folder).glob("*")):
        match = NAME.fullmatch(path.name)
        if HALF_WRITTEN.fullmatch(path.name) or (match and int(match[1]) not in keep):
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                raise OutputError(f"cannot remove {path}: {error.strerror or error}") from error


def _folder(folder: Path) -> Path:
    return folder / "checkpoint"
