"""Crack paths from files: paths.csv of a result folder, or the CSV of another program or of a paper."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
import yaml

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.case.dump import read_settings
from crackgrow.case.report import clean, did_you_mean, quoted
from crackgrow.case.units import UNITS, QuantityError, Units, parse_number, parse_quantity
from crackgrow.errors import CaseError, Fault
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.results.folder import CASE, FolderError, RunFolder

Tip = Literal["start", "end"]

MOST_VERTICES = 2000  # of one crack: comparing takes time and memory in the product of two of them
MOST_FAULTS = 10  # of the rows of one file that are told
FORMAT = "a CSV of crack paths has columns x and y (in m, or x_mm and y_mm), and may have crack, vertex and step"


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


@dataclass(slots=True)
class _Rows:
    """The rows of one crack while they are read."""

    line: int  # of the first row
    points: list[tuple[float, float]] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    vertex: float = -math.inf


def read_paths(source: str | Path, columns: Sequence[str] | None = None) -> PathSet:
    """The crack paths of a result folder or of a CSV file; `columns` names the columns of x and y of a CSV.

    Raises CaseError with all faults of the file.
    """
    path = Path(source)
    if not path.is_dir():
        if not path.is_file():
            raise CaseError.at(path, _missing(path))
        return PathSet(str(source), _read_csv(path, columns), "", None)
    run = RunFolder(path)
    if not run.has("paths.csv"):
        raise CaseError.at(path, _no_results(path))
    steps = run.found_summary.get("steps_done")
    status = f"{run.status}, {steps} steps" if run.status and steps is not None else ""
    return PathSet(str(source), _read_csv(path / "paths.csv", None), status, _settings(run))


def _missing(path: Path) -> str:
    near = did_you_mean(path.name, [entry.name for entry in path.parent.glob("*")]) if path.parent.is_dir() else ""
    return f"no such folder or file{near}; compared are result folders and CSV files"


def _no_results(path: Path) -> str:
    inner = sorted(found.parent.name for found in path.glob("*/paths.csv"))
    hint = f"; there are results in {', '.join(inner[:5])} inside it" if inner else ""
    return f"is no result folder: it has no paths.csv{hint}"


def _settings(run: RunFolder) -> dict[str, str] | None:
    path = run.folder / CASE
    if not run.has(CASE):
        return None
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


def _read_csv(path: Path, columns: Sequence[str] | None) -> dict[str, PathLine]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError.at(path, f"cannot be read: {_reason(error)}") from error
    return _CsvReader(str(path), columns).read(text)


class _CsvReader:
    """Reads one CSV text; gathers its faults, each with its line."""

    def __init__(self, source: str, columns: Sequence[str] | None) -> None:
        self._source = source
        self._columns = columns
        self._faults: list[Fault] = []

    def read(self, text: str) -> dict[str, PathLine]:
        """The cracks of the text, in order of their first rows; raises CaseError."""
        rows = self._rows(text)
        if not rows:
            raise CaseError([Fault(self._source, 1, "", f"is empty; {FORMAT}")])
        header_line, header = rows[0]
        x, y = (self._coordinate(header_line, header, axis) for axis in (0, 1))
        if x is None or y is None:
            raise self._error()
        cracks = self._gather(rows[1:], header, (x, y))
        if not cracks and not self._faults:
            self._fault(header_line, "", "has no cracks, only a header")
        self._raise_faults()
        lines = {name: self._line(name, crack, "step" in header) for name, crack in cracks.items()}
        self._raise_faults()
        return {name: line for name, line in lines.items() if line is not None}

    def _rows(self, text: str) -> list[tuple[int, list[str]]]:
        """Rows with their lines; blank lines and comments are left out."""
        lines = text.splitlines()
        first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
        delimiter = next((sign for sign in (",", ";", "\t") if sign in first), ",")
        reader = csv.reader(lines, delimiter=delimiter)
        rows: list[tuple[int, list[str]]] = []
        try:
            for cells in reader:
                stripped = [cell.strip() for cell in cells]
                if any(stripped) and not stripped[0].startswith("#"):
                    rows.append((reader.line_num, stripped))
        except csv.Error as error:
            self._fault(reader.line_num, "", f"is no CSV: {error}")
            self._raise_faults()
        return rows

    def _coordinate(self, line: int, header: list[str], axis: int) -> tuple[int, str] | None:
        """Index and length unit of the column of x (axis 0) or y (axis 1); None with a fault."""
        if self._columns is not None:
            name = self._columns[axis]
            if header.count(name) != 1:
                near = did_you_mean(name, header)
                self._fault(line, "", f"has no column {quoted(name)}{near}; it has {_listed(header)}")
                return None
            units = [word for word in _words(name) if word in UNITS["length"]]
            return header.index(name), units[0] if units else "m"
        letter = "xy"[axis]
        named = {index: words for index, name in enumerate(header) if (words := _words(name))[0] == letter}
        known = {index: words for index, words in named.items() if len(words) == 1 or words[1] in UNITS["length"]}
        plain = {index: words for index, words in known.items() if len(words) <= 2}  # of x and x_mm_other, x
        found = plain or known
        if len(found) == 1:
            ((index, words),) = found.items()
            return index, words[1] if len(words) > 1 else "m"
        if found:
            names = ", ".join(clean(header[index]) for index in found)
            self._fault(line, "", f"has several columns for {letter}: {names}; choose with --columns X,Y")
        elif named:
            allowed = ", ".join([letter, *(f"{letter}_{unit}" for unit in UNITS["length"])])
            self._fault(line, clean(header[next(iter(named))]), f"has no known unit of length; allowed are {allowed}")
        else:
            self._fault(line, "", f"has no column for {letter}, it has {_listed(header)}; {FORMAT}")
        return None

    def _gather(
        self, rows: list[tuple[int, list[str]]], header: list[str], places: tuple[tuple[int, str], ...]
    ) -> dict[str, _Rows]:
        """The rows by crack; a row with a fault is left out."""
        cracks: dict[str, _Rows] = {}
        for line, cells in rows:
            if len(cells) != len(header):
                self._fault(line, "", f"has {len(cells)} values, the header has {len(header)}")
                continue
            x, y = (self._number(line, header[index], cells[index], unit) for index, unit in places)
            named = dict(zip(header, cells, strict=True))
            crack = cracks.setdefault(named.get("crack", ""), _Rows(line))
            step = self._step(line, named["step"]) if "step" in named else 0
            self._check_vertex(line, named, crack)
            if x is not None and y is not None and step is not None:
                crack.points.append((x, y))
                crack.steps.append(step)
        return cracks

    def _number(self, line: int, key: str, text: str, unit: str) -> float | None:
        try:
            return parse_quantity(text, "length", Units(length=unit))
        except QuantityError as error:
            self._fault(line, key, f"{quoted(text)} {error}; allowed is a length, in {unit} where it has no unit")
            return None

    def _step(self, line: int, text: str) -> int | None:
        if re.fullmatch(r"[0-9]{1,9}", text):
            return int(text)
        self._fault(line, "step", f"{quoted(text)} is no step; allowed are 0, of the given crack, and 1, 2, ...")
        return None

    def _check_vertex(self, line: int, named: dict[str, str], crack: _Rows) -> None:
        if "vertex" not in named:
            return
        text = named["vertex"]
        try:
            vertex = parse_number(text)
        except QuantityError as error:
            self._fault(line, "vertex", f"{quoted(text)} {error}; allowed are numbers that rise along a crack")
            return
        if vertex <= crack.vertex:
            after = f"{quoted(text)} comes after {crack.vertex:g}"
            self._fault(line, "vertex", f"{after}; allowed are numbers that rise along a crack")
        crack.vertex = vertex

    def _line(self, name: str, rows: _Rows, with_steps: bool) -> PathLine | None:
        """The crack of its rows, points that repeat the one before left out; None with a fault."""
        points, steps = np.array(rows.points), np.array(rows.steps, dtype=np.int64)
        moves = np.concatenate([[True], np.any(np.diff(points, axis=0) != 0, axis=1)])
        points, steps = points[moves], steps[moves]
        key = f"crack {clean(name)}" if name else ""
        if not 2 <= len(points) <= MOST_VERTICES:
            self._fault(rows.line, key, f"has {len(points)} different points; allowed are 2 to {MOST_VERTICES} a crack")
            return None
        points.flags.writeable = steps.flags.writeable = False
        line = PathLine(points, steps if with_steps else None)
        first = np.flatnonzero(line.first)
        # what starts in the run is a segment at once, where a tip adds one vertex
        if with_steps and ((len(first) < 2 and steps.min() > 0) or first[-1] - first[0] >= len(first)):
            told = "its vertices of step 0, the given crack, must be there and follow each other"
            self._fault(rows.line, key, f"{told}; so must two or more of its first step, of one that a run started")
            return None
        return line

    def _fault(self, line: int, key: str, message: str) -> None:
        self._faults.append(Fault(self._source, line, key, message))

    def _raise_faults(self) -> None:
        if self._faults:
            raise self._error()

    def _error(self) -> CaseError:
        n_more = len(self._faults) - MOST_FAULTS
        more = [Fault(self._source, None, "", f"and {n_more} more faults")] if n_more > 0 else []
        return CaseError([*self._faults[:MOST_FAULTS], *more])


def _words(name: str) -> list[str]:
    """The words of a column's name: x_mm, x [mm] and x (mm) are x and mm."""
    words = [word for word in re.split(r"[\s_\[\]()]+", name.strip()) if word]
    return [words[0].lower(), *words[1:]] if words else [""]


def _listed(header: Sequence[str]) -> str:
    return clean(", ".join(header)) or "none"
