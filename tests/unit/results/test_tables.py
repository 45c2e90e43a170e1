"""Files of text are written whole or not at all; tables have the columns of the contract, numbers to the last bit."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from crackgrow.results import tables
from crackgrow.results.atomic import OutputError, write_atomically, write_text


def test_a_file_is_written_whole_or_stays_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.csv"
    write_text(path, "x,y\n1,µ\n")

    def write_half(temporary: Path) -> None:
        temporary.write_text("ha")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
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
