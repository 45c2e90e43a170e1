"""The pictures of studies: what a sweep's runs bear over its parameters, with all paths, and what accuracy costs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from crackgrow.arrays import Floats
from crackgrow.case.on_map import length_unit
from crackgrow.case.units import is_number
from crackgrow.results.atomic import write_atomically
from crackgrow.results.style import give_title, own_style
from crackgrow.study.findings import Findings
from crackgrow.study.path_files import read_paths
from crackgrow.study.plan import Run
from crackgrow.study.runs import Table, Values
from crackgrow.study.sweep_file import Measured

CHOSEN: Final = ("K_I_first", "K_II_first", "x", "y")  # of the last tip, where nobody says what to draw
PANEL: Final = (3.6, 3.0)  # inches
MOST_ACROSS: Final = 4  # panels
MOST_LABELS: Final = 12  # of an axis of a heat map
LONGEST_LABEL: Final = 16  # letters of a value that is no number, such as a whole crack
SMALL: Final = 7  # points, of numbers
DPI: Final = 130
COLOURS: Final = colormaps["viridis"]
ROOM: Final = (0.35, 0.15)  # of the decades of the axes, round the points of a trade and their names
OWN, OTHER, INCREMENT = "tab:red", "tab:blue", "tab:green"


@own_style()
def draw_sweep(path: Path, table: Table) -> None:
    """Draw the responses over each parameter, as heat maps where there are two on a grid, and the paths.

    Nothing is drawn where no run is done. Raises OutputError.
    """
    study, done = table.study, [run for run in table.study.asked if table.done(run)]
    if not done:
        return
    rows = [table.row(run) for run in done]
    responses = responses_of(table, rows)
    met = [len({run.values[place] for run in done}) for place in range(len(study.parameters))]
    heat = len(met) == 2 and 2 * len(done) >= met[0] * met[1]  # a map has few holes
    pairs = list(
        dict.fromkeys((name, "" if heat else parameter) for name in responses for parameter in study.parameters)
    )
    figure, panels = _panels(len(pairs) + 1, PANEL)
    assert done[0].case is not None  # of what was run
    length = length_unit(done[0].case)
    for axes, (name, parameter) in zip(panels, pairs, strict=False):
        factor, unit = shown_as(name, length)
        values = [factor * _number(row, name) for row in rows]
        if heat:
            _heat_map(figure, axes, values, table, done)
        else:
            _scatter(axes, values, study.parameters.index(parameter), table, done)
        axes.set_title(f"{name} [{unit}]" if unit else name, fontsize=9)
    _paths(panels[len(pairs)], table, done, length)
    for axes in panels[len(pairs) + 1 :]:
        axes.set_axis_off()
    for axes in panels:
        axes.tick_params(labelsize=SMALL)
    figure.suptitle(f"{study.title}: {len(done)} of {len(study.asked)} runs", fontsize=10)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _panels(n: int, size: tuple[float, float]) -> tuple[Figure, Sequence[Axes]]:
    """A figure with so many panels of a size in inches, or some more in its last row."""
    across = min(MOST_ACROSS, n)
    down = math.ceil(n / across)
    figure = Figure(figsize=(across * size[0], down * size[1] + 0.3), layout="constrained")
    return figure, list(figure.subplots(down, across, squeeze=False).ravel())


def responses_of(table: Table, rows: Sequence[Values]) -> list[str]:
    """What the picture shows: as the sweep file says, or else K and place of the last tip, or else the load factor."""
    if table.study.responses is not None:
        return list(table.study.responses)
    tips = [name.rsplit(".", 1)[0] for row in rows for name in row if name.endswith(f".{CHOSEN[0]}")]
    return [f"{tips[-1]}.{what}" for what in CHOSEN] if tips else ["load_factor"]


def shown_as(name: str, length: tuple[float, str]) -> tuple[float, str]:
    """Factor and unit in which a column is drawn, with those of lengths; the table itself is in SI units."""
    _, dot, what = name.rpartition(".")
    if name in ("path_hausdorff", "path_frechet", "length_error"):
        return length
    if not dot:
        return 1.0, {"seconds": "s", "cpu_seconds": "s", "peak_memory_mb": "MB"}.get(name, "")
    return length if what in ("x", "y") else (1e-6, "MPa sqrt(m)")


def _ticks(table: Table, place: int) -> list[str]:
    """The values of a parameter: by size if they are numbers, else as they come."""
    values = list(dict.fromkeys(run.values[place] for run in table.study.asked))
    return sorted(values, key=float) if all(map(is_number, values)) else values


def _heat_map(figure: Figure, axes: Axes, values: Sequence[float], table: Table, runs: Sequence[Run]) -> None:
    down, along = _ticks(table, 0), _ticks(table, 1)
    cells = np.full((len(down), len(along)), np.nan)
    for run, value in zip(runs, values, strict=True):
        cells[down.index(run.values[0]), along.index(run.values[1])] = value
    image = axes.imshow(np.ma.masked_invalid(cells), origin="lower", aspect="auto", cmap=COLOURS)
    figure.colorbar(image, ax=axes).ax.tick_params(labelsize=SMALL)
    for axis, ticks, name in zip((axes.yaxis, axes.xaxis), (down, along), table.study.parameters, strict=True):
        places = list(range(0, len(ticks), math.ceil(len(ticks) / MOST_LABELS)))
        axis.set_ticks(places, [_short(ticks[place]) for place in places])
        axis.set_label_text(name, fontsize=8)


def _scatter(axes: Axes, y: Sequence[float], place: int, table: Table, runs: Sequence[Run]) -> None:
    ticks, values = _ticks(table, place), [run.values[place] for run in runs]
    if all(map(is_number, ticks)):
        x = [float(value) for value in values]
    else:
        x = [float(ticks.index(value)) for value in values]
        axes.set_xticks(range(len(ticks)), [_short(tick) for tick in ticks])
    order = np.argsort(x, kind="stable")
    line = "-" if len(table.study.parameters) == 1 else ""
    axes.plot(np.array(x)[order], np.array(y)[order], marker="o", markersize=3, linestyle=line, color=OTHER)
    axes.set_xlabel(table.study.parameters[place], fontsize=8)
    axes.grid(color="0.9")


def _paths(axes: Axes, table: Table, runs: Sequence[Run], length: tuple[float, str]) -> None:
    """The cracks at the end, coloured by the first parameter; `length` is the factor and the unit of places."""
    scale, unit = length
    values = _ticks(table, 0)
    for run in runs:
        if run.case is not None and not run.case.cracks:
            continue
        part = values.index(run.values[0]) / max(1, len(values) - 1)
        for line in read_paths(run.folder).cracks.values():
            axes.plot(*(scale * line.points).T, color=COLOURS(part), linewidth=0.8)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"x [{unit}]", fontsize=8)
    axes.set_ylabel(f"y [{unit}]", fontsize=8)
    drawn = f"paths, coloured by {table.study.parameters[0]}" if axes.lines else "no cracks, no paths"
    axes.set_title(drawn, fontsize=9)


@own_style()
def draw_trade(path: Path, found: Findings, table: Table) -> None:
    """Draw error, distance of paths and memory over the CPU seconds, as far as runs have them. Raises OutputError."""
    panels = {
        "off, %": ("error", 100.0, 100.0 * found.plan.tolerance),
        "path off, % of what has grown": ("path_share", 100.0, 100.0 * found.path_tolerance),
        "memory, MB": ("peak_memory_mb", 1.0, math.nan),
    }
    rows = [table.row(run) for run in found.plan.study.runs]
    known = {title: what for title, what in panels.items() if any(_number(row, what[0]) > 0.0 for row in rows)}
    figure, drawn = _panels(len(known), (4.0, 3.1))
    for axes, (title, (column, scale, allowed)) in zip(drawn, known.items(), strict=True):
        points = [(str(row["setting"]), _number(row, "cpu_seconds"), scale * _number(row, column)) for row in rows]
        _costs(axes, found, [point for point in points if point[2] > 0.0], allowed)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("CPU seconds of the run", fontsize=8)
    give_title(figure, found.plan.study.title)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _costs(axes: Axes, found: Findings, points: list[tuple[str, float, float]], allowed: float) -> None:
    """Points (name, seconds, value) on logarithmic scales, those of settings with a line through them."""
    plan = found.plan
    line = [point for point in points if point[0] in plan.settings]
    axes.plot([x for _, x, _ in line], [y for *_, y in line], color=OTHER, linewidth=0.8, zorder=0)
    for name, x, y in points:
        colour = OWN if name == plan.own else INCREMENT if name in plan.increments else OTHER
        axes.plot(x, y, marker="s" if name in plan.increments else "o", color=colour, linestyle="")
        beside = (5, 5 if name == plan.own else -11)
        axes.annotate(name, (x, y), beside, textcoords="offset points", fontsize=SMALL, color=colour)
    if math.isfinite(allowed):
        axes.axhline(allowed, color="0.4", linestyle="--", linewidth=0.8)
        axes.text(
            0.01, allowed, "asked for", transform=axes.get_yaxis_transform(), fontsize=SMALL, color="0.4", va="bottom"
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(LogFormatter(labelOnlyBase=False))
    axes.margins(*ROOM)
    axes.tick_params(labelsize=SMALL, which="both")
    axes.grid(color="0.9", which="both")


@own_style()
def draw_fit(path: Path, points: Floats, lines: Mapping[str, Floats], measured: Measured) -> None:
    """Draw measured points (n, 2), and the curves or paths (m, 2) of some runs by name. Raises OutputError."""
    figure, (axes, *_) = _panels(1, (6.0, 4.5))
    for (name, line), style in zip(lines.items(), ("--", "-")[-len(lines) :], strict=True):
        axes.plot(*line.T, style, color=OTHER if style == "-" else "0.6", label=name, linewidth=1.0)
    axes.plot(*points.T, "o", color=OWN, markersize=3, label="measured")
    axes.set_xlabel(measured.x or "x, m")
    axes.set_ylabel(measured.y or "y, m")
    if measured.crack is not None:
        axes.set_aspect("equal", adjustable="datalim")
    axes.legend(fontsize=SMALL)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


def _number(row: Values, name: str) -> float:
    value = row.get(name)
    return math.nan if value is None else float(value)


def _short(text: str) -> str:
    if is_number(text):
        return f"{float(text):.4g}"
    return text if len(text) <= LONGEST_LABEL else f"{text[: LONGEST_LABEL - 3]}..."
