"""The table as a picture: a panel for each error, over the time, with the Pareto front and the presets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from crackgrow.arrays import Floats, Ints
from crackgrow.results.atomic import write_atomically
from crackgrow.results.style import own_style
from crackgrow.study.trade.columns import ENERGY, ERRORS
from crackgrow.study.trade.row import REFERENCE, Row

TIME = "cpu_seconds"
LABELS = {
    "K_error": "K, relative",
    "K_II_error": "K_II, relative",
    "pressure_error": "contact pressure, relative",
    "shear_error": "contact shear, relative to all tractions",
    "slip_error": "slip, relative",
    "energy_error": "strain energy, relative",
    "true_energy_error": "energy norm, relative",
    "error_estimate": "energy norm as the run estimates it",
    "path_hausdorff": "path, Hausdorff [m]",
    "path_frechet": "path, Frechet [m]",
    "length_error": "grown length [m]",
}
PRESET_COLOUR = "tab:red"
PRESET_MARKS = {"draft": "v", "standard": "s", "fine": "^"}
SUPPORT_MARKS = ("o", "D", "P", "X")  # of the grid's points, by support
ACROSS = 3  # panels
PANEL = (4.0, 3.2)  # inches
LEAST = 1e-12  # of the errors drawn: zero has no place on a logarithmic scale
DPI = 130
COLOURS = colormaps["viridis"]


@own_style(math=True)
def draw(path: Path, title: str, rows: Sequence[Row]) -> None:
    """Draw all errors that any row has, and that are not zero in all of them, into a PNG. Raises OutputError."""
    solved = [row for row in rows if row.solved and row.name != REFERENCE]
    shown = [name for name in (*ERRORS, *ENERGY) if any(row.number(name) > LEAST for row in solved)]
    across = max(1, min(ACROSS, len(shown)))
    down = max(1, math.ceil(len(shown) / across))
    figure = Figure(figsize=(across * PANEL[0], down * PANEL[1] + 0.8), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    supports = sorted({row.number("support") for row in solved})
    spacings = [row.number("spacing") for row in solved]
    for axes, name in zip(panels, shown, strict=False):
        _panel(axes, name, solved, supports, (min(spacings), max(spacings)))
    for axes in panels[max(0, len(shown) - across) : len(shown)]:
        axes.set_xlabel("CPU seconds of the run", fontsize=8)
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    figure.suptitle(title, fontsize=10, parse_math=False)
    figure.legend(handles=_legend(supports), loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _panel(
    axes: Axes, name: str, rows: Sequence[Row], supports: Sequence[float], spacings: tuple[float, float]
) -> None:
    cost = np.array([row.number(TIME) for row in rows])
    error = np.array([row.number(name) for row in rows])
    error = np.where(error < LEAST, LEAST, error)
    for row, x, y in zip(rows, cost, error, strict=True):
        colour: str | tuple[float, ...] = PRESET_COLOUR
        mark, size = PRESET_MARKS.get(row.preset, ""), 9
        if not mark:
            mark, size = SUPPORT_MARKS[supports.index(row.number("support")) % len(SUPPORT_MARKS)], 4
            colour = COLOURS(_part(row.number("spacing"), spacings))
        axes.plot(x, y, marker=mark, markersize=size, color=colour, linestyle="")
    front = pareto_front(cost, error)
    axes.step(cost[front], error[front], where="post", color="tab:blue", linewidth=1.2, zorder=0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_title(LABELS[name], fontsize=9)
    axes.tick_params(labelsize=7, which="both")
    axes.grid(color="0.9", which="both")


def _part(value: float, limits: tuple[float, float]) -> float:
    """Where a value lies in a range, on a logarithmic scale: 0 to 1."""
    low, high = limits
    return math.log(value / low) / math.log(high / low) if high > low else 0.0


def _legend(supports: Sequence[float]) -> list[Line2D]:
    marks = [
        Line2D([], [], color=PRESET_COLOUR, marker=mark, linestyle="", label=f"accuracy: {name}")
        for name, mark in PRESET_MARKS.items()
    ]
    marks += [
        Line2D([], [], color="0.4", marker=SUPPORT_MARKS[i % len(SUPPORT_MARKS)], linestyle="", label=f"support {s:g}")
        for i, s in enumerate(supports)
    ]
    marks.append(Line2D([], [], color="tab:blue", label="Pareto front"))
    marks.append(Line2D([], [], color="0.0", marker="o", linestyle="", label="dark: fine, light: coarse spacing"))
    return marks


def pareto_front(cost: Floats, error: Floats) -> Ints:
    """Numbers (k,) of the points (n,) on the front, in order of cost; points that are not finite are on none.

    A point is on it if no other has at most its cost and at most its error and less of one of them. Of equal points
    the first stands for all.
    """
    known = np.flatnonzero(np.isfinite(cost) & np.isfinite(error))
    order = known[np.lexsort((error[known], cost[known]))]
    best = np.minimum.accumulate(error[order])
    before = np.concatenate([[np.inf], best[:-1]])
    return np.asarray(order[error[order] < before], dtype=np.int64)
