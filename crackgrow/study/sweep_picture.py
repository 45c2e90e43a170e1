"""The picture of a sweep: responses over the parameters, and all paths on top of each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from crackgrow.case.units import is_number
from crackgrow.results.atomic import write_atomically
from crackgrow.results.places import length_unit
from crackgrow.results.style import own_style
from crackgrow.study.path_files import read_paths
from crackgrow.study.plan import Run
from crackgrow.study.table import Table, Values

CHOSEN: Final = ("K_I_first", "K_II_first", "x", "y")  # of the last tip, where nobody says what to draw
PANEL: Final = (3.6, 3.0)  # inches
MOST_ACROSS: Final = 4  # panels
MOST_LABELS: Final = 12  # of an axis of a heat map
LONGEST_LABEL: Final = 16  # letters of a value that is no number, such as a whole crack
SMALL: Final = 7  # points, of numbers
DPI: Final = 130
COLOURS: Final = colormaps["viridis"]


@own_style()
def draw(path: Path, table: Table) -> None:
    """Draw the responses over each parameter, as heat maps where there are two on a grid, and the paths.

    Nothing is drawn where no run is done. Raises OutputError.
    """
    done = [run for run in table.study.asked if table.done(run)]
    if not done:
        return
    rows = [table.row(run) for run in done]
    responses = responses_of(table, rows)
    heat = len(table.study.parameters) == 2 and _is_grid(done)
    pairs = [(name, "" if heat else parameter) for name in responses for parameter in table.study.parameters]
    pairs = list(dict.fromkeys(pairs))
    across = min(MOST_ACROSS, len(pairs) + 1)
    down = math.ceil((len(pairs) + 1) / across)
    figure = Figure(figsize=(across * PANEL[0], down * PANEL[1] + 0.3), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    assert done[0].case is not None  # of what was run
    length = length_unit(done[0].case)
    for axes, (name, parameter) in zip(panels, pairs, strict=False):
        factor, unit = shown_as(name, length)
        values = [factor * _number(row, name) for row in rows]
        if heat:
            _heat_map(figure, axes, values, table, done)
        else:
            _scatter(axes, values, parameter, table, done)
        axes.set_title(f"{name} [{unit}]" if unit else name, fontsize=9)
    _paths(panels[len(pairs)], table, done, length)
    for axes in panels[len(pairs) + 1 :]:
        axes.set_axis_off()
    for axes in panels:
        axes.tick_params(labelsize=SMALL)
    figure.suptitle(f"{table.study.title}: {len(done)} of {len(table.study.asked)} runs", fontsize=10)
    write_atomically(path, lambda file: figure.savefig(file, dpi=DPI))


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


def _is_grid(runs: Sequence[Run]) -> bool:
    """Whether values are met several times in both directions, so that a map of them has few holes."""
    first, second = (len({run.values[place] for run in runs}) for place in (0, 1))
    return 2 * len(runs) >= first * second


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
    for axis, ticks in ((axes.yaxis, down), (axes.xaxis, along)):
        places = list(range(0, len(ticks), math.ceil(len(ticks) / MOST_LABELS)))
        axis.set_ticks(places, [_short(ticks[place]) for place in places])
    axes.set_ylabel(table.study.parameters[0], fontsize=8)
    axes.set_xlabel(table.study.parameters[1], fontsize=8)


def _scatter(axes: Axes, y: Sequence[float], parameter: str, table: Table, runs: Sequence[Run]) -> None:
    place = table.study.parameters.index(parameter)
    ticks = _ticks(table, place)
    if table.numeric(parameter):
        x: list[float] = [float(run.values[place]) for run in runs]
    else:
        x = [float(ticks.index(run.values[place])) for run in runs]
        axes.set_xticks(range(len(ticks)), [_short(tick) for tick in ticks])
    order = np.argsort(x, kind="stable")
    line = "-" if len(table.study.parameters) == 1 else ""
    axes.plot(np.array(x)[order], np.array(y)[order], marker="o", markersize=3, linestyle=line, color="tab:blue")
    axes.set_xlabel(parameter, fontsize=8)
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
            points: NDArray[np.float64] = scale * line.points
            axes.plot(points[:, 0], points[:, 1], color=COLOURS(part), linewidth=0.8)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"x [{unit}]", fontsize=8)
    axes.set_ylabel(f"y [{unit}]", fontsize=8)
    drawn = f"paths, coloured by {table.study.parameters[0]}" if axes.lines else "no cracks, no paths"
    axes.set_title(drawn, fontsize=9)


def _number(row: Values, name: str) -> float:
    value = row.get(name)
    return math.nan if value is None else float(value)


def _short(text: str) -> str:
    if is_number(text):
        return f"{float(text):.4g}"
    return text if len(text) <= LONGEST_LABEL else f"{text[: LONGEST_LABEL - 3]}..."
