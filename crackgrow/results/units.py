"""Numbers, units and tables as people read them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.case.model import Component

LENGTHS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))
STRESSES = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
INTENSITIES = tuple((size, f"{name}√m") for size, name in STRESSES)
ENERGIES = ((1e3, "kJ/m"), (1.0, "J/m"), (1e-3, "mJ/m"), (1e-6, "µJ/m"))
TIMES = ((31557600.0, "years"), (86400.0, "days"), (3600.0, "h"), (1.0, "s"), (1e-3, "ms"), (1e-6, "µs"))
FORCES = ((1e6, "MN/m"), (1e3, "kN/m"), (1.0, "N/m"))

NO_NUMBER = "\N{EN DASH}"
LONGEST = 60  # signs of a formula that are shown
SIGNIFICANT = 6  # digits of what is drawn and shown; the tables of the run have all

Unit = tuple[float, str]
"""Size in SI units, and name."""


def unit_of(values: Iterable[float], units: Sequence[Unit]) -> Unit:
    """The largest of `units` (from large to small) in which the largest of the values is at least 1, else the last."""
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return next((unit for unit in units if largest >= 0.9999 * unit[0]), units[-1])


def rounded_all(values: Iterable[float], unit: float = 1.0) -> list[float | None]:
    """Values in a unit of this size, to SIGNIFICANT digits; None where one is no number."""
    parts = (float(value) / unit for value in values)
    return [float(f"{part:.{SIGNIFICANT}g}") if math.isfinite(part) else None for part in parts]


def merged(spans: Iterable[range]) -> list[range]:
    """Ranges of steps in order, as one where they touch or overlap."""
    found: list[range] = []
    for span in sorted(spans, key=lambda span: span.start):
        if found and span.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, span.stop))
        else:
            found.append(span)
    return found


def spans_text(spans: Iterable[range]) -> str:
    """Ranges in words: 0 to 5, 7."""
    return ", ".join(f"{span[0]} to {span[-1]}" if len(span) > 1 else str(span[0]) for span in merged(spans))


def factor_text(factor: float) -> str:
    """A factor to three digits, without an exponent up to a million: 5500."""
    return f"{float(f'{factor:.3g}'):g}"


def shown(value: float, digits: int = 4) -> str:
    """A number as a reader sees it; a dash where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else NO_NUMBER


def stress_text(value: float) -> str:
    """A stress (Pa) in the unit that suits its size."""
    if abs(value) >= 1e9:
        return f"{value / 1e9:g} GPa"
    return f"{value:g} Pa" if 0.0 < abs(value) < 1e4 else f"{value / 1e6:g} MPa"


def component_text(value: Component) -> str:
    """A stress (Pa), or the formula that it follows, with its begin alone where it is long."""
    from crackgrow.case.formula import CoordinateFormula  # only now: it loads numpy

    if isinstance(value, CoordinateFormula):
        size, text = value.scaled
        unit = next((name for unit, name in STRESSES if unit == size), None)
        text, unit = (text, unit) if unit else (value.text, "Pa")
        return f"{text if len(text) <= LONGEST else f'{text[:LONGEST]}...'} [{unit}]"
    return "by a formula" if callable(value) else stress_text(value)


def duration(seconds: float, digits: int = 0) -> str:
    """A time as people say it: "12 s", "3 min 20 s", "2 h 5 min"; a short one with so many digits."""
    whole = round(seconds)
    minutes, hours = whole // 60, whole // 3600
    if hours:
        return f"{hours} h {minutes % 60} min"
    if seconds >= 90.0 or (minutes and not digits):
        return f"{minutes} min {whole % 60} s"
    return f"{seconds:.{digits}g} s" if digits else f"{whole} s"


def memory_text(size: float) -> str:
    """A size (MiB) of a memory."""
    return f"{size:.0f} MiB" if size < 1000.0 else f"{size / 1024.0:.2g} GiB"


def counted(n: object, thing: str) -> str:
    """A number of things in words: "1 run", "2 runs"."""
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"


def cut(texts: Sequence[str], most: int, more: str) -> list[str]:
    """The first of some texts; behind them, where there are others, how many: `more` with their number for {}."""
    left = len(texts) - most
    return [*texts[:most], *([more.format(left)] if left > 0 else [])]


def or_null(value: Any) -> Any:
    """A value as JSON can hold it: None in place of a number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def aligned(rows: Iterable[Sequence[str]], n_left: int, before: str = "") -> list[str]:
    """Rows of cells as lines of one table; the first columns, which hold words, begin on the left."""
    columns = list(zip(*rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    padded = [
        [cell.ljust(width) if number < n_left else cell.rjust(width) for cell in column]
        for number, (column, width) in enumerate(zip(columns, widths, strict=True))
    ]
    return [before + "  ".join(row).rstrip() for row in zip(*padded, strict=True)]
