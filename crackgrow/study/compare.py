"""How far apart the crack paths of two runs are, or of a run and a reference: crack by crack and tip by tip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.case.units import QuantityError, Units, parse_quantity
from crackgrow.errors import CaseError, Fault
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.results.folder import RunFolder
from crackgrow.study.distance import between, farthest, frechet, nearest, overhang, point_at
from crackgrow.study.path_files import PathLine, PathSet, Tip, read_paths

Part = Literal["given", "start", "end", "path"]  # "path": of a file that doesn't tell what has grown

SLACK = 1e-9  # of a length: a point so close behind a vertex is at it


class Place(NamedTuple):
    """A point of a path."""

    x: float  # m
    y: float  # m
    s: float  # m, arc length from the part's root (of a tip), from the start otherwise
    step: int | None  # whose advance made the segment; 0 in the given crack, None if not told


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """How far apart two lines are, or parts of them that run side by side."""

    length_a: float  # m
    length_b: float  # m
    hausdorff: float  # m, largest distance of a point of either from the other
    frechet: float  # m, the same in the order of the paths, which is at least as large: held against a tolerance
    in_a: Place  # where the Hausdorff distance is
    in_b: Place
    ends: Floats  # (2, 2) m, where the line begins and ends in A


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """One part of one crack in both path sets."""

    crack: str
    part: Part
    length_a: float  # m
    length_b: float  # m
    whole: Deviation | None  # of the whole lengths; None where a file may hold a part of the path only
    end_distance: float | None  # m, between the tips; None like `whole`
    common: (
        Deviation | None
    )  # without what goes on beyond the other's end; None where A or B is given, or has not grown

    @property
    def deviation(self) -> Deviation:
        """What counts: of the whole lengths, or of the common part where no more is known."""
        counts = self.whole or self.common
        assert counts is not None  # a pair has one of them
        return counts

    @property
    def name(self) -> str:
        """The crack and its part, for messages."""
        return f"{self.crack} {self.part}".strip()


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """All that is told of two path sets."""

    a: PathSet
    b: PathSet
    pairs: tuple[Pair, ...]
    only_in_a: tuple[str, ...]  # cracks
    only_in_b: tuple[str, ...]
    tolerance: float | None  # m

    @property
    def in_one_only(self) -> tuple[tuple[str, str], ...]:
        """Cracks that A or B alone has: (crack, "A" or "B")."""
        return (*((crack, "A") for crack in self.only_in_a), *((crack, "B") for crack in self.only_in_b))

    @property
    def beyond(self) -> tuple[Pair, ...]:
        """Pairs further apart than the tolerance; none without one."""
        if self.tolerance is None:
            return ()
        return tuple(pair for pair in self.pairs if pair.deviation.frechet > self.tolerance)

    @property
    def agrees(self) -> bool:
        """Whether all is within the tolerance, and no crack in one alone; true without a tolerance."""
        return self.tolerance is None or not (self.beyond or self.in_one_only)


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
        along, steps = arc_lengths(self.line.points), self.line.steps
        after = min(int(np.searchsorted(along, at - SLACK * along[-1])), len(along) - 1)
        step = None if steps is None else int(steps[max(after - 1, 0) : after + 1].max())
        x, y = point_at(self.line.points, np.array([at]))[0].tolist()
        return Place(x, y, at, step)


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
    in_a, in_b = _chosen(set_a, set_b, crack)
    shared = [name for name in in_a if name in in_b]
    pairs = [pair for name in shared for pair in _pairs(name, in_a[name], in_b[name], tip)]
    if tip is not None and shared and not pairs:
        raise CaseError.at("--tip", f"the {tip} has not grown in {a} nor in {b}")
    only_a, only_b = (tuple(name for name in own if name not in shared) for own in (in_a, in_b))
    return Comparison(set_a, set_b, tuple(pairs), only_a, only_b, limit)


def compared_growth(a: Path, b: Path) -> list[Pair]:
    """Compare what each crack of two result folders has grown at tips that grew in one of them at least.

    The list is empty where a folder has no cracks. Raises CaseError where paths can't be read.
    """
    if not all(RunFolder(folder).n_rows("paths") for folder in (a, b)):
        return []
    return [pair for pair in compare_paths(a, b).pairs if pair.part in ("start", "end")]


def _tolerance(given: str | float | None, faults: list[Fault]) -> float | None:
    """A length in m, if one is given; what is wrong with it goes to the faults."""
    if given is None:
        return None
    try:
        value = parse_quantity(str(given), "length", Units())
        wrong = "is negative; allowed is a length from 0 on" if value < 0 else ""
    except QuantityError as error:
        value, wrong = 0.0, f"{error}; allowed is a length: '0.15 mm', or in m"
    if wrong:
        faults.append(Fault("--tolerance", None, "", f"{quoted(str(given))} {wrong}"))
    return value


def _chosen(a: PathSet, b: PathSet, crack: str | None) -> tuple[dict[str, PathLine], dict[str, PathLine]]:
    """The cracks to compare, by name, of both; a nameless one takes the other's."""
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
    named = [{name or nameless: line for name, line in paths.cracks.items()} for paths in (a, b)]
    in_a, in_b = ({name: line for name, line in own.items() if crack in (None, name)} for own in named)
    return in_a, in_b


