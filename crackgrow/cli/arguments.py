"""What the arguments of commands are read as, by the names that `commands.toml` has for them."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

MOST_PIXELS: Final = 8000  # of a side


def reader_of(kind: str) -> Callable[[str], Any]:
    """What reads an argument of a kind, for argparse: what it cannot read is told with what is wanted."""
    pattern, read, wanted = KINDS[kind]

    def reader(text: str) -> Any:
        try:
            if re.fullmatch(pattern, text):
                return read(text)
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(f"{text!r}: {wanted}")

    reader.__name__ = kind
    return reader


def _warp(text: str) -> float | None:
    factor = None if text == "auto" else float(text)
    if factor is not None and not 0.0 <= factor < math.inf:
        raise ValueError(text)
    return factor


def _span(text: str) -> range:
    first, dash, last = text.partition("-")
    span = range(int(first), int(last if dash else first) + 1)
    if not span:
        raise ValueError(text)
    return span


def _size(text: str) -> tuple[int, int]:
    width, height = map(int, text.split("x"))
    if not all(100 <= side <= MOST_PIXELS for side in (width, height)):
        raise ValueError(text)
    return width, height


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(","))


ANY: Final = "(?s).*"
KINDS: Final[dict[str, tuple[str, Callable[[str], Any], str]]] = {
    "path": ("(?s).+", Path, "an empty name; the current folder is '.'"),  # mostly a variable that is not set
    "picture": (r"(?si).+\.(png|svg)", Path, "a name that ends in .png or .svg is wanted"),
    "count": (r"0*[1-9]\d*", int, "a whole number from 1 on is wanted"),
    "step": (r"\d+", int, "the number of a step is wanted, from 0 on"),
    "number": (ANY, int, "a whole number is wanted"),
    "seconds": (ANY, float, "a number of seconds is wanted"),
    "warp": (ANY, _warp, "auto, or a number from 0 on is wanted"),
    "span": (r"\d+(-\d+)?", _span, "a step such as 4, or a span such as 4-10 is wanted"),
    "size": (r"\d+x\d+", _size, f"WIDTHxHEIGHT in pixels, each from 100 to {MOST_PIXELS}, is wanted"),
    "names": (
        r"[^,]*[^,\s][^,]*,[^,]*[^,\s][^,]*",
        _names,
        "two column names are wanted, that of x and that of y: X,Y",
    ),
}
"""What a text of a kind looks like, what reads it and may raise ValueError, and what is wanted."""
