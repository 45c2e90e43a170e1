"""A comparison as text for people and as CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from crackgrow.case.dump import differing
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.tables import Value, csv_text
from crackgrow.results.units import aligned, cut
from crackgrow.study.compare import Comparison, Pair

UNEQUAL = 1e-3  # of the longer length: lengths further apart are told as unequal growth
MOST_SETTINGS = 20  # that differ and are printed
MOST_MILLIMETRES = 1.0  # m, of the longest part: from there on lengths are printed in m
HEADINGS = ("crack", "part", "length A", "length B", "Hausdorff", "Frechet", "ends apart",
            "worst at, in A", "along", "step", "in B", "along", "step")  # fmt: skip
N_WORDS = 2  # columns of words come first, left-aligned
N_PLACES = 6  # columns of places come last
CSV_COLUMNS: Final = declared(columns_of("study")["compare"])[0].header
BEYOND: Final = "beyond"  # the tolerance


def comparison_text(comparison: Comparison) -> str:
    """Lines of text: what is compared, settings that differ, the table, remarks, the largest deviation, the verdict."""
    lengths = [length for pair in comparison.pairs for length in (pair.length_a, pair.length_b)]
    show = _Lengths(max(lengths, default=0.0))
    sources = (("A", comparison.a), ("B", comparison.b))
    lines = [f"{name}  {paths.source}{f': {paths.status}' if paths.status else ''}" for name, paths in sources]
    a, b = comparison.a.settings, comparison.b.settings
    if a is not None and b is not None:
        differ = [f"  {key}: {mine} | {its}" for key, (mine, its) in differing(a, b, "not given").items()]
        told = ["settings that differ, A | B:", *cut(differ, MOST_SETTINGS, "  and {} more")]
        lines += told if differ else ["same settings"]
    if comparison.pairs:
        rows = [HEADINGS, *(_cells(pair, show) for pair in comparison.pairs)]
        lines += [f"lengths in {show.unit}", *aligned(rows, N_WORDS)]
        lines += [line for pair in comparison.pairs for line in _remarks(pair, comparison, show)]
    lines += [f"crack {crack}: only in {name}" for crack, name in comparison.in_one_only]
    if comparison.pairs:
        lines.append(_largest_line(comparison.pairs, show))
    if comparison.tolerance is not None:
        apart = [f"{pair.name} ({show(pair.deviation.frechet)})" for pair in comparison.beyond]
        apart += [f"{crack} (only in {name})" for crack, name in comparison.in_one_only]
        allowed = f"the tolerance of {show(comparison.tolerance)}"
        lines.append(f"beyond {allowed}: {', '.join(apart)}" if apart else f"within {allowed}")
    return "\n".join(lines)


def comparison_csv(comparison: Comparison) -> str:
    """A row for each part of each crack, SI; empty where there is no value; a row for each crack that one alone has."""
    rows = [_row(pair, comparison) for pair in comparison.pairs]
    verdict = "" if comparison.tolerance is None else BEYOND
    for crack, name in comparison.in_one_only:
        rows.append([crack, f"only in {name}", *(None for _ in CSV_COLUMNS[3:]), verdict])
    return csv_text(CSV_COLUMNS, rows)


def comparison_record(comparison: Comparison) -> dict[str, object]:
    """All of it in what JSON can hold, SI: the rows of the CSV with null where there is no value."""
    a, b = comparison.a.settings or {}, comparison.b.settings or {}
    rows = [_row(pair, comparison) for pair in comparison.pairs]
    return {
        "a": {"source": str(comparison.a.source), "status": comparison.a.status},
        "b": {"source": str(comparison.b.source), "status": comparison.b.status},
        "settings": {key: {"a": mine, "b": its} for key, (mine, its) in differing(a, b, None).items()},
        "tolerance": comparison.tolerance,
        "agrees": comparison.agrees,
        "parts": [{**dict(zip(CSV_COLUMNS[:-1], row, strict=False)), "beyond": row[-1] == BEYOND} for row in rows],
        "only_in_a": list(comparison.only_in_a),
        "only_in_b": list(comparison.only_in_b),
    }


def _row(pair: Pair, comparison: Comparison) -> list[Value | None]:
    """The values of CSV_COLUMNS; None where there is none."""
    whole, common = pair.whole, pair.common
    distances = (whole.hausdorff, whole.frechet) if whole else (None, None)
    shared = (common.length_a, common.length_b, common.hausdorff, common.frechet) if common else 4 * (None,)
    places = (*pair.deviation.in_a, *pair.deviation.in_b)
    lengths = (pair.length_a, pair.length_b, *distances, pair.end_distance)
    verdict = "" if comparison.tolerance is None else BEYOND if pair in comparison.beyond else "within"
    return [pair.crack or None, pair.part, *lengths, *places, *shared, verdict]


class _Lengths:
    """Writes lengths in mm, or in m where they are large."""

    def __init__(self, largest: float) -> None:
        self._scale, self.unit = (1e3, "mm") if largest < MOST_MILLIMETRES else (1.0, "m")

    def bare(self, value: float) -> str:
        scaled = value * self._scale
        return f"{scaled:.3f}" if scaled == 0 or abs(scaled) >= 0.0005 else f"{scaled:.0e}"

    def __call__(self, value: float) -> str:
        return f"{self.bare(value)} {self.unit}"

    def point(self, point: Iterable[float]) -> str:
        return f"({', '.join(self.bare(float(value)) for value in point)})"


def _cells(pair: Pair, show: _Lengths) -> list[str]:
    deviation = pair.deviation
    lengths = (pair.length_a, pair.length_b, deviation.hausdorff, deviation.frechet, pair.end_distance)
    cells = [pair.crack or "-", pair.part, *("-" if length is None else show.bare(length) for length in lengths)]
    for x, y, s, step in (deviation.in_a, deviation.in_b):
        cells += [show.point((x, y)), show.bare(s), "-" if step is None else str(step)]
    return cells if deviation.hausdorff > 0.0 else [*cells[:-N_PLACES], *N_PLACES * "-"]


def _remarks(pair: Pair, comparison: Comparison, show: _Lengths) -> list[str]:
    """What was compared where it isn't all, and whether the one path only goes further than the other."""
    common = pair.common
    if pair.whole is None and common is not None:
        begin, end = (show.point(point) for point in common.ends)
        return [
            f"{pair.name}: compared {show(common.length_a)} of A, from {begin} to {end}, "
            f"with {show(common.length_b)} of B: the part that both have"
        ]
    ahead = pair.length_b - pair.length_a
    if pair.part == "given" or abs(ahead) <= UNEQUAL * max(pair.length_a, pair.length_b):
        return []
    further = f"{pair.name}: {'B' if ahead > 0 else 'A'} has grown {show(abs(ahead))} further"
    if common is None:
        return [f"{further}, the other not at all"]
    judged = ""
    if comparison.tolerance is not None:
        judged = ": the same path so far" if common.frechet <= comparison.tolerance else ": another path"
    return [
        f"{further}; over the common part, {show(common.length_a)} of A, "
        f"Hausdorff {show(common.hausdorff)}, Frechet {show(common.frechet)}{judged}"
    ]


def _largest_line(pairs: Sequence[Pair], show: _Lengths) -> str:
    worst = max(pairs, key=lambda pair: pair.deviation.hausdorff)
    deviation = worst.deviation
    in_a, in_b = show.point(deviation.in_a[:2]), show.point(deviation.in_b[:2])
    place = f", {worst.name}: {in_a} in A, {in_b} in B" if deviation.hausdorff > 0.0 else ""
    frechet = max(pair.deviation.frechet for pair in pairs)
    return f"largest: Hausdorff {show(deviation.hausdorff)}, Frechet {show(frechet)}{place}"