def _pairs(name: str, a: PathLine, b: PathLine, tip: Tip | None) -> list[Pair]:
    """The crack as it began and the tips that have grown, or the whole path where a file doesn't tell them apart."""
    if a.steps is None or b.steps is None:
        return [_partial(name, a, b, tip)]
    pairs = []
    if tip is None:
        given_a, given_b = a.given, b.given
        whole = _deviation(_all(given_a), _all(given_b))
        ends = max(_apart(given_a.points[end], given_b.points[end]) for end in (0, -1))
        pairs.append(Pair(name, "given", given_a.length, given_b.length, whole, ends, None))
    tips: tuple[Tip, ...] = ("start", "end") if tip is None else (tip,)
    for which in tips:
        wing_a, wing_b, common = a.wing(which), b.wing(which), None
        ends = _apart(wing_a.points[-1], wing_b.points[-1])
        if wing_a.length > 0.0 and wing_b.length > 0.0:  # what they have in common begins at the roots
            s_a = overhang(wing_a.points, wing_b.points, at_both=False) or wing_a.length
            s_b = overhang(wing_b.points, wing_a.points, at_both=False) or wing_b.length
            common = _deviation(_Stretch(wing_a, 0.0, s_a), _Stretch(wing_b, 0.0, s_b))
        if wing_a.length > 0.0 or wing_b.length > 0.0:
            whole = _deviation(_all(wing_a), _all(wing_b))
            pairs.append(Pair(name, which, wing_a.length, wing_b.length, whole, ends, common))
    return pairs


def _partial(name: str, a: PathLine, b: PathLine, tip: Tip | None) -> Pair:
    """Paths of which one is not known to be whole: the part that they have in common."""
    if tip is not None:
        if a.steps is None and b.steps is None:
            raise CaseError.at("--tip", "neither path has the column step, which tells what has grown")
        a, b = (line if line.steps is None else line.wing(tip) for line in (a, b))
        if min(len(a.points), len(b.points)) < 2:
            raise CaseError.at("--tip", f"the {tip} of crack {quoted(name)} has not grown")
    if (a.steps is None, -a.length) > (b.steps is None, -b.length):  # a is the one of unknown extent, or shorter
        on_b, on_a = _side_by_side(b, a)
    else:
        on_a, on_b = _side_by_side(a, b)
    return Pair(name, tip or "path", a.length, b.length, None, None, _deviation(on_a, on_b))


def _side_by_side(path: PathLine, reference: PathLine) -> tuple[_Stretch, _Stretch]:
    """Where a path and a reference, drawn in either direction, run side by side; all of both if they do nowhere."""
    length = reference.length
    high = overhang(reference.points, path.points, at_both=True)
    low = length - overhang(reference.points[::-1], path.points, at_both=True)
    _, ends = nearest(point_at(reference.points, np.array([low, high])), path.points)
    if low >= high or ends[0] == ends[1]:
        return _all(path), _all(reference)
    return _Stretch(path, float(ends[0]), float(ends[1])), _Stretch(reference, low, high)


def _deviation(a: _Stretch, b: _Stretch) -> Deviation:
    (from_a, s_a, near_b), (from_b, s_b, near_a) = farthest(a.points, b.points), farthest(b.points, a.points)
    in_a, in_b = (a.place(s_a), b.place(near_b)) if from_a >= from_b else (a.place(near_a), b.place(s_b))
    hausdorff = max(from_a, from_b)
    leash = max(hausdorff, frechet(a.points, b.points))
    return Deviation(a.length, b.length, hausdorff, leash, in_a, in_b, a.points[[0, -1]])


def _all(line: PathLine) -> _Stretch:
    return _Stretch(line, 0.0, line.length)


def _apart(p: Floats, q: Floats) -> float:
    return float(np.hypot(*(p - q)))
