"""The command line: the only place that prints.

Exit codes: 0 done, 1 a bug (which shows its traceback), 2 the case is wrong, 3 it can't be solved or written as asked,
4 paths that `compare` finds further apart than the tolerance, or a setting that `trade` finds not good enough,
130 interrupted.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Final

from crackgrow import __version__
from crackgrow.limits import allowed

LEAST: Final = (
    ("NOFILE", 10, "open files", 1, "ulimit -n"),
    ("AS", 600 * 2**20, "KiB of addresses", 2**10, "ulimit -v"),
    ("DATA", 250 * 2**20, "KiB of data", 2**10, "ulimit -d"),
)
"""Limits of the system: the least with which the program and its libraries load, in words, unit, how to set it."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return the exit code."""
    if [*(sys.argv[1:] if argv is None else argv)] == ["--version"]:  # programs ask for it again and again
        sys.stdout.write(f"crackgrow {__version__}\n")
        return 0
    for kind, least, what, unit, command in LEAST:
        limit = allowed(kind)
        if limit < least:
            told = f"{limit // unit} {what} are allowed (`{command}`), the program takes at least {least // unit}"
            sys.stderr.write(f"crackgrow: {told}\n")
            return 3
    from crackgrow.cli.command_line import main as answer  # only now: it opens many files

    return answer(argv)
