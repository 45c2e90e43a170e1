"""How far apart the crack paths of two runs are, or of a run and a reference: crack by crack and tip by tip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import QuantityError, Units, parse_quantity
from crackgrow.errors import CaseError, Fault
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.study.comparison import Common, Comparison, Deviation, Pair, Place, Tip
from crackgrow.study.distance import between, farthest, frechet, nearest, overhang, point_at
from crackgrow.study.path_files import PathLine, PathSet, read_paths

SLACK = 1e-9  # of a length: a point so close behind a vertex is at it


@dataclass(frozen=True, slots=True, eq=False)
class _Stretch:
    """A line from one arc length to another; backwards where the second is less."""

    line: PathLine
    s_from: float  # m
    s_to: float  # m

    @property
    def points(self) -> Floats:
        return between(self.line.points, self.s_from, self.s_to)

    @property
    def length(self) -> float:
        return abs(self.s_to - self.s_from)

    def place(self, s: float) -> Place:
        """The point at an arc length from where the stretch begins; its step made the younger end of its segment."""
        at = self.s_from + (s if self.s_to >= self.s_from else -s)
        along = arc_lengths(self.line.points)
        step = None
        if self.line.steps is not None:
            after = min(int(np.searchsorted(along, at - SLACK * along[-1])), len(along) - 1)
            step = int(self.line.steps[max(after - 1, 0) : after + 1].max())
        return Place(point_at(self.line.points, np.array([at]))[0], at, step)


def compare_paths(
    a: str | Path,
    b: str | Path,
    *,
    tolerance: str | float | None = None,
    crack: str | None = None,
    tip: Tip | None = None,
    columns: Sequence[str] | None = None,
) -> Comparison:
    """Compare the crack paths of `a` and `b`, result folders or CSV files.

    `tolerance` is m, or a text with a unit. `crack` and `tip` choose what is compared; `columns` names the columns
    of x and y where a CSV has several. A file without the column step may hold a part of a path: then the common
    part alone counts. Raises CaseError with all faults.
    """
    faults: list[Fault] = []
    limit = _tolerance(tolerance, faults)
    if columns is not None and Path(a).is_dir() and Path(b).is_dir():
        faults.append(Fault("--columns", None, "", "is for a CSV file; both are result folders"))
    sets: list[PathSet] = []
    for source in (a, b):
        try:
            sets.append(read_paths(source, columns))
        except CaseError as error:
            faults.extend(error.faults)
    if faults:
        raise CaseError(list(dict.fromkeys(faults)))
    set_a, set_b = sets
    names_a, names_b = _chosen(set_a, set_b, crack)
    shared = [name for name in names_a if name in names_b]
    pairs: list[Pair] = []
    for name in shared:
        pairs.extend(_pairs(name, set_a.cracks[names_a[name]], set_b.cracks[names_b[name]], tip))
    only_a = tuple(name for name in names_a if name not in names_b)
    only_b = tuple(name for name in names_b if name not in names_a)
    if tip is not None and shared and not pairs:
        raise CaseError.at("--tip", f"the {tip} has not grown in {a} nor in {b}")
    return Comparison(set_a, set_b, tuple(pairs), only_a, only_b, limit)


def _tolerance(given: str | float | None, faults: list[Fault]) -> float | None:
    if given is None:
        return None
    text = str(given)
    try:
        value = parse_quantity(text, "length", Units())
    except QuantityError as error:
        faults.append(
            Fault("--tolerance", None, "", f"{quoted(text)} {error}; allowed is a length: '0.15 mm', or in m")
        )
        return None
    if value < 0:
        faults.append(Fault("--tolerance", None, "", f"{quoted(text)} is negative; allowed is a length from 0 on"))
    return value


def _chosen(a: PathSet, b: PathSet, crack: str | None) -> tuple[dict[str, str], dict[str, str]]:
    """The cracks to compare: name in the comparison to name in the file, of both; a nameless one takes the other's."""
    names = list(dict.fromkeys(name for paths in (a, b) for name in paths.cracks if name))
    if crack is not None and names and crack not in names:
        message = f"no crack {quoted(crack)}{did_you_mean(crack, names)}; there are {', '.join(names)}"
        raise CaseError.at("--crack", message)
    wanted = [crack] if crack is not None else names
    if any("" in paths.cracks for paths in (a, b)) and len(wanted) > 1:
        source = a.source if "" in a.cracks else b.source
        message = f"has no column crack; choose the one to compare with by --crack: {', '.join(names)}"
        raise CaseError.at(source, message)
    nameless = wanted[0] if wanted else ""

    def of(paths: PathSet) -> dict[str, str]:
        own = {name or nameless: name for name in paths.cracks}
        return own if crack is None else {name: key for name, key in own.items() if name == crack}

    return of(a), of(b)


