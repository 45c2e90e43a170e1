"""A drawing of a case as an engineer makes it: bodies, cells, cracks, supports, loads with values, dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as LinePath

from crackgrow.arrays import Floats
from crackgrow.case.formula import CoordinateFormula, component_at
from crackgrow.case.model import (
    Body,
    Case,
    Component,
    ContactSupport,
    Crack,
    EdgeRegion,
    EdgeSupport,
    EdgeTraction,
    FluidPressure,
    Gravity,
    InSituStress,
    PointForce,
    PointSupport,
)
from crackgrow.cover.squares import QUANTA
from crackgrow.plan.glyphs import GIVEN, LOAD, arrow, beside, dimension, hatch, label, rollers, triangle
from crackgrow.results.atomic import write_atomically
from crackgrow.results.overview import component_text, length_unit, lines_of
from crackgrow.results.style import own_style, wrapped
from crackgrow.run.configuration import first_cells
from crackgrow.run.scene import make_scene

FORMATS: Final = (".png", ".svg")
MOST_NAMES, MOST_WHOLE_NAMES = 12, 2  # of more cracks none is named; of more the names alone are written
SIDE: Final = 6.5  # inches, the longer one of the scene
SHEAR: Final = 0.5  # sine of the angle to an edge below which a traction runs along it
ARROW, SIGN, MARGIN = 0.10, 0.035, 0.27  # of the scene's size
STEEP: Final = 0.6  # of the normal along y, from which words stand on what they name, not beside it
COLOURS: Final = ("#e6e1d8", "#d5dde6", "#dfe6d5", "#e6d5df")


@own_style()
def draw_scene(path: Path, case: Case) -> None:
    """Draw the case into a .png or .svg file; raises OutputError."""
    scale, unit = length_unit(case)
    outlines = np.concatenate([body.outline for body in case.bodies])
    low, high = outlines.min(axis=0), outlines.max(axis=0)
    size = float((high - low).max())
    margin = MARGIN * size
    box = high - low + 2 * margin
    figure = Figure(figsize=tuple(SIDE * box / box.max() + [0.0, 0.35]), dpi=150)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0 - 0.35 / figure.get_figheight()))
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    axes.set_axis_off()
    for number, body in enumerate(case.bodies):
        _draw_body(axes, body, COLOURS[number % len(COLOURS)], named=len(case.bodies) > 1)
    _draw_cells(axes, case)
    _draw_interfaces(axes, case)
    for crack in case.cracks:
        _draw_crack(axes, crack)
        if len(case.cracks) <= MOST_NAMES:
            _name_crack(axes, crack, size, scale, unit, whole=len(case.cracks) <= MOST_WHOLE_NAMES)
    _draw_supports(axes, case, size, scale, unit)
    _draw_loads(axes, case, size)
    corner, below, left = np.array([high[0], low[1]]), np.array([0.0, -0.87 * margin]), np.array([-0.87 * margin, 0.0])
    dimension(axes, low, corner, below, f"{(high - low)[0] * scale:g} {unit}")
    dimension(axes, low, np.array([low[0], high[1]]), left, f"{(high - low)[1] * scale:g} {unit}")
    figure.suptitle(wrapped(f"{case.name}: {case.title}", figure), fontsize=9, y=0.995, va="top")
    write_atomically(path, lambda temporary: figure.savefig(temporary, format=path.suffix[1:].lower()))


def _draw_cells(axes: Axes, case: Case) -> None:
    """The cells before anything grows, inside of the bodies."""
    scene = make_scene(case)
    cells = first_cells(scene)
    corners = cells.low[:, None] + cells.size[:, None, None] * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    squares = scene.lattice.to_metres(corners / QUANTA)
    for body in case.bodies:
        low, high = body.outline.min(axis=0), body.outline.max(axis=0)
        near = np.all((squares.max(axis=1) > low) & (squares.min(axis=1) < high), axis=1)
        lines = PolyCollection(list(squares[near]), facecolors="none", edgecolors="0.55", linewidths=0.25, zorder=2.5)
        lines.set_clip_path(PathPatch(_shape(body), transform=axes.transData))
        axes.add_collection(lines)


def _shape(body: Body) -> LinePath:
    closed = [LinePath(np.vstack([ring.points, ring.points[:1]]), closed=True) for ring in body.rings]
    return LinePath.make_compound_path(*closed)


def _draw_body(axes: Axes, body: Body, colour: str, *, named: bool) -> None:
    axes.add_patch(PathPatch(_shape(body), facecolor=colour, edgecolor="0.2", linewidth=1.0, zorder=2))
    if named:
        low, high = body.outline.min(axis=0), body.outline.max(axis=0)
        label(axes, low + [0.12, 0.85] * (high - low), body.name, "0.35")


def _draw_interfaces(axes: Axes, case: Case) -> None:
    for interface in case.interfaces:
        bonded = isinstance(interface.contact, str)
        for line in interface.lines:
            axes.plot(*line.T, color="#762a83", linewidth=1.8, linestyle="-" if bonded else (0, (4, 1.5)), zorder=4)
        words = "bonded" if isinstance(interface.contact, str) else f"μ = {interface.contact.friction:g}"
        line = interface.lines[0]
        label(axes, line[0] + 0.8 * (line[-1] - line[0]), words, "#762a83")


def _draw_crack(axes: Axes, crack: Crack) -> None:
    """A thick line, and a dot at each end that can grow."""
    axes.plot(*crack.points.T, color="black", linewidth=2.0, solid_capstyle="round", zorder=6)
    for tip in _tips(crack).values():
        axes.plot(*tip, marker="o", markersize=4.0, markerfacecolor="white", markeredgecolor="black", zorder=7)


def _tips(crack: Crack) -> dict[str, Floats]:
    """The ends that can grow."""
    ends = (("start", crack.tip_at_start, crack.points[0]), ("end", crack.tip_at_end, crack.points[-1]))
    return {name: point for name, there, point in ends if there}


def _name_crack(axes: Axes, crack: Crack, size: float, scale: float, unit: str, *, whole: bool) -> None:
    """Say what a crack is, and which tip is which."""
    length = float(np.hypot(*np.diff(crack.points, axis=0).T).sum()) * scale
    law = "faces never touch" if crack.contact is None else f"μ = {crack.contact.friction:g}"
    chord = crack.points[-1] - crack.points[0]
    normal = np.array([-chord[1], chord[0]]) / max(float(np.hypot(*chord)), 1e-300)
    normal = normal if normal[1] >= 0 else -normal
    middle = crack.points[len(crack.points) // 2] if len(crack.points) > 2 else crack.points.mean(axis=0)
    words = f"{crack.name}: {length:.4g} {unit}\n{law}" if whole else crack.name  # narrow, as specimens are
    label(axes, middle + 0.03 * size * normal, words, ha=beside(normal), va="bottom" if normal[1] > STEEP else "center")
    for name, tip in _tips(crack).items() if whole else ():
        way = (chord if name == "end" else -chord) / max(float(np.hypot(*chord)), 1e-300)
        label(axes, tip + (0.02 + 0.01 * abs(way[1])) * size * way, name, "0.35", ha=beside(way))


def _draw_supports(axes: Axes, case: Case, size: float, scale: float, unit: str) -> None:
    for support in case.supports:
        if isinstance(support, PointSupport):
            roller = None in support.displacement
            triangle(axes, support.point, _outward_at(case, support), SIGN * size, roller=roller)
            _draw_given(axes, support.displacement, support.point, size, scale, unit)
            continue
        parts = _parts(case, support.region)
        for line, outward in parts:
            if isinstance(support, EdgeSupport) and not all(c is not None for c in support.displacement):
                rollers(axes, line, outward, 0.6 * SIGN * size)
            else:
                hatch(axes, line + 0.004 * size * outward, outward, 0.7 * SIGN * size)
        line, outward = parts[len(parts) // 2]
        if isinstance(support, ContactSupport):
            words = f"rigid foundation, μ = {support.contact.friction:g}"
            label(axes, line.mean(axis=0) + 0.075 * size * outward, words, "#762a83")
        else:
            _draw_given(axes, support.displacement, line.mean(axis=0) + 0.05 * size * outward, size, scale, unit)


def _outward_at(case: Case, support: PointSupport) -> Floats:
    """Where the ground of a support at a point is: across what it holds, away from the middle of the scene."""
    center = np.mean([body.outline.mean(axis=0) for body in case.bodies], axis=0)
    point, held = support.point, [component is not None for component in support.displacement]
    away = np.where(point >= center, 1.0, -1.0)
    if held == [True, False]:
        return np.array([away[0] if point[0] != center[0] else -1.0, 0.0])
    return np.array([0.0, 1.0 if point[1] > center[1] else -1.0])


def _draw_given(
    axes: Axes,
    displacement: tuple[Component | None, Component | None],
    place: Floats,
    size: float,
    scale: float,
    unit: str,
) -> None:
    """Displacements other than zero: their arrow or formula."""
    words = []
    for axis, value in zip("xy", displacement, strict=True):
        if isinstance(value, float | int) and value:
            words.append(f"u{axis} = {value * scale:.4g} {unit}")
        elif isinstance(value, CoordinateFormula):
            words.append(f"u{axis} = {value.text[:40]} [m]")
    if words:
        label(axes, place + np.array([0.0, 0.04 * size]), ", ".join(words), GIVEN)


def _draw_loads(axes: Axes, case: Case, size: float) -> None:
    notes = []
    for load in case.loads:
        held = ", held" if load.held else ""
        if isinstance(load, EdgeTraction):
            _draw_traction(axes, case, load, size, held)
        elif isinstance(load, Gravity):
            body = next(body for body in case.bodies if body.name == load.body)
            middle = (body.outline.min(axis=0) + body.outline.max(axis=0)) / 2
            way = np.array(load.acceleration) / max(float(np.hypot(*load.acceleration)), 1e-300)
            arrow(axes, middle, middle + ARROW * size * way, LOAD)
            label(axes, middle + 1.3 * ARROW * size * way, f"g = {np.hypot(*load.acceleration):g} m/s²{held}", LOAD)
        elif isinstance(load, FluidPressure):
            place = np.concatenate(lines_of(case, load.surface)).mean(axis=0) - [0.0, 0.06 * size]
            label(axes, place, f"p = {component_text(load.pressure)}{held}", LOAD)
        elif isinstance(load, PointForce):
            force = np.array(load.force)
            way = ARROW * size * force / max(float(np.hypot(*force)), 1e-300)
            arrow(axes, load.point - way, load.point, LOAD)
            label(axes, load.point - 1.3 * way, f"F = {np.hypot(*force):g} N/m{held}", LOAD)
        elif isinstance(load, InSituStress):
            values = ", ".join(component_text(value) for value in load.stress)
            notes.append(f"in-situ stress xx, yy, xy in {load.body}: {values}{held}")
    if notes:
        axes.text(
            0.02, 0.01, "\n".join(notes), transform=axes.transAxes, fontsize=7.5, color=LOAD, va="bottom", zorder=8
        )


def _draw_traction(axes: Axes, case: Case, load: EdgeTraction, size: float, held: str) -> None:
    """Arrows along an edge that push on it or pull at it, or, where they only shear it, run beside it."""
    parts = _parts(case, load.region)
    ends = np.concatenate([line for line, _ in parts])
    traction = _mean([component_at(component, ends) for component in load.traction])
    strength = float(np.hypot(*traction))
    if strength == 0.0:
        return
    way = ARROW * size * traction / strength
    lengths = np.array([float(np.hypot(*(line[1] - line[0]))) for line, _ in parts])
    shears = abs(float(way @ parts[len(parts) // 2][1])) < SHEAR * ARROW * size
    n = int(np.clip(round(lengths.sum() / ((0.14 if shears else 0.08) * size)), 2, 14))
    ends = np.cumsum(lengths)
    places = []
    for place in (np.arange(n) + 0.5) / n * ends[-1]:
        number = min(int(np.searchsorted(ends, place)), len(parts) - 1)
        line, outward = parts[number]
        places.append((line[1] - (ends[number] - place) / lengths[number] * (line[1] - line[0]), outward))
    held_points = [support for support in case.supports if isinstance(support, PointSupport)]
    signs = [support.point + 0.8 * SIGN * size * _outward_at(case, support) for support in held_points]
    free = [(p, o) for p, o in places if all(np.hypot(*(p - sign)) > 1.1 * SIGN * size for sign in signs)]
    gap = 0.03 if shears else 0.008 if free else 1.7 * SIGN  # where signs of supports leave no room: outside of them
    for point, outward in free or places:
        tail = point + gap * size * outward
        arrow_tail = tail - way / 2 if shears else tail - way if float(way @ outward) < 0 else tail
        arrow(axes, arrow_tail, arrow_tail + way, LOAD)
    line, outward = parts[len(parts) // 2]  # two loads on an edge are mostly one across and one along it
    away = (1.35 * ARROW + (0.0 if free else gap)) * size
    middle = line[0] + (0.25 if shears else 0.5) * (line[1] - line[0]) + away * outward
    given = ", ".join(f"t{axis}" for axis, value in zip("xy", traction, strict=True) if value)
    values = ", ".join(component_text(of) for of, value in zip(load.traction, traction, strict=True) if value)
    label(axes, middle, f"{given} = {values}{held}", LOAD, rotation=90.0 if abs(outward[0]) > SHEAR else 0.0)


def _mean(components: Sequence[Floats]) -> Floats:
    """The mean (2,) of two components at places; what it has no sign of is told by the largest value."""
    return np.array(
        [values.mean() if values.mean() != 0.0 else values[np.argmax(np.abs(values))] for values in components]
    )


def _parts(case: Case, region: EdgeRegion) -> list[tuple[Floats, Floats]]:
    """The straight parts of an edge, ends (2, 2) m, and their unit normals (2,) out of the rock."""
    body = next(body for body in case.bodies if body.name == region.body)
    starts = np.concatenate([ring.points for ring in body.rings])
    stops = np.concatenate([np.roll(ring.points, -1, axis=0) for ring in body.rings])
    found = []
    for side, limits in zip(region.sides, region.limits, strict=True):
        a, b = starts[side], stops[side]
        along = (b - a) / np.hypot(*(b - a))
        found.append((a + limits[:, None] * (b - a), np.array([along[1], -along[0]])))
    return found
