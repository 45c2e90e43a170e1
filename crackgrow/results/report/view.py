"""Where a point of the specimen lies in the picture, which is sized in pixels so that its text can be read."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.results.overview import extent

WIDEST, HIGHEST = 320.0, 440.0  # pixels, of the specimen
MARGIN = 56.0  # pixels round it, for supports and loads


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """From metres, y upwards, to pixels, y downwards."""

    low: Floats  # (2,) m, lower left corner of the specimen
    high: Floats  # (2,) m, upper right one
    scale: float  # pixels per metre

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the picture, pixels."""
        width, height = (self.high - self.low) * self.scale + 2 * MARGIN
        return float(width), float(height)

    def pixels(self, points: ArrayLike) -> Floats:
        """Pixels (n, 2) of points (n, 2) m."""
        x, y = ((np.atleast_2d(points) - self.low) * self.scale).T
        return np.column_stack([x + MARGIN, self.size[1] - MARGIN - y])


def view_of(case: Case) -> View:
    """The view that shows all bodies of a case."""
    low, high = extent(case)
    width, height = high - low
    return View(low, high, float(min(WIDEST / width, HIGHEST / height)))


def line_data(pixels: Iterable[Iterable[float]], closed: bool = False) -> str:
    """The data of an SVG path through points (n, 2) px."""
    return "M" + "L".join(f"{x:.2f},{y:.2f}" for x, y in pixels) + ("Z" if closed else "")
