"""The README of the package names all rooms and only files that are there, and stays short."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2] / "crackgrow"
README = (ROOT / "README.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Cells of the table below a heading, its own head left out."""
    section = README.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[2:]]


def test_every_room_is_named() -> None:
    rooms = {path.name for path in ROOT.iterdir() if (path / "__init__.py").is_file()}
    assert {room.strip("`") for room, _ in rows("Rooms")} == rooms


def test_every_file_is_there() -> None:
    named = set(re.findall(r"`([\w/]+\.py)`", README))
    assert len(named) > 40
    assert sorted(name for name in named if not ((ROOT / name).is_file() or (ROOT.parent / name).is_file())) == []


def test_every_idea_has_a_file() -> None:
    assert all(re.search(r"`\w+/\w+\.py`", files) for _, files, _ in rows("Idea, file, equation"))


def test_a_word_has_one_row() -> None:
    words = [word.strip() for cell, _ in rows("Words") for word in cell.split(",")]
    assert len(words) == len(set(words))
    assert 40 <= len(words) <= 60


def test_it_is_short() -> None:
    assert len(README.encode()) <= 9 * 1024
