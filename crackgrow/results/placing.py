"""Where axes, titles and colour bars lie in a figure, by what their words and numbers take, in inches.

The layouts of matplotlib draw all text several times to know that.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from numpy.typing import NDArray

from crackgrow.results.style import wrapped

DIGIT: Final = 0.09  # of a number at an axis
LINE: Final = 0.18  # from line to line
GAP: Final = 0.12  # of a tick with the space round it
BELOW: Final = 2 * (LINE + GAP)  # of the numbers of a lying axis and its label
BAR: Final = 0.23  # width of a colour bar
SHARE: Final = 0.8  # of the axes' length that a colour bar takes


def with_bar(figure: Figure, axes: Axes, colours: ScalarMappable, title: str, *, beside: bool, **bar: Any) -> Colorbar:
    """Place the axes of a figure, of equal scales, as large as fits, and a colour bar with a label beside or below."""
    scale = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    made = figure.colorbar(colours, cax=scale, orientation="vertical" if beside else "horizontal", **bar)
    left, bottom = _left_of(axes), BELOW if beside else 2 * BELOW + BAR + GAP
    right = 2 * GAP + (2 * GAP + BAR + _left_of(scale) if beside else 0.0)
    room = figure.get_size_inches() - (left + right, bottom + _titled(figure, title))
    extent = np.ptp([axes.get_xlim(), axes.get_ylim()], axis=1)
    width, height = extent * (room / extent).min()
    left, bottom = left + (room[0] - width) / 2, bottom + (room[1] - height) / 2
    _put(figure, axes, left, bottom, width, height)
    if beside:
        _put(figure, scale, left + width + 2 * GAP, bottom + (1 - SHARE) / 2 * height, BAR, SHARE * height)
    else:
        _put(figure, scale, left + (1 - SHARE) / 2 * width, bottom - BELOW - GAP - BAR, SHARE * width, BAR)
    return made


def in_rows(figure: Figure, table: NDArray[np.object_], title: str) -> None:
    """Place axes (rows, columns), all of the same size."""
    n_rows, n_columns = table.shape
    lefts = [max(_left_of(axes) for axes in column) for column in table.T]
    width = (figure.get_figwidth() - sum(lefts)) / n_columns - 2 * GAP
    height = (figure.get_figheight() - _titled(figure, title) - GAP * (n_rows - 1)) / n_rows - BELOW
    for (row, column), axes in np.ndenumerate(table):
        left = sum(lefts[: column + 1]) + column * (width + 2 * GAP)
        _put(figure, axes, left, BELOW + (n_rows - 1 - row) * (height + BELOW + GAP), width, height)


def _titled(figure: Figure, title: str) -> float:
    """Give a figure its title; returns what it takes, with room above the axes for a common factor of their numbers."""
    lines = "\n".join(wrapped(line, figure) for line in title.splitlines())
    figure.suptitle(lines, fontsize=10, y=1.0 - 0.5 * GAP / figure.get_figheight(), va="top")
    return LINE * (2 + lines.count("\n"))


def _left_of(axes: Axes) -> float:
    """What the numbers of an upright axis and its label take."""
    numbers = axes.yaxis.get_major_formatter().format_ticks(axes.yaxis.get_majorticklocs().tolist())
    return LINE + 2 * GAP + DIGIT * max((len(number) for number in numbers), default=0)


def _put(figure: Figure, axes: Axes, left: float, bottom: float, width: float, height: float) -> None:
    """Place axes; they have a size however little room is left."""
    across, up = figure.get_size_inches()
    axes.set_position((left / across, bottom / up, max(width, GAP) / across, max(height, GAP) / up))
