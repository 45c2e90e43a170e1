"""How pictures look: as matplotlib draws by itself, whatever files and variables of the user say of its looks.

Axes, titles and colour bars are placed by what their words and numbers take: matplotlib's own layouts draw all text
several times to know that.
"""

from __future__ import annotations

import contextlib
import os
import textwrap
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:  # this module is on the command line's way: no matplotlib
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

LETTER: Final = 0.085  # inches that a letter of a title takes
DIGIT: Final = 0.09  # inches, of a number at an axis
LINE: Final = 0.18  # from line to line
GAP: Final = 0.12  # of a tick with the space round it
BELOW: Final = 2 * (LINE + GAP)  # of the numbers of a lying axis and its label
BAR: Final = 0.23  # width of a colour bar
WIDE: Final = 2.0  # width over height from which a colour bar lies below, where its words have room
SHARE: Final = 0.8  # of the axes' length that a colour bar takes

PLAIN: Final[dict[Any, Any]] = {
    "text.parse_math": False,  # texts between dollars, such as the title of a case, are no formulas
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-5, 8),  # coordinates of maps in full
    "svg.fonttype": "none",  # texts are texts
    "svg.hashsalt": "crackgrow",  # the same drawing is the same file
}
_ALONE = threading.RLock()  # matplotlib's settings are those of the whole process


def pass_over_settings() -> None:
    """Let this process draw without the backend and the file of settings that the environment names, good or bad.

    Before matplotlib loads: it doesn't load with a backend that it doesn't know.
    """
    os.environ.pop("MPLBACKEND", None)
    os.environ["MATPLOTLIBRC"] = os.devnull


@contextlib.contextmanager
def own_style() -> Iterator[None]:
    """Matplotlib's own settings until the end of the block, and then the user's again."""
    import matplotlib as mpl

    with _ALONE, mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(PLAIN)
        yield


def wrapped(text: str, figure: Figure) -> str:
    """A title of a figure, in lines that fit its width: matplotlib itself takes what it wraps for formulas."""
    return textwrap.fill(text, max(20, int(figure.get_figwidth() / LETTER)))


def has_bar_beside(width: float, height: float) -> bool:
    """Whether a colour bar has room beside something of this size; else it has below."""
    return width <= WIDE * height


def with_bar(figure: Figure, axes: Axes, colours: ScalarMappable, title: str, **bar: Any) -> Colorbar:
    """Place the axes of a figure, of equal scales, as large as fits, and a colour bar with a label beside or below."""
    across, up = (high - low for low, high in (axes.get_xlim(), axes.get_ylim()))
    beside, scale = has_bar_beside(across, up), figure.add_axes((0.0, 0.0, 1.0, 1.0))
    made = figure.colorbar(colours, cax=scale, orientation="vertical" if beside else "horizontal", **bar)
    left, bottom = _left_of(axes), BELOW if beside else 2 * BELOW + BAR + GAP
    right = 2 * GAP + (2 * GAP + BAR + _left_of(scale) if beside else 0.0)
    room = figure.get_size_inches() - (left + right, bottom + _titled(figure, title))
    factor = min(room[0] / across, room[1] / up)
    width, height = across * factor, up * factor
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
    for row, of_row in enumerate(table):
        for column, axes in enumerate(of_row):
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
