"""The case that a command line names."""

from __future__ import annotations

import argparse
import difflib
import os
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.errors import CaseError

if TYPE_CHECKING:
    from crackgrow.case.model import Case


def load_case_file(arguments: argparse.Namespace) -> Case:
    """The case of the arguments `case` and `overrides`; raises CaseError."""
    path: Path = arguments.case
    if not os.path.isfile(path):  # noqa: PTH113  (Path's fails on a long name)
        raise CaseError.at(path, _missing_message(path))
    return crackgrow.load_case(path, arguments.overrides)


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
