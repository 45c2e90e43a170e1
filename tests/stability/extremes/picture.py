"""The rows as a picture: a panel an axis, deviations beside their tolerances on a logarithmic scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from crackgrow.results.atomic import write_atomically
from crackgrow.results.style import own_style
from tests.stability.extremes.trial import Row

COLOURS = {"yes": "tab:green", "said": "tab:orange", "NO": "tab:red"}
LABELS = {"yes": "good", "said": "no good, and the program says so", "NO": "NO"}
ACROSS = 4  # panels
PANEL = (3.6, 2.5)  # inches
LOWEST, HIGHEST = 1e-15, 1e2  # of the deviations drawn; refused ones lie at the top
DPI = 130


@own_style(math=True)
def draw(path: Path, rows: Sequence[Row]) -> None:
    """Draw all axes into a PNG. Raises OutputError."""
    groups = [(axis, list(group)) for axis, group in groupby(rows, key=lambda row: row.axis)]
    across = min(ACROSS, len(groups))
    down = math.ceil(len(groups) / across)
    figure = Figure(figsize=(across * PANEL[0], down * PANEL[1] + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(down, across, squeeze=False, sharey=True).ravel()
    for axes, (axis, mine) in zip(panels, groups, strict=False):
        _panel(axes, axis, mine)
    for axes in panels[len(groups) :]:
        axes.set_axis_off()
    marks = [Line2D([], [], color=COLOURS[v], marker="o", linestyle="", label=LABELS[v]) for v in COLOURS]
    marks.append(Line2D([], [], color="0.5", marker="x", linestyle="", label="refused, or without a number"))
    marks.append(Line2D([], [], color="0.3", marker="_", linestyle="", label="tolerance"))
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), frameon=False)
    figure.supylabel("relative deviation")
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _panel(axes: Axes, axis: str, rows: Sequence[Row]) -> None:
    for place, row in enumerate(rows):
        known = math.isfinite(row.deviation)
        height = min(max(row.deviation, LOWEST), HIGHEST) if known else HIGHEST
        axes.plot(place, height, marker="o" if known else "x", color=COLOURS[row.verdict], markersize=5)
        axes.plot(place, row.tolerance, marker="_", color="0.3", markersize=9)
    axes.set_yscale("log")
    axes.set_ylim(0.3 * LOWEST, 3.0 * HIGHEST)
    axes.set_title(axis, fontsize=9)
    values = [row.value for row in rows]
    axes.set_xticks(range(len(rows)), values, rotation=55, ha="right", fontsize=5.5, parse_math=False)
    axes.tick_params(axis="y", labelsize=7)
    axes.grid(axis="y", color="0.9")
