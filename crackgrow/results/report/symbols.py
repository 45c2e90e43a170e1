"""Signs of engineering drawings as SVG."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results.report.markup import Markup, join, tag
from crackgrow.results.report.view import View, line_data
from crackgrow.results.signs import Arrow, Circle, Polygon, Sign, Strokes

HEAD = (7.0, 3.0)  # length and half width of an arrow's head, pixels


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
