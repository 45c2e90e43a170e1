"""The picture of a trade: what each setting misses, and its memory, over the CPU seconds that it takes."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from crackgrow.results.atomic import write_atomically
from crackgrow.results.style import own_style, wrapped
from crackgrow.study.findings import Findings
from crackgrow.study.table import Table

PANEL = (4.0, 3.4)  # inches
DPI = 130
ROOM = (0.35, 0.15)  # of the decades of the axes, round the points and their names
OWN, OTHER, INCREMENT = "tab:red", "tab:blue", "tab:green"


@own_style()
def draw(path: Path, found: Findings, table: Table) -> None:
    """Draw a panel for each number that any setting has into a PNG. Raises OutputError."""
    panels = {
        "off, %": ("error", 100.0, 100.0 * found.plan.tolerance),
        "path off, % of what has grown": ("path_share", 100.0, 100.0 * found.path_tolerance),
        "memory, MB": ("peak_memory_mb", 1.0, math.nan),
    }
    rows = [table.row(run) for run in found.plan.study.runs]
    known = {title: what for title, what in panels.items() if any(_number(row.get(what[0])) > 0.0 for row in rows)}
    figure = Figure(figsize=(len(known) * PANEL[0], PANEL[1]), layout="constrained")
    drawn = figure.subplots(1, len(known), squeeze=False)[0]
    for axes, (title, (column, scale, allowed)) in zip(drawn, known.items(), strict=True):
        points = [(str(row["setting"]), _number(row["cpu_seconds"]), scale * _number(row.get(column))) for row in rows]
        _panel(axes, found, [point for point in points if point[2] > 0.0], allowed)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("CPU seconds of the run", fontsize=8)
    figure.suptitle(wrapped(found.plan.study.title, figure), fontsize=10)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _panel(axes: Axes, found: Findings, points: list[tuple[str, float, float]], allowed: float) -> None:
    """Points (name, seconds, value) on logarithmic scales, those of settings with a line through them."""
    plan = found.plan
    line = [point for point in points if point[0] in plan.settings]
    axes.plot([x for _, x, _ in line], [y for *_, y in line], color=OTHER, linewidth=0.8, zorder=0)
    for name, x, y in points:
        colour = OWN if name == plan.own else INCREMENT if name in plan.increments else OTHER
        axes.plot(x, y, marker="s" if name in plan.increments else "o", color=colour, linestyle="")
        axes.annotate(
            name, (x, y), (5, 5 if name == plan.own else -11), textcoords="offset points", fontsize=7, color=colour
        )
    if math.isfinite(allowed):
        axes.axhline(allowed, color="0.4", linestyle="--", linewidth=0.8)
        axes.annotate("asked for", (0.01, allowed), (0, 2), xycoords=("axes fraction", "data"), fontsize=7,
                      textcoords="offset points", color="0.4")  # fmt: skip
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(LogFormatter(labelOnlyBase=False))
    axes.margins(*ROOM)
    axes.tick_params(labelsize=7, which="both")
    axes.grid(color="0.9", which="both")


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan
