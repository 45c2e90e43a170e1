"""How pictures look: as matplotlib draws by itself, whatever files and variables of the user say of its looks."""

from __future__ import annotations

import contextlib
import os
import textwrap
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LETTER: Final = 0.085  # inches that a letter of a title takes
PLAIN: Final[dict[Any, Any]] = {
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
def own_style(*, math: bool = False) -> Iterator[None]:
    """Matplotlib's own settings until the end of the block, and then the user's again.

    math: whether texts between dollars are formulas; those of a user, such as the title of a case, are none
    """
    import matplotlib as mpl

    with _ALONE, mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({"text.parse_math": math, **PLAIN})
        yield


def wrapped(text: str, figure: Figure) -> str:
    """A title of a figure, in lines that fit its width: matplotlib itself takes what it wraps for formulas."""
    return textwrap.fill(text, max(20, int(figure.get_figwidth() / LETTER)))
