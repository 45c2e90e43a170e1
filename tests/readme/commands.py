"""The commands that a README shows.

An indented block holds shell commands, one a line, or longer with a backslash at the end. A fenced block says what it
is: `sh` the same, `console` commands after `$ ` with what they print below, `python` a program; other words are text.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

INDENT = "    "
FENCE = "```"
TEXTS = ("bibtex", "yaml", "text")
COMMENT = re.compile(r"\s+# .*$")


@dataclass(frozen=True, slots=True)
class Command:
    """A command of a README."""

    text: str
    line: int  # of the README, counted from 1
    language: str  # sh | python
    prints: tuple[str, ...] = ()  # lines that the README shows of its output
    file: str = "README.md"

    @property
    def place(self) -> str:
        """Where it stands."""
        return f"{self.file}:{self.line}"


def commands(readme: str, file: str = "README.md") -> list[Command]:
    """All commands of a README, in order; raises ValueError for a block that is none of those above."""
    found: list[Command] = []
    for line, language, block in _blocks(readme.splitlines()):
        if language == "sh":
            found.extend(_shell(block, line, file))
        elif language == "console":
            found.extend(_console(block, line))
        elif language == "python":
            found.append(Command("\n".join(block), line, "python"))
        elif language not in TEXTS:
            raise ValueError(f"{file}:{line}: a block of {language!r}: wanted is sh, console, python, {TEXTS}")
    return [replace(command, file=file) for command in found]


def _blocks(lines: list[str]) -> Iterator[tuple[int, str, list[str]]]:
    """Number of the first line, language and lines of every code block."""
    number = 0
    while number < len(lines):
        start = number
        if lines[number].startswith(FENCE):
            number = lines.index(FENCE, number + 1)
            yield start + 2, lines[start].removeprefix(FENCE), lines[start + 1 : number]
        elif lines[number].startswith(INDENT) and not lines[number - 1].strip():
            while number < len(lines) and lines[number].startswith(INDENT):
                number += 1
            yield start + 1, "sh", [text.removeprefix(INDENT) for text in lines[start:number]]
        number += 1


def _shell(block: list[str], line: int, file: str) -> Iterator[Command]:
    text, begun = "", line
    for number, part in enumerate(block, line):
        begun = begun if text else number
        text += COMMENT.sub("", part.strip())
        if text.endswith("\\"):
            text = text.removesuffix("\\")
        elif text:
            yield Command(text, begun, "sh")
            text = ""
    if text:
        raise ValueError(f"{file}:{begun}: the command goes on after its block")


def _console(block: list[str], line: int) -> Iterator[Command]:
    starts = [number for number, text in enumerate(block) if text.startswith("$ ")]
    for start, end in zip(starts, [*starts[1:], len(block)], strict=True):
        yield Command(block[start].removeprefix("$ "), line + start, "sh", tuple(block[start + 1 : end]))
