"""Files of text are written whole or not at all; tables have the columns of the contract, numbers to the last bit."""

from __future__ import annotations

import errno
import os
import resource
from pathlib import Path

import pytest

from crackgrow.results import tables
from crackgrow.results.atomic import GrowingFile, OutputError, write_atomically, write_text


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_file_is_written_whole_or_stays_as_it_was(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "new" / "a.csv"
    write_text(path, "x,y\n1,µ\n")

    def write_half(temporary: Path) -> None:
        temporary.write_text("ha")
        raise error

    with pytest.raises(error):
        write_atomically(path, write_half)
    assert path.read_bytes() == "x,y\n1,µ\n".encode()
    assert [file.name for file in path.parent.iterdir()] == ["a.csv"]


@pytest.mark.parametrize(("number", "room"), [(errno.ENOSPC, True), (errno.EDQUOT, True), (errno.EROFS, False)])
def test_what_the_system_refuses_names_the_file_and_asks_for_room(number: int, room: bool, tmp_path: Path) -> None:
    def write(temporary: Path) -> None:
        raise OSError(number, os.strerror(number), temporary)

    with pytest.raises(OutputError, match=rf"a\.csv: {os.strerror(number)}; .*choose another folder") as caught:
        write_atomically(tmp_path / "a.csv", write)
    assert ("make room" in str(caught.value)) == room
    assert caught.value.exit_code == 3


def test_lines_are_appended_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    file = GrowingFile(tmp_path / "a.log", "x")
    file.write()
    file.lines.append("µ")
    file.write()
    file.lines.append("a line that has no room on the disk")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, limits[1]))
    try:
        with pytest.raises(OutputError, match=r"a\.log: No space left"):
            file.write()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert file.path.read_text(encoding="utf-8") == "x\nµ\n"


def test_rows_are_appended_and_a_file_that_is_gone_is_whole_again(tmp_path: Path) -> None:
    table = tables.Table(tmp_path, "a", ("x", "y"))
    table.write()
    inode = table.path.stat().st_ino
    table.extend([(1, 2.5), (3, 4.5)])
    table.write()
    assert table.path.read_text() == "x,y\n1,2.5\n3,4.5\n"
    assert table.path.stat().st_ino == inode  # the same file, not a new one
    table.path.unlink()
    table.extend([(6, 7.5)])
    table.write()
    assert table.path.read_text() == "x,y\n1,2.5\n3,4.5\n6,7.5\n"


@pytest.mark.parametrize("name", ["tips", "events"])
def test_rows_from_a_step_on_are_dropped_and_a_row_that_a_kill_cut_off(name: str, tmp_path: Path) -> None:
    """ "1" may be the begin of a row of step 12."""
    table = tables.Table(tmp_path, name)
    table.extend([(step, "flaw") for step in (0, 1, 1, 2, 3)])
    table.write()
    whole = table.path.read_text()
    table.path.write_text(whole + "1")
    table.drop_from(3)
    assert table.path.read_text() == whole[: whole.index("\n3,") + 1]
    assert len(table) == 4
