"""The specimen as an engineer draws it, in SVG: bodies, supports, loads, and the cracks in the colours of their steps.

The picture is sized in pixels so that its text can be read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import ArrayLike

from crackgrow.arrays import Floats
from crackgrow.case.model import Body, Case
from crackgrow.case.on_map import case_on_map
from crackgrow.case.units import Coordinate
from crackgrow.results.folder import RunFolder
from crackgrow.results.places import extent
from crackgrow.results.signs import Arrow, Circle, Polygon, Sign, Strokes, load_signs, support_signs

WIDEST, HIGHEST = 320.0, 440.0  # pixels, of the specimen
MARGIN = 56.0  # pixels round it, for supports and loads
HEAD = (7.0, 3.0)  # length and half width of an arrow's head, pixels

STEP_COLOURS = ((59, 15, 158), (156, 23, 158), (214, 80, 98), (240, 143, 54))  # from the first step to the last


def tag(name: str, *content: object, **attributes: object) -> Markup:
    """An element; `_` in the name of an attribute is a dash, at the end of it nothing; None leaves it out."""
    given = {key.rstrip("_").replace("_", "-"): value for key, value in attributes.items() if value is not None}
    words = Markup("").join(Markup(' {}="{}"').format(key, value) for key, value in given.items())
    return Markup("<{0}{1}>{2}</{0}>").format(Markup(name), words, Markup("").join(map(escape, content)))


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
    return shaft + tag("path", d=line_data(tip, closed=True), class_="head")


def draw_scene(run: RunFolder) -> Markup:
    """The scene as SVG; every grown segment of a crack carries its step as `data-step`."""
    case = case_on_map(run.case)
    view = view_of(case)
    width, height = view.size
    parts = [
        tag("g", *(_body(body, view) for body in case.bodies), class_="bodies"),
        tag("g", *_interfaces(case, view), class_="interfaces"),
        tag("g", *(svg_of(sign, view) for sign in support_signs(case)), class_="supports"),
        tag("g", *(svg_of(sign, view) for sign in load_signs(case)), class_="loads"),
        tag("g", *_cracks(run, view), class_="cracks"),
        tag("g", id="tips"),
    ]
    label = f"{run.case.title}: specimen, supports, loads and cracks"
    return tag("svg", *parts, id="scene", viewBox=f"0 0 {width:.0f} {height:.0f}", role="img", aria_label=label)


def step_colour(step: int, last: int) -> str:
    """Colour of what step `step` of 1..last has made."""
    place = (step - 1) / max(last - 1, 1) * (len(STEP_COLOURS) - 1)
    k = min(int(place), len(STEP_COLOURS) - 2)
    mixed = np.array(STEP_COLOURS[k]) + (place - k) * np.subtract(STEP_COLOURS[k + 1], STEP_COLOURS[k])
    return "#" + "".join(f"{round(part):02x}" for part in mixed)


def _body(body: Body, view: View) -> Markup:
    rings = "".join(line_data(view.pixels(ring.points), closed=True) for ring in body.rings)
    return tag("path", tag("title", f"body {body.name}"), d=rings, class_="body")


def _interfaces(case: Case, view: View) -> Iterator[Markup]:
    for interface in case.interfaces:
        for line in interface.lines:
            name = tag("title", f"interface {interface.surface}")
            yield tag("path", name, d=line_data(view.pixels(line)), class_="interface")


def _cracks(run: RunFolder, view: View) -> Iterator[Markup]:
    """Segments of all cracks, the given ones last, on top."""
    paths = run.table("paths")
    if not len(paths):  # nothing was solved: the cracks are those given
        for crack in case_on_map(run.case).cracks:
            yield tag("path", d=line_data(view.pixels(crack.points)), class_="given", data_step=0)
        return
    names, steps = np.array(paths.words("crack")), paths.steps()
    pixels = view.pixels(np.column_stack([paths.numbers("x"), paths.numbers("y")]))
    same = names[:-1] == names[1:]
    made = np.maximum(steps[:-1], steps[1:])  # a segment is as young as its younger vertex
    last = max(int(steps.max(initial=1)), 1)
    for k in sorted(np.flatnonzero(same), key=lambda k: -made[k]):
        given = made[k] == 0
        yield tag(
            "path",
            d=line_data(pixels[k : k + 2]),
            class_="given" if given else "grown",
            stroke=None if given else step_colour(int(made[k]), last),
            data_step=int(made[k]),
        )


def describe_actions(case: Case) -> list[tuple[str, str]]:
    """What holds and what loads the specimen, in words: name, and what the case says of it, in SI."""
    rows: list[tuple[str, str]] = []
    for kind in ("supports", "loads"):
        items = case.resolved[kind]
        assert isinstance(items, list)
        rows.extend((f"{kind}.{number}", _words(item)) for number, item in enumerate(items))
    return rows


def _words(item: dict[str, object]) -> str:
    return ", ".join(f"{key}: {_value(value)}" for key, value in item.items())


def _value(value: object) -> str:
    if isinstance(value, dict):
        return "{" + _words(value) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(inner) for inner in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Coordinate):
        return value.text
    return f"{value:g}" if isinstance(value, float) else str(value)
