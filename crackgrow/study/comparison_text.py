"""A comparison as text for people and as CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from crackgrow.case.dump import differing
from crackgrow.results.declarations import columns_of, declared
from crackgrow.results.tables import Value, csv_text
from crackgrow.results.units import aligned, cut
from crackgrow.study.compare import Comparison, Pair
from crackgrow.study.path_files import PathSet

UNEQUAL = 1e-3  # of the longer length: lengths further apart are told as unequal growth
MOST_SETTINGS = 20  # that differ and are printed
MOST_MILLIMETRES = 1.0  # m, of the longest part: from there on lengths are printed in m
HEADINGS = ("crack", "part", "length A", "length B", "Hausdorff", "Frechet", "ends apart",
            "worst at, in A", "along", "step", "in B", "along", "step")  # fmt: skip
N_WORDS = 2  # columns of words come first, left-aligned
N_PLACES = 6  # columns of places come last
(CSV,) = declared(columns_of("study")["compare"])
CSV_COLUMNS: Final = CSV.header


def comparison_text(comparison: Comparison) -> str:
    """Lines of text: what is compared, settings that differ, the table, remarks, the largest deviation, the verdict."""
    lengths = [length for pair in comparison.pairs for length in (pair.length_a, pair.length_b)]
    show = _Lengths(max(lengths, default=0.0))
    lines = [_source_line("A", comparison.a), _source_line("B", comparison.b), *_settings_lines(comparison)]
    if comparison.pairs:
        rows = [HEADINGS, *(_cells(pair, show) for pair in comparison.pairs)]
        lines += [f"lengths in {show.unit}", *aligned(rows, N_WORDS)]
        lines += [line for pair in comparison.pairs for line in _remarks(pair, comparison, show)]
    lines += [f"crack {crack}: only in {name}" for crack, name in comparison.in_one_only]
    if comparison.pairs:
        lines.append(_largest_line(comparison.pairs, show))
    return "\n".join([*lines, *_verdict_lines(comparison, show)])


def comparison_csv(comparison: Comparison) -> str:
    """A row for each part of each crack, SI; empty where there is no value; a row for each crack that one alone has."""
    beyond = comparison.beyond
    judged = comparison.tolerance is not None
    rows: list[Sequence[Value | None]] = [
        (*_pair_values(pair), ("beyond" if pair in beyond else "within") if judged else "") for pair in comparison.pairs
    ]
    blank = [None] * (len(CSV_COLUMNS) - 3)
    rows += [(crack, f"only in {name}", *blank, "beyond" if judged else "") for crack, name in comparison.in_one_only]
    return csv_text(CSV_COLUMNS, rows)


def comparison_record(comparison: Comparison) -> dict[str, object]:
    """All of it in what JSON can hold, SI: the rows of the CSV with null where there is no value."""
    beyond = comparison.beyond
    rows = [
        {**dict(zip(CSV_COLUMNS, _pair_values(pair), strict=False)), "beyond": pair in beyond}
        for pair in comparison.pairs
    ]
    a, b = comparison.a.settings or {}, comparison.b.settings or {}
    return {
        "a": {"source": str(comparison.a.source), "status": comparison.a.status},
        "b": {"source": str(comparison.b.source), "status": comparison.b.status},
        "settings": {key: {"a": mine, "b": its} for key, (mine, its) in differing(a, b, None).items()},
        "tolerance": comparison.tolerance,
        "agrees": comparison.agrees,
        "parts": rows,
        "only_in_a": list(comparison.only_in_a),
        "only_in_b": list(comparison.only_in_b),
    }


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


def _source_line(name: str, paths: PathSet) -> str:
    return f"{name}  {paths.source}{f': {paths.status}' if paths.status else ''}"


def _settings_lines(comparison: Comparison) -> list[str]:
    a, b = comparison.a.settings, comparison.b.settings
    if a is None or b is None:
        return []
    lines = [f"  {key}: {mine} | {its}" for key, (mine, its) in differing(a, b, "not given").items()]
    if not lines:
        return ["same settings"]
    return ["settings that differ, A | B:", *cut(lines, MOST_SETTINGS, "  and {} more")]


def _cells(pair: Pair, show: _Lengths) -> list[str]:
    deviation = pair.deviation
    lengths = (pair.length_a, pair.length_b, deviation.hausdorff, deviation.frechet, pair.end_distance)
    cells = [pair.crack or "-", pair.part, *("-" if length is None else show.bare(length) for length in lengths)]
    for x, y, s, step in (deviation.in_a, deviation.in_b):
        cells += [show.point((x, y)), show.bare(s), "-" if step is None else str(step)]
    return cells if deviation.hausdorff > 0.0 else [*cells[:-N_PLACES], *N_PLACES * "-"]


def _pair_values(pair: Pair) -> tuple[Value | None, ...]:
    """The values of CSV_COLUMNS up to the verdict; None where there is none."""
    whole, common = pair.whole, pair.common
    distances = (whole.hausdorff, whole.frechet) if whole else (None, None)
    shared = (common.length_a, common.length_b, common.hausdorff, common.frechet) if common else 4 * (None,)
    places = (*pair.deviation.in_a, *pair.deviation.in_b)
    return (
        pair.crack or None,
        pair.part,
        pair.length_a,
        pair.length_b,
        *distances,
        pair.end_distance,
        *places,
        *shared,
    )


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
        judged = ": the same path so far" if common.largest <= comparison.tolerance else ": another path"
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


def _verdict_lines(comparison: Comparison, show: _Lengths) -> list[str]:
    if comparison.tolerance is None:
        return []
    if comparison.agrees:
        return [f"within the tolerance of {show(comparison.tolerance)}"]
    parts = [f"{pair.name} ({show(pair.deviation.largest)})" for pair in comparison.beyond]
    parts += [f"{crack} (only in {name})" for crack, name in comparison.in_one_only]
    return [f"beyond the tolerance of {show(comparison.tolerance)}: {', '.join(parts)}"]
