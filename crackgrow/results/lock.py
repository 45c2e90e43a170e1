"""Whose a folder is: one run at a time writes into it, and no file goes that no run has written.

The lock is one of the operating system, which goes with the process that holds it. Of what is there, only files of the
program's own names are ever removed, and only where something that no stranger has shows that a run wrote them: a
summary.json with the program's own keys; where there is none, or an empty one as after a loss of power, a checkpoint or
a log of the program.
"""

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
from crackgrow.results.atomic import OccupiedError, OutputError, refused, temporary_path
from crackgrow.results.folder import CHECKPOINT, LOG, SUMMARY, SUMMARY_KEYS, RunFolder, own_files, series_names
from crackgrow.results.log import is_log
from crackgrow.results.resume import is_checkpoint

LOCK: Final = ".crackgrow.lock"
PATIENCE: Final = 0.2  # s: whoever holds the lock may be about to go
NO_LOCKS: Final = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)  # of a file system
NOT_WRITABLE: Final = (errno.EACCES, errno.EPERM, errno.EROFS)  # of a folder: nobody here can write into it


class LockedError(CrackgrowError):
    """Another run writes into the folder; the message says which."""

    exit_code = 3


@contextlib.contextmanager
def locked(folder: Path, what: str) -> Iterator[str]:
    """A folder, made where it is missing, into which nothing else writes until the end of the block.

    `what` is about to write, such as "case slope"; yields what the user should know of the lock, mostly nothing. It is
    a file in the folder, on which the system holds an exclusive lock as long as the process lives: a process that is
    killed, or a machine that loses its power, leaves the file and no lock. In the file stands who holds it, as JSON; it
    goes at the end, as does a new folder into which nothing has come.

    Raises LockedError, and OutputError and OccupiedError as `check_place`. Where the file system knows no locks, or the
    folder can't be written, there is none.
    """
    check_place(folder)
    path, is_new, remark = folder / LOCK, not folder.exists(), ""
    lock = FileLock(path, timeout=PATIENCE, fallback_to_soft=False, thread_local=False)
    since = datetime.now().astimezone().isoformat(timespec="seconds")
    holder = json.dumps({"what": what, "process": os.getpid(), "host": socket.gethostname(), "since": since})
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock.acquire()
        path.write_text(holder, encoding="utf-8")
    except Timeout:
        try:
            found = json.loads(path.read_bytes())
            which = "{what}, process {process} on {host}, since {since}".format(**found)
        except (OSError, ValueError, KeyError, TypeError):  # it has not written it yet
            which = "it has not said which"
        words = f"another run is writing into {folder} ({which}); wait until it has ended, end it, or choose another"
        raise LockedError(f"{words} folder") from None
    except OSError as error:
        lock.release()
        if error.errno in NO_LOCKS:
            remark = f"the file system of {folder} knows no locks ({error.strerror}): see to it that no other run "
            remark += "writes into this folder"
        elif error.errno not in NOT_WRITABLE:
            raise refused(path, error) from error
    try:
        yield remark
    finally:
        if lock.is_locked:
            with contextlib.suppress(OSError):
                if path.read_text(encoding="utf-8") == holder:  # else somebody has removed the folder
                    path.unlink()
                if is_new:
                    folder.rmdir()
            lock.release()


def check_place(folder: Path, case_name: str = "") -> None:
    """Make sure that results, of the case if it is named, may go into a folder, which need not be there.

    Changes nothing. Raises OutputError where the system can't have such files, OccupiedError where the folder is the
    root of all.
    """
    if folder.resolve() == Path(folder.resolve().anchor):
        raise OccupiedError(f"{folder} is the root of all folders, not one for results; choose another folder")
    # the folder itself if it is there, else the nearest above it that is; Path's own exists() raises for a long name
    there = next(place for place in (folder, *folder.parents) if os.path.exists(place))  # noqa: PTH110
    if not there.is_dir():
        raise OutputError(f"cannot write results into {folder}: {there} is a file; choose another folder")
    if _is_too_long(folder) or any(_is_too_long(there / name) for name in folder.parts[len(there.parts) :]):
        raise OutputError(f"cannot write results into {folder}: the name is too long; choose another folder")
    for name in series_names(case_name) if case_name else ():
        if any(_is_too_long(place / temporary_path(Path(name))) for place in (there, folder)):
            raise OutputError(f"cannot write {folder / name}: the name is too long; rename the case")


def _is_too_long(path: Path) -> bool:
    """Whether the file system can't have a file of this name; that of a folder which is there can tell of a name."""
    try:
        path.lstat()
    except OSError as error:
        return error.errno == errno.ENAMETOOLONG
    return False


def earlier_files(folder: Path, case_name: str) -> list[Path]:
    """The files in a folder that a run would remove or replace, half written ones too, of this case or of another.

    Checkpoints come before the results without which they lead nowhere, the summary, which shows whose the files are,
    comes last. Raises OccupiedError where nothing shows that a run wrote them, and as `check_place`.
    """
    check_place(folder, case_name)
    summary = RunFolder(folder).found_summary
    is_own = all(key in summary for key in SUMMARY_KEYS)
    cases = {case_name, Path(str(summary["case"])).name if is_own else case_name}
    paths = {own.path for case in cases for own in own_files(folder, case)}
    found = sorted(paths, key=lambda path: (path.parent.name != "checkpoint", path.name == SUMMARY, path))
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
    return is_log(folder / LOG) or any(is_checkpoint(own.path) for own in own_files(folder, names=[CHECKPOINT]))
