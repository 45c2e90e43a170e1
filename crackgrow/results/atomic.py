"""Files that are never left half written: a temporary name beside them, then a rename; or one write at the end."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final

from crackgrow.errors import CrackgrowError

FULL: Final = (errno.ENOSPC, errno.EDQUOT)  # there is no room, on the disk or for this user


class OutputError(CrackgrowError):
    """A result file cannot be written; the message names the file and why."""

    exit_code = 3


class OccupiedError(CrackgrowError):
    """A folder with files that a run would replace though they are not known to be a run's; the message names one."""

    exit_code = 2


class FolderError(CrackgrowError):
    """A folder that holds no results, or not those that are wanted; the message says what is missing."""

    exit_code = 3


def damaged(path: Path, what: str) -> FolderError:
    """The error of a file that can't be read as what it should be."""
    return FolderError(f"{path} is damaged, or of another version: {what}; run the case again")


def refused(path: Path, error: OSError) -> OutputError:
    """What to say of a file that the system does not let be written."""
    room = "make room there or " if error.errno in FULL else ""
    return OutputError(f"cannot write {path}: {error.strerror or error}; {room}choose another folder")


@contextlib.contextmanager
def _refusals_of(path: Path) -> Iterator[None]:
    """Raise OutputError for what the system refuses in the block."""
    try:
        yield
    except OSError as error:
        raise refused(path, error) from error


def temporary_path(path: Path) -> Path:
    """Where `path` is written before it is renamed: hidden, in the same folder, with the same suffix."""
    return path.with_name(f".{path.stem}.tmp{path.suffix}")


def write_atomically(path: Path, write: Callable[[Path], object], *, durable: bool = False) -> None:
    """Let `write` fill a temporary file and rename it to `path`; makes the folder where it is missing.

    If `write` raises, `path` stays as it was and the temporary file is removed. A `durable` file is on the disk itself
    when this returns: it outlives a loss of power.
    Raises OutputError where the system refuses; what else `write` raises passes through.
    """
    temporary = temporary_path(path)
    with _refusals_of(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            write(temporary)
            if durable:
                _flush(temporary)
            temporary.replace(path)
            if durable:
                _flush(path.parent)  # its new name
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise


def _flush(path: Path) -> None:
    """Have the system bring a file or folder to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` to `path` atomically; raises OutputError."""
    write_atomically(path, lambda temporary: temporary.write_bytes(data))


def write_text(path: Path, text: str) -> None:
    """Write `text` (UTF-8, line ends as given) to `path` atomically; raises OutputError."""
    write_bytes(path, text.encode())


class GrowingFile:
    """A text (UTF-8) that grows by lines; the file has all of them after every `write`."""

    def __init__(self, path: Path, *lines: str) -> None:
        self.path = path
        self.lines = list(lines)
        self.n_written = 0  # lines on disk as they are here

    def write(self) -> None:
        """Append what is new at once, all of it or nothing; a file that is gone is made anew. Raises OutputError."""
        new = "".join(f"{line}\n" for line in self.lines[self.n_written :]).encode()
        if self.n_written and self.path.exists():
            with _refusals_of(self.path), self.path.open("ab", buffering=0) as file:
                size = file.tell()
                if file.write(new) < len(new):
                    file.truncate(size)
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        else:
            write_text(self.path, "".join(f"{line}\n" for line in self.lines))
        self.n_written = len(self.lines)


def remove_files(files: Iterable[Path]) -> None:
    """Remove files as far as they are there; raises OutputError."""
    for path in files:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise OutputError(f"cannot remove {path}: {error.strerror or error}") from error
