"""Printing, what commands have in common, and the exit codes."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shlex
import sys
from pathlib import Path

from crackgrow.results.atomic import OutputError

EXIT_DONE, EXIT_BUG, EXIT_UNSOLVED, EXIT_INTERRUPTED = 0, 1, 3, 130
EXIT_DIFFERENT = 4  # of compare and trade


def write_any_character() -> None:
    """Let standard output write what its encoding lacks as escapes, as standard error does, and not fail."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def say(text: str, end: str = "\n") -> None:
    """Print at once; a reader that has gone away (`| head`) or a full or closed output doesn't end the run."""
    with contextlib.suppress(OutputError):
        hand_out(text, end)


def hand_out(text: str, end: str = "") -> None:
    """Print what a command is there to print; raises OutputError where it cannot be written, as on a full disk.

    A reader that has gone away has had what it wants.
    """
    try:
        print(text, end=end, flush=True)
    except (OSError, ValueError) as error:
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115  (until the process ends)
        if not isinstance(error, BrokenPipeError):
            raise OutputError(f"cannot write standard output: {getattr(error, 'strerror', None) or error}") from error


def hand_out_json(record: object) -> None:
    """Print a record as JSON; raises OutputError."""
    hand_out(json.dumps(record, indent=2, allow_nan=False) + "\n")


def count(text: str) -> int:
    """A whole number from 1 on, of an argument."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: a whole number from 1 on is wanted")
    return int(text)


def spelled(*words: str) -> str:
    """A command of this program, as the user would type it."""
    script = Path(sys.argv[0]).name == "crackgrow"
    program = [str(Path(sys.argv[0]).resolve())] if script else [sys.executable, "-m", "crackgrow"]
    return shlex.join([*program, *words])


def complain(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody listens: the exit code still tells
        print(text, file=sys.stderr, flush=True)
