"""Drawings as SVG: where a point of the specimen lies in the picture, and signs of engineering drawings.

The picture is sized in pixels so that its text can be read.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.results.places import extent
from crackgrow.results.report.markup import Markup, join, tag
from crackgrow.results.signs import Arrow, Circle, Polygon, Sign, Strokes

WIDEST, HIGHEST = 320.0, 440.0  # pixels, of the specimen
MARGIN = 56.0  # pixels round it, for supports and loads
HEAD = (7.0, 3.0)  # length and half width of an arrow's head, pixels


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


def svg_of(sign: Sign, view: View) -> Markup:
    """The marks of a sign, which is named where the pointer rests on it; its words stand in the page's tables."""
    return tag("g", tag("title", sign.title), *(_mark(mark, view) for mark in sign.marks))


def _mark(mark: Arrow | Circle | Polygon | Strokes, view: View) -> Markup:
    if isinstance(mark, Arrow):
        drawn = _arrow(*view.pixels([mark.tail, mark.head]))
        return tag("g", drawn, class_="prescribed") if mark.kind == "given" else drawn
    if isinstance(mark, Strokes):
        lines = (line_data(view.pixels(ends)) for ends in mark.ends)
        return tag("path", d="".join(lines), class_=mark.kind)
    if isinstance(mark, Polygon):
        return tag("path", d=line_data(view.pixels(mark.corners), closed=True), class_=mark.kind)
    (x, y), radius = view.pixels(mark.center)[0], mark.radius * view.scale
    return tag("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=f"{radius:.1f}", class_=mark.kind)


def _arrow(tail: Floats, head: Floats) -> Markup:
    """An arrow between two points (2,) px."""
    along = (head - tail) / np.linalg.norm(head - tail)
    across = np.array([-along[1], along[0]])
    neck = head - HEAD[0] * along
    tip = [head, neck + HEAD[1] * across, neck - HEAD[1] * across]
    shaft = tag("path", d=line_data([tail, neck]), class_="shaft")
    return join([shaft, tag("path", d=line_data(tip, closed=True), class_="head")])
