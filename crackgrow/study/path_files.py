"""Crack paths from files: paths.csv of a result folder, or the CSV of another program or of a paper."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np
import yaml

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.dump import read_settings
from crackgrow.case.report import clean, did_you_mean, quoted
from crackgrow.case.units import UNITS, QuantityError, Units, parse_number, parse_quantity
from crackgrow.errors import CaseError, Fault
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.results.atomic import FolderError
from crackgrow.results.folder import CASE, RunFolder

Tip = Literal["start", "end"]
Read = TypeVar("Read")

MOST_VERTICES = 2000  # of one crack: comparing takes time and memory in the product of two of them
FORMAT = "a CSV of crack paths has columns x and y (in m, or x_mm and y_mm), and may have crack, vertex and step"
SEPARATED = "columns are separated by commas, or all by semicolons or tabs"


@dataclass(frozen=True, slots=True, eq=False)
class PathLine:
    """One crack as a file gives it."""

    points: Floats  # (n, 2) m, from start to end
    steps: Ints | None  # (n,) the step whose advance made the vertex, 0 for the given crack; None if not told

    @property
    def made(self) -> Ints:
        """The steps (n,); 0, of the given crack, where they are not told."""
        return np.zeros(len(self.points), dtype=np.int64) if self.steps is None else self.steps

    @property
    def first(self) -> Bools:
        """Which vertices (n,) are those of the crack as it began: given, or started by a run in a later step."""
        return np.asarray(self.made == self.made.min())

    @property
    def length(self) -> float:
        """Its length, m."""
        return float(arc_lengths(self.points)[-1])

    @property
    def given(self) -> PathLine:
        """The crack as it began."""
        return PathLine(self.points[self.first], self.made[self.first])

    def wing(self, tip: Tip) -> PathLine:
        """What has grown at a tip, from its root, the end of the given crack, outward; the root alone: nothing."""
        order = slice(None, None, -1 if tip == "start" else 1)
        steps, points, first = self.made[order], self.points[order], self.first[order]
        root = int(np.flatnonzero(first)[-1])
        return PathLine(points[root:], steps[root:])


@dataclass(frozen=True, slots=True, eq=False)
class PathSet:
    """The cracks of one file, by name; the one crack of a file without names is under ""."""

    source: str  # folder or file, as given
    cracks: dict[str, PathLine]
    status: str  # of the run: "completed, 22 steps"; "" if not told
    settings: dict[str, str] | None  # of case.yaml by dotted key; None if there is none


def read_paths(source: str | Path, columns: Sequence[str] | None = None) -> PathSet:
    """The crack paths of a result folder or of a CSV file; `columns` names the columns of x and y of a CSV.

    Raises CaseError with the first fault of the file.
    """
    path = Path(source)
    if not path.is_dir():
        if not path.is_file():
            near = did_you_mean(path.name, [entry.name for entry in path.parent.glob("*")])
            raise CaseError.at(path, f"no such folder or file{near}; compared are result folders and CSV files")
        return PathSet(str(source), _read_csv(path, lambda rows: _cracks(rows, columns)), "", None)
    run = RunFolder(path)
    if not run.has("paths.csv"):
        inner = sorted(found.parent.name for found in path.glob("*/paths.csv"))
        hint = f"; there are results in {', '.join(inner[:5])} inside it" if inner else ""
        raise CaseError.at(path, f"is no result folder: it has no paths.csv{hint}")
    steps = run.found_summary.get("steps_done")
    status = f"{run.status}, {steps} steps" if run.status and steps is not None else ""
    cracks = _read_csv(path / "paths.csv", lambda rows: _cracks(rows, None))
    return PathSet(str(source), cracks, status, _settings(run) if run.has(CASE) else None)


def _settings(run: RunFolder) -> dict[str, str]:
    path = run.folder / CASE
    try:
        return read_settings(run.case_text)
    except (FolderError, RecursionError) as error:
        raise CaseError.at(path, f"cannot be read: {_reason(error.__cause__ or error)}") from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or "is no YAML"
        raise CaseError([Fault(str(path), mark.line + 1 if mark else None, "", f"is no YAML: {problem}")]) from error


def _reason(error: BaseException) -> str:
    return getattr(error, "strerror", None) or "is not a text in UTF-8"


class _WrongError(Exception):
    """What is wrong in a CSV file: its line, key and a message."""


def read_points(path: Path, columns: tuple[str, str]) -> Floats:
    """Read two columns (n, 2) of a CSV file, as they stand. Raises CaseError with its first error and that line."""
    return _read_csv(path, lambda rows: _points(rows, columns))


def _read_csv(path: Path, read: Callable[[list[tuple[int, list[str]]]], Read]) -> Read:
    """What is read of the rows of a CSV file; raises CaseError with its first fault and that line."""
    try:
        return read(_rows(path.read_text(encoding="utf-8-sig")))
    except _WrongError as wrong:
        raise CaseError([Fault(str(path), *wrong.args)]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError.at(path, f"cannot be read: {_reason(error)}") from error


def _points(rows: list[tuple[int, list[str]]], columns: tuple[str, str]) -> Floats:
    """The numbers (n, 2) of two columns; raises _WrongError."""
    if not rows:
        raise _WrongError(1, "", f"is empty; wanted: a CSV with columns {' and '.join(columns)}")
    (head, header), *body = rows
    places = [_named(head, header, name) for name in columns]
    points = np.empty((len(body), 2))
    for row, (line, cells) in enumerate(body):
        _check_width(line, cells, header)
        for axis, (name, index) in enumerate(zip(columns, places, strict=True)):
            try:
                points[row, axis] = parse_number(cells[index])
            except QuantityError as error:
                message = f"{quoted(cells[index])} {error}; wanted: a number such as 0.25, {SEPARATED}"
                raise _WrongError(line, clean(name), message) from None
    return points


def _check_width(line: int, cells: list[str], header: list[str]) -> None:
    """Refuse a row that has more or fewer values than the header."""
    if len(cells) != len(header):
        raise _WrongError(line, "", f"has {len(cells)} values, the header has {len(header)}; {SEPARATED}")


def _named(line: int, header: list[str], name: str) -> int:
    """Number of the one column of a name."""
    if header.count(name) != 1:
        there = "several columns" if name in header else "no column"
        near = "" if name in header else did_you_mean(name, header)
        raise _WrongError(line, "", f"has {there} {quoted(name)}{near}; it has {_listed(header)}; {SEPARATED}")
    return header.index(name)


def _cracks(rows: list[tuple[int, list[str]]], columns: Sequence[str] | None) -> dict[str, PathLine]:
    """The cracks of rows, in order of their first ones; raises _WrongError."""
    if not rows:
        raise _WrongError(1, "", f"is empty; {FORMAT}")
    (head, header), *body = rows
    places = [_coordinate(head, header, axis, columns) for axis in (0, 1)]
    if not body:
        raise _WrongError(head, "", "has no cracks, only a header")
    cracks: dict[str, list[tuple[float, ...]]] = {}
    for line, cells in body:
        _check_width(line, cells, header)
        named = dict(zip(header, cells, strict=True))
        crack = cracks.setdefault(named.get("crack", ""), [])
        x, y = (_metres(line, header[index], cells[index], unit) for index, unit in places)
        step, vertex = named.get("step", "0"), named.get("vertex", str(len(crack)))
        if not re.fullmatch(r"[0-9]{1,9}", step):
            raise _WrongError(
                line, "step", f"{quoted(step)} is no step; allowed are 0, of the given crack, and 1, 2, ..."
            )
        try:
            number = parse_number(vertex)
            what = f"comes after {crack[-1][-1]:g}" if crack and number <= crack[-1][-1] else ""
        except QuantityError:
            number, what = math.nan, "is not a number"
        if what:
            raise _WrongError(line, "vertex", f"{quoted(vertex)} {what}; allowed are numbers that rise along a crack")
        crack.append((line, x, y, int(step), number))
    return {name: _line(name, np.array(crack), "step" in header) for name, crack in cracks.items()}


def _rows(text: str) -> list[tuple[int, list[str]]]:
    """Rows with their lines; blank lines and comments are left out."""
    lines = text.splitlines()
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    reader = csv.reader(lines, delimiter=next((sign for sign in (",", ";", "\t") if sign in first), ","))
    try:
        rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
    except csv.Error as error:
        raise _WrongError(reader.line_num, "", f"is no CSV: {error}") from error
    return [(line, cells) for line, cells in rows if any(cells) and not cells[0].startswith("#")]


def _coordinate(line: int, header: list[str], axis: int, columns: Sequence[str] | None) -> tuple[int, str]:
    """Number and length unit of the column of x (axis 0) or y (axis 1); a fault where there is none, or several."""
    if columns is not None:
        name = columns[axis]
        return _named(line, header, name), next((word for word in _words(name) if word in UNITS["length"]), "m")
    letter = "xy"[axis]
    named = {index: words for index, name in enumerate(header) if (words := _words(name))[0] == letter}
    known = {index: words for index, words in named.items() if len(words) == 1 or words[1] in UNITS["length"]}
    found = {index: words for index, words in known.items() if len(words) <= 2} or known  # of x and x_mm_other, x
    if len(found) > 1:
        names = ", ".join(clean(header[index]) for index in found)
        raise _WrongError(line, "", f"has several columns for {letter}: {names}; choose with --columns X,Y")
    if named and not found:
        allowed = ", ".join([letter, *(f"{letter}_{unit}" for unit in UNITS["length"])])
        raise _WrongError(line, clean(header[next(iter(named))]), f"has no known unit of length; allowed are {allowed}")
    if not found:
        raise _WrongError(line, "", f"has no column for {letter}, it has {_listed(header)}; {FORMAT}")
    ((index, words),) = found.items()
    return index, words[1] if len(words) > 1 else "m"


def _metres(line: int, key: str, text: str, unit: str) -> float:
    try:
        return parse_quantity(text, "length", Units(length=unit))
    except QuantityError as error:
        message = f"{quoted(text)} {error}; allowed is a length, in {unit} where it has no unit"
        raise _WrongError(line, key, message) from None


def _line(name: str, table: Floats, with_steps: bool) -> PathLine:
    """The crack of its rows (n, 5): line, x, y, step, vertex; points that repeat the one before are left out."""
    moves = np.concatenate([[True], np.any(np.diff(table[:, 1:3], axis=0) != 0, axis=1)])
    points, steps = table[moves, 1:3], table[moves, 3].astype(np.int64)
    points.flags.writeable = steps.flags.writeable = False
    line = PathLine(points, steps if with_steps else None)
    first_row, key, first = int(table[0, 0]), f"crack {clean(name)}" * bool(name), np.flatnonzero(line.first)
    if not 2 <= len(points) <= MOST_VERTICES:
        raise _WrongError(
            first_row, key, f"has {len(points)} different points; allowed are 2 to {MOST_VERTICES} a crack"
        )
    # what starts in the run is a segment at once, where a tip adds one vertex
    if with_steps and ((len(first) < 2 and steps.min() > 0) or first[-1] - first[0] >= len(first)):
        told = "its vertices of step 0, the given crack, must be there and follow each other"
        raise _WrongError(first_row, key, f"{told}; so must two or more of its first step, of one that a run started")
    return line


def _words(name: str) -> list[str]:
    """The words of a column's name: x_mm, x [mm] and x (mm) are x and mm."""
    words = [word for word in re.split(r"[\s_\[\]()]+", name.strip()) if word]
    return [words[0].lower(), *words[1:]] if words else [""]


def _listed(header: Sequence[str]) -> str:
    return clean(", ".join(header)) or "none"
