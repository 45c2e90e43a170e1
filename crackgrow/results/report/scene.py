"""The specimen as an engineer draws it: bodies, supports, loads, and the cracks in the colours of their steps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.formula import component_at
from crackgrow.case.model import (
    Body,
    Case,
    ContactSupport,
    EdgeRegion,
    EdgeSupport,
    EdgeTraction,
    FluidPressure,
    Gravity,
    Load,
    PointForce,
    PointSupport,
    Support,
)
from crackgrow.results.folder import RunFolder
from crackgrow.results.overview import lines_of, surface_text
from crackgrow.results.report import symbols
from crackgrow.results.report.markup import Markup, tag
from crackgrow.results.report.view import View, line_data, view_of

STEP_COLOURS = ((59, 15, 158), (156, 23, 158), (214, 80, 98), (240, 143, 54))  # from the first step to the last


def draw_scene(run: RunFolder) -> Markup:
    """The scene as SVG; every grown segment of a crack carries its step as `data-step`."""
    view = view_of(run.case)
    width, height = view.size
    parts = [
        tag("g", *(_body(body, view) for body in run.case.bodies), class_="bodies"),
        tag("g", *_interfaces(run.case, view), class_="interfaces"),
        tag("g", *(_support(item, run.case, view) for item in run.case.supports), class_="supports"),
        tag("g", *(_load(item, run.case, view) for item in run.case.loads), class_="loads"),
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
    if not len(run.paths):  # nothing was solved: the cracks are those given
        for crack in run.case.cracks:
            yield tag("path", d=line_data(view.pixels(crack.points)), class_="given", data_step=0)
        return
    names, steps = np.array(run.paths.words("crack")), run.paths.steps()
    pixels = view.pixels(np.column_stack([run.paths.numbers("x"), run.paths.numbers("y")]))
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


def _support(support: Support, case: Case, view: View) -> Markup:
    if isinstance(support, PointSupport):
        place = view.pixels(support.point)[0]
        fixed = [component is not None for component in support.displacement]
        outward = _outward_at(_body_of(support.body, case), support.point)
        direction = outward if all(fixed) else np.array(fixed, dtype=float)
        side = 1.0 if direction @ outward >= 0.0 else -1.0
        if not all(fixed) and abs(direction @ outward) < 0.5:  # held along the edge: from the left, or from below
            side = -1.0
        return symbols.triangle(place, _flip(side * direction), rolls=not all(fixed))
    drawn = [_prescribed(support, case, view)] if isinstance(support, EdgeSupport) else []
    for line, outward in _lines(support.region, case, view, symbols.HATCH[0]):
        if isinstance(support, EdgeSupport) and None in support.displacement:
            drawn.append(symbols.rollers(line, outward))
        else:
            drawn.append(symbols.ground(line, outward))
    name = "rigid foundation under" if isinstance(support, ContactSupport) else "held:"
    return tag("g", tag("title", f"{name} {support.region.body}.{support.region.edge}"), *drawn)


def _prescribed(support: EdgeSupport, case: Case, view: View) -> Markup:
    """Arrows of the displacements that are prescribed along an edge, the longest as long as those of loads."""
    lines = [line for line, _ in _lines(support.region, case, view, symbols.ARROW_GAP)]
    places = np.concatenate([symbols.spaced(line, symbols.ARROW_GAP) for line in lines])
    metres = view.metres(places)
    given = [
        np.zeros(len(places)) if c is None else c(metres) if callable(c) else np.full(len(places), float(c))
        for c in support.displacement
    ]
    moved = np.column_stack(given)
    size = np.linalg.norm(moved, axis=1)
    if not size.any():
        return Markup("")
    reach = symbols.ARROW * moved / size.max() * [1.0, -1.0]
    seen = np.linalg.norm(reach, axis=1) > symbols.HEAD[0]
    arrows = (symbols.arrow(place, place + arm) for place, arm in zip(places[seen], reach[seen], strict=True))
    return tag("g", *arrows, class_="prescribed")


def _load(load: Load, case: Case, view: View) -> Markup:
    if isinstance(load, EdgeTraction):
        name = tag("title", f"traction on {load.region.body}.{load.region.edge}")
        drawn = []
        for line, outward in _lines(load.region, case, view, symbols.ARROW_GAP):
            middle = view.metres(line.mean(axis=0)[None])
            traction = [float(component_at(component, middle)[0]) for component in load.traction]
            if any(traction):
                drawn.append(symbols.arrows_along(line, _flip(traction), outward))
        return tag("g", name, *drawn) if drawn else Markup("")
    if isinstance(load, PointForce) and any(load.force):
        head = view.pixels(load.point[None])[0]
        reach = symbols.ARROW * _flip(load.force) / np.linalg.norm(load.force)
        return tag("g", tag("title", f"force on {load.body}"), symbols.arrow(head - reach, head))
    if isinstance(load, Gravity) and any(load.acceleration):
        outline = view.pixels(_body_of(load.body, case).outline)
        middle = (outline.min(axis=0) + outline.max(axis=0)) / 2
        reach = 40.0 * _flip(load.acceleration) / np.linalg.norm(load.acceleration)
        return tag("g", tag("title", f"gravity on {load.body}"), symbols.arrow(middle - reach / 2, middle + reach / 2))
    if isinstance(load, FluidPressure):
        pairs = [pair for line in lines_of(case, load.surface) for pair in _apart(view.pixels(line))]
        return tag("g", tag("title", f"pressure in {surface_text(load.surface)}"), *pairs)
    return Markup("")  # an in-situ stress fills the body: words tell it


def _apart(line: Floats) -> Iterator[Markup]:
    """Arrows off both sides of a line (n, 2) px."""
    along = line[-1] - line[0] if np.any(line[-1] != line[0]) else line[1] - line[0]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    for place in symbols.spaced(line, symbols.ARROW_GAP):
        yield from (symbols.arrow(place, place + side * 14.0 * normal) for side in (-1.0, 1.0))


def _lines(region: EdgeRegion, case: Case, view: View, shortest: float) -> Iterator[tuple[Floats, Floats]]:
    """Straight stretches of a region, each as a line (2, 2) px with its outward direction (2,) px.

    Sides of an arc or another smooth edge are taken together until they are no shorter than `shortest`.
    """
    body = _body_of(region.body, case)
    starts = np.concatenate([ring.points for ring in body.rings])
    ends = np.concatenate([np.roll(ring.points, -1, axis=0) for ring in body.rings])
    waiting: list[Floats] = []
    for side, (first, last) in zip(region.sides, region.limits, strict=True):
        a, b = starts[side], ends[side]
        waiting.append(view.pixels([a + first * (b - a), a + last * (b - a)]))
        stretch = np.array([waiting[0][0], waiting[-1][1]])
        along = stretch[1] - stretch[0]
        length = float(np.linalg.norm(along))
        if length >= shortest or side == region.sides[-1]:
            waiting = []
            if length > 0.0:  # rock on the left, seen with y upwards: outward is on the right
                yield stretch, np.array([-along[1], along[0]]) / length


def _outward_at(body: Body, point: Floats) -> Floats:
    """Outward direction (2,), y upwards, of the side of a body that is next to a point.

    At a corner the side that is nearest to horizontal counts: supports stand below or above rather than beside.
    """
    best: list[tuple[float, float, Floats]] = []
    for ring in body.rings:
        along = np.roll(ring.points, -1, axis=0) - ring.points
        size = np.linalg.norm(along, axis=1)
        along = along[size > 0.0] / size[size > 0.0, None]
        t = np.clip(np.einsum("ij,ij->i", point - ring.points[size > 0.0], along), 0.0, size[size > 0.0])
        distance = np.linalg.norm(ring.points[size > 0.0] + t[:, None] * along - point, axis=1)
        extent = float(np.ptp(body.outline, axis=0).max())
        best.extend(zip(np.round(distance / extent, 6), np.round(np.abs(along[:, 1]), 6), along, strict=True))
    _, _, side = min(best, key=lambda item: item[:2])
    return np.array([side[1], -side[0]])


def _body_of(name: str, case: Case) -> Body:
    return next(body for body in case.bodies if body.name == name)


def _flip(direction: object) -> Floats:
    """A direction (2,), y upwards, as one of the picture."""
    return np.asarray(direction, dtype=float) * [1.0, -1.0]


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
