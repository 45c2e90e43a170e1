"""Printing, what commands have in common, and the exit codes."""

from __future__ import annotations

import contextlib
import difflib
import io
import json
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.errors import CaseError
from crackgrow.results.atomic import OutputError

if TYPE_CHECKING:
    from crackgrow.case.model import Case

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


def spelled(*words: str) -> str:
    """A command of this program, as the user would type it."""
    script = Path(sys.argv[0]).name == "crackgrow"
    program = [str(Path(sys.argv[0]).resolve())] if script else [sys.executable, "-m", "crackgrow"]
    return shlex.join([*program, *words])


def complain(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody listens: the exit code still tells
        print(text, file=sys.stderr, flush=True)


def load_case_file(path: Path, overrides: Sequence[str]) -> Case:
    """The case of a file with some settings; raises CaseError, also with what may be meant where there is no file."""
    if not os.path.isfile(path):  # noqa: PTH113  (Path's fails on a long name)
        raise CaseError.at(path, _missing_message(path))
    return crackgrow.load_case(path, overrides)


def _missing_message(path: Path) -> str:
    if os.path.isdir(path):  # noqa: PTH112  (as above)
        return "is a folder, not a case file"
    names = sorted(file.name for file in path.parent.glob("*.yaml"))
    near = [path.parent / name for name in difflib.get_close_matches(path.name, names, n=1)]
    of_that_name = Path("cases") / f"{path.stem}.yaml"  # where `crackgrow new` writes
    if path.parent == Path() and os.path.isfile(of_that_name):  # noqa: PTH113
        near = [of_that_name]
    if near:
        return f"no such case file; did you mean {near[0]}?"
    return f"no such case file; {path.parent} has {', '.join(names) or 'no case files'}"
