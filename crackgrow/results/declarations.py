"""What a run's folder holds: its files, and every column, field and key in them, as `columns.yaml` declares them.

The tables take their headers from here, and so do `crackgrow explain` and outputs/README.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Final

import yaml

PHASES: Final = ("cover", "assembly", "factorize", "contact", "criterion", "output")
LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # five times as fast, where libyaml is there
KINDS: Final = {kind.__name__: kind for kind in (int, str, bool)}


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table, a field of a frame, or a key of a JSON file."""

    name: str
    unit: str  # empty for counts, words and ratios
    doc: str  # a line for the user
    kind: type[float | int | str | bool] = float  # of its cells in the tables of runs and sweeps


@dataclass(frozen=True, slots=True)
class File:
    """A file, or files of one kind."""

    name: str  # relative to the folder; NAME is the case's, FIELD that of a field, NNNN the number of a step
    doc: str
    columns: tuple[Column, ...] = ()

    @property
    def header(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)


def declared(told: Mapping[str, Any]) -> tuple[File, ...]:
    """Files by name, each with its meaning, or a mapping of that and of its columns: [unit, meaning, kind]."""
    found = []
    for name, of in told.items():
        columns = of["columns"] if isinstance(of, dict) else {}
        kinds = {column: KINDS[kind[0]] if kind else float for column, (_, _, *kind) in columns.items()}
        rows = (Column(column, unit, doc, kinds[column]) for column, (unit, doc, *_) in columns.items())
        found.append(File(name, of["meaning"] if isinstance(of, dict) else of, tuple(rows)))
    return tuple(found)


@cache
def columns_of(room: str) -> dict[str, Any]:
    """What the `columns.yaml` of a room of the package says."""
    text = files(f"crackgrow.{room}").joinpath("columns.yaml").read_text(encoding="utf-8")
    return dict(yaml.load(text, LOADER))


RUN: Final = declared(columns_of("results"))
"""Files of a run."""

FILES: Final = {file.name: file for file in RUN}
