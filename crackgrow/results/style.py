"""How pictures look: as matplotlib draws by itself, whatever files and variables of the user say of its looks."""

from __future__ import annotations

import contextlib
import os
import textwrap
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:  # this module is on the command line's way: no matplotlib
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure
    from matplotlib.text import Text

LETTER: Final = 0.085  # inches that a letter of a title takes
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


def give_title(figure: Figure, title: str, size: float = 10.0) -> Text:
    """Give a figure its title, in lines that fit its width: matplotlib itself takes what it wraps for formulas."""
    most = max(20, int(figure.get_figwidth() / LETTER))
    return figure.suptitle("\n".join(textwrap.fill(line, most) for line in title.splitlines()), fontsize=size)


def has_bar_beside(width: float, height: float) -> bool:
    """Whether a colour bar has room beside something of this size; else it has below."""
    return width <= WIDE * height


def add_bar(figure: Figure, axes: Axes, colours: ScalarMappable, **bar: Any) -> Colorbar:
    """Add a colour bar beside axes of equal scales, or below them."""
    beside = has_bar_beside(*(high - low for low, high in (axes.get_xlim(), axes.get_ylim())))
    return figure.colorbar(colours, ax=axes, location="right" if beside else "bottom", shrink=SHARE, **bar)
