"""Atomic writing: the old file survives a writer that fails."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from crackgrow.results.atomic import OutputError, append_text, write_atomically, write_text


def test_text_is_written_and_nothing_else_is_left(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.csv"
    write_text(path, "x,y\n1,µ\n")
    assert path.read_bytes() == "x,y\n1,µ\n".encode()
    assert [file.name for file in path.parent.iterdir()] == ["a.csv"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_writer_that_raises_leaves_the_old_file(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "a.csv"
    write_text(path, "old")

    def write_half(temporary: Path) -> None:
        temporary.write_text("ha")
        raise error

    with pytest.raises(error):
        write_atomically(path, write_half)
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["a.csv"]


def test_system_refusal_is_an_output_error_naming_the_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/a\.csv") as caught:
        write_text(tmp_path / "file" / "a.csv", "x")
    assert caught.value.exit_code == 3


@pytest.mark.parametrize(("number", "room"), [(errno.ENOSPC, True), (errno.EDQUOT, True), (errno.EROFS, False)])
def test_room_is_asked_for_where_there_is_none(number: int, room: bool, tmp_path: Path) -> None:
    def write(temporary: Path) -> None:
        raise OSError(number, os.strerror(number), temporary)

    with pytest.raises(OutputError, match=rf"a\.csv: {os.strerror(number)}; .*choose another folder") as caught:
        write_atomically(tmp_path / "a.csv", write)
    assert ("make room" in str(caught.value)) == room


def test_text_is_appended_to_what_is_there(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    write_text(path, "x\n")
    assert append_text(path, "µ\n")
    assert path.read_text(encoding="utf-8") == "x\nµ\n"
    assert not append_text(tmp_path / "missing.csv", "y\n")
    assert not (tmp_path / "missing.csv").exists()


def test_a_disk_that_is_full_takes_no_part_of_what_is_appended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, write = tmp_path / "a.csv", os.write
    write_text(path, "old\n")
    monkeypatch.setattr(os, "write", lambda file, data: write(file, data[:2]))
    with pytest.raises(OutputError, match=r"a\.csv: No space left"):
        append_text(path, "new\n")
    assert path.read_text() == "old\n"