def _pairs(name: str, a: PathLine, b: PathLine, tip: Tip | None) -> list[Pair]:
    """The crack as it began and the tips that have grown, or the whole path where a file doesn't tell them apart."""
    if a.steps is None or b.steps is None:
        return [_partial(name, a, b, tip)]
    pairs = []
    if tip is None:
        given_a, given_b = _given(a), _given(b)
        whole = _deviation(_all(given_a), _all(given_b))
        ends = max(_apart(given_a.points[end], given_b.points[end]) for end in (0, -1))
        pairs.append(Pair(name, "given", _length(given_a), _length(given_b), whole, ends, None))
    tips: tuple[Tip, ...] = ("start", "end") if tip is None else (tip,)
    pairs.extend(
        _grown(name, which, _wing(a, which), _wing(b, which))
        for which in tips
        if len(_wing(a, which).points) > 1 or len(_wing(b, which).points) > 1
    )
    return pairs


def _given(line: PathLine) -> PathLine:
    """The crack as it began."""
    return PathLine(line.points[line.first], _steps(line)[line.first])


def _wing(line: PathLine, tip: Tip) -> PathLine:
    """What has grown at a tip, from its root, the end of the given crack, outward; the root alone if nothing has."""
    steps, points, first = _steps(line), line.points, line.first
    if tip == "start":
        steps, points, first = steps[::-1], points[::-1], first[::-1]
    root = int(np.flatnonzero(first)[-1])
    return PathLine(points[root:], steps[root:])


def _grown(name: str, tip: Tip, a: PathLine, b: PathLine) -> Pair:
    """The wings of a tip; what they have in common begins at the roots."""
    common = None
    if len(a.points) > 1 and len(b.points) > 1:
        s_a = overhang(a.points, b.points, at_both=False) or _length(a)
        s_b = overhang(b.points, a.points, at_both=False) or _length(b)
        common = _common(_Stretch(a, 0.0, s_a), _Stretch(b, 0.0, s_b))
    ends = _apart(a.points[-1], b.points[-1])
    return Pair(name, tip, _length(a), _length(b), _deviation(_all(a), _all(b)), ends, common)


def _partial(name: str, a: PathLine, b: PathLine, tip: Tip | None) -> Pair:
    """Paths of which one is not known to be whole: the part that they have in common."""
    if tip is not None:
        if a.steps is None and b.steps is None:
            raise CaseError.at("--tip", "neither path has the column step, which tells what has grown")
        a, b = (line if line.steps is None else _wing(line, tip) for line in (a, b))
        if min(len(a.points), len(b.points)) < 2:
            raise CaseError.at("--tip", f"the {tip} of crack {quoted(name)} has not grown")
    if (a.steps is None, -_length(a)) > (b.steps is None, -_length(b)):  # a is the one of unknown extent, or shorter
        on_b, on_a = _side_by_side(b, a)
    else:
        on_a, on_b = _side_by_side(a, b)
    return Pair(name, tip or "path", _length(a), _length(b), None, None, _common(on_a, on_b))


def _side_by_side(path: PathLine, reference: PathLine) -> tuple[_Stretch, _Stretch]:
    """Where a path and a reference, drawn in either direction, run side by side; all of both if they do nowhere."""
    length = _length(reference)
    high = overhang(reference.points, path.points, at_both=True)
    low = length - overhang(reference.points[::-1], path.points, at_both=True)
    _, ends = nearest(point_at(reference.points, np.array([low, high])), path.points)
    if low >= high or ends[0] == ends[1]:
        return _all(path), _all(reference)
    return _Stretch(path, float(ends[0]), float(ends[1])), _Stretch(reference, low, high)


def _common(a: _Stretch, b: _Stretch) -> Common:
    return Common(a.length, b.length, a.points[[0, -1]], _deviation(a, b))


def _deviation(a: _Stretch, b: _Stretch) -> Deviation:
    from_a, from_b = farthest(a.points, b.points), farthest(b.points, a.points)
    s_a, s_b = (from_a.s, from_a.near_s) if from_a.distance >= from_b.distance else (from_b.near_s, from_b.s)
    hausdorff = max(from_a.distance, from_b.distance)
    return Deviation(hausdorff, frechet(a.points, b.points), a.place(s_a), b.place(s_b))


def _all(line: PathLine) -> _Stretch:
    return _Stretch(line, 0.0, _length(line))


def _steps(line: PathLine) -> Ints:
    if line.steps is None:
        raise ValueError("the line has no steps")
    return line.steps


def _length(line: PathLine) -> float:
    return float(arc_lengths(line.points)[-1])


def _apart(p: Floats, q: Floats) -> float:
    return float(np.hypot(*(p - q)))
