"""One run at a time in a folder: a lock of the operating system, which goes with the process that holds it."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import socket
import weakref
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Final

from crackgrow.errors import CrackgrowError
from crackgrow.results.atomic import OccupiedError, OutputError, refused

LOCK: Final = ".crackgrow.lock"
TAKEN: Final = (errno.EAGAIN, errno.EACCES)  # of a file that somebody else holds
NOT_WRITABLE: Final = (errno.EACCES, errno.EPERM, errno.EROFS)  # of a folder: nobody here can write into it
MOST_WORDS: Final = 4096  # bytes that a holder leaves of itself


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
        self._what = what
        self._release: weakref.finalize[..., FolderLock] | None = None
        self.remark = ""  # what the user should know of the lock

    def take(self) -> None:
        """Take the lock unless it is held here already; makes the folder.

        Raises LockedError, and OutputError and OccupiedError as `check_place`. Where the file system knows no locks,
        `remark` says so. A folder that can't be written needs none.
        """
        if self._release is not None:
            return
        check_place(self._path.parent)
        is_new = not self._path.parent.exists()
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            file = self._open()
        except OSError as error:
            if error.errno in NOT_WRITABLE:
                return
            raise refused(self._path, error) from error
        self._release = weakref.finalize(self, _release, self._path, file, is_new)

    def release(self) -> None:
        """Give the lock back, if it is held."""
        if self._release is not None:
            self._release()
            self._release = None

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """As `take`, until the end of the block."""
        self.take()
        try:
            yield
        finally:
            self.release()

    def _open(self) -> int:
        """The locked file: not one that its holder has removed since it was opened."""
        while True:
            file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                self._lock(file)
                if _is(self._path, file):
                    os.ftruncate(file, 0)
                    os.write(file, _words(self._what))
                    return file
            except BaseException:
                os.close(file)
                raise
            os.close(file)

    def _lock(self, file: int) -> None:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in TAKEN:
                raise LockedError(self._told(os.pread(file, MOST_WORDS, 0))) from None
            self.remark = (
                f"the file system of {self._path.parent} knows no locks ({error.strerror}): see to it that no other "
                "run writes into this folder"
            )

    def _told(self, words: bytes) -> str:
        """What to say of another holder, by what it has left in the file."""
        try:
            found = json.loads(words)
            which = "{what}, process {process} on {host}, since {since}".format(**found)
        except (ValueError, KeyError, TypeError):  # it has not written it yet
            which = "it has not said which"
        return (
            f"another run is writing into {self._path.parent} ({which}); wait until it has ended, end it, or choose "
            "another folder"
        )


def _words(what: str) -> bytes:
    """What a holder leaves of itself."""
    since = datetime.now().astimezone().isoformat(timespec="seconds")
    return json.dumps({"what": what, "process": os.getpid(), "host": socket.gethostname(), "since": since}).encode()


def _is(path: Path, file: int) -> bool:
    """Whether an open file is still the one of a path."""
    try:
        return os.path.samestat(path.stat(), os.fstat(file))
    except FileNotFoundError:
        return False


def _release(path: Path, file: int, is_new: bool) -> None:
    """Remove the file as long as it is locked: nobody takes it for free who opens it later.

    A new folder goes, too, where nothing has come into it.
    """
    with contextlib.suppress(OSError):
        if _is(path, file):
            path.unlink()
            if is_new:
                path.parent.rmdir()
    os.close(file)
