"""The specimen as an engineer draws it: bodies, supports, loads, and the cracks in the colours of their steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crackgrow.case.model import Body, Case
from crackgrow.results.folder import RunFolder
from crackgrow.results.report.drawing import View, line_data, svg_of, view_of
from crackgrow.results.report.markup import Markup, tag
from crackgrow.results.signs import load_signs, support_signs

STEP_COLOURS = ((59, 15, 158), (156, 23, 158), (214, 80, 98), (240, 143, 54))  # from the first step to the last


def draw_scene(run: RunFolder) -> Markup:
    """The scene as SVG; every grown segment of a crack carries its step as `data-step`."""
    view = view_of(run.case)
    width, height = view.size
    parts = [
        tag("g", *(_body(body, view) for body in run.case.bodies), class_="bodies"),
        tag("g", *_interfaces(run.case, view), class_="interfaces"),
        tag("g", *(svg_of(sign, view) for sign in support_signs(run.case)), class_="supports"),
        tag("g", *(svg_of(sign, view) for sign in load_signs(run.case)), class_="loads"),
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
            name = tag("title", f"interface {'/'.join(interface.bodies)}")
            yield tag("path", name, d=line_data(view.pixels(line)), class_="interface")


def _cracks(run: RunFolder, view: View) -> Iterator[Markup]:
    """Segments of all cracks, the given ones last, on top."""
    paths = run.table("paths")
    if not len(paths):  # nothing was solved: the cracks are those given
        for crack in run.case.cracks:
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
    return f"{value:g}" if isinstance(value, float) else str(value)
