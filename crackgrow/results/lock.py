"""One run at a time in a folder: a lock of the operating system, which goes with the process that holds it."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import OccupiedError, OutputError, refused

LOCK: Final = ".crackgrow.lock"
PATIENCE: Final = 0.2  # s: whoever holds the lock may be about to go
NO_LOCKS: Final = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)  # of a file system
NOT_WRITABLE: Final = (errno.EACCES, errno.EPERM, errno.EROFS)  # of a folder: nobody here can write into it


class LockedError(CrackgrowError):
    """Another run writes into the folder; the message says which."""

    exit_code = 3


def check_place(folder: Path) -> None:
    """Make sure that results may go into a folder, which need not be there; changes nothing.

    Raises OutputError where the system can't have it, OccupiedError where it is the root of all folders.
    """
    if folder.resolve() == Path(folder.resolve().anchor):
        raise OccupiedError(f"{folder} is the root of all folders, not one for results; choose another folder")
    there = existing_part(folder)
    if not there.is_dir():
        raise OutputError(f"cannot write results into {folder}: {there} is a file; choose another folder")
    if is_too_long(folder) or any(is_too_long(there / name) for name in folder.parts[len(there.parts) :]):
        raise OutputError(f"cannot write results into {folder}: the name is too long; choose another folder")


def existing_part(folder: Path) -> Path:
    """The folder itself if it is there, else the nearest above it that is."""
    return next(place for place in (folder, *folder.parents) if os.path.exists(place))  # noqa: PTH110  (Path's raises)


def is_too_long(path: Path) -> bool:
    """Whether the file system can't have a file of this name; that of a folder which is there can tell of a name."""
    try:
        path.lstat()
    except OSError as error:
        return error.errno == errno.ENAMETOOLONG
    return False


class FolderLock:
    """The lock of a folder: a file in it, on which the system holds an exclusive lock as long as the process lives.

    A process that is killed, or a machine that loses its power, leaves the file and no lock: the next run takes it. The
    file has a line of JSON that says who holds it; it goes when the lock is released.
    """

    def __init__(self, folder: Path, what: str) -> None:
        """`what` is about to write, such as "case slope"."""
        self._path = folder / LOCK
        self._lock = FileLock(self._path, timeout=PATIENCE, fallback_to_soft=False, thread_local=False)
        self._is_new = False  # the folder
        self._what = what
        self._words = ""
        self.remark = ""  # what the user should know of the lock

    def take(self) -> None:
        """Take the lock unless it is held here already; makes the folder.

        Raises LockedError, and OutputError and OccupiedError as `check_place`. Where the file system knows no locks,
        `remark` says so. A folder that can't be written needs none.
        """
        folder = self._path.parent
        if self._lock.is_locked:
            return
        check_place(folder)
        self._is_new = not folder.exists()
        since = datetime.now().astimezone().isoformat(timespec="seconds")
        holder = {"what": self._what, "process": os.getpid(), "host": socket.gethostname(), "since": since}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock.acquire()
            self._words = json.dumps(holder)
            self._path.write_text(self._words, encoding="utf-8")
        except Timeout:
            raise LockedError(self._told()) from None
        except OSError as error:
            self._lock.release()
            if error.errno in NO_LOCKS:
                self.remark = (
                    f"the file system of {folder} knows no locks ({error.strerror}): see to it that no other run "
                    "writes into this folder"
                )
            elif error.errno not in NOT_WRITABLE:
                raise refused(self._path, error) from error

    def release(self) -> None:
        """Give the lock back, if it is held; the file goes before, and a new folder into which nothing has come."""
        if self._lock.is_locked:
            with contextlib.suppress(OSError):
                if self._path.read_text(encoding="utf-8") == self._words:  # else somebody has removed the folder
                    self._path.unlink()
                if self._is_new:
                    self._path.parent.rmdir()
            self._lock.release()

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """As `take`, until the end of the block."""
        self.take()
        try:
            yield
        finally:
            self.release()

    def _told(self) -> str:
        """What to say of another holder, by what it has left in the file."""
        try:
            found = json.loads(self._path.read_bytes())
            which = "{what}, process {process} on {host}, since {since}".format(**found)
        except (OSError, ValueError, KeyError, TypeError):  # it has not written it yet
            which = "it has not said which"
        return (
            f"another run is writing into {self._path.parent} ({which}); wait until it has ended, end it, or choose "
            "another folder"
        )
