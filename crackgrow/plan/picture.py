"""A drawing of a case as an engineer makes it: bodies, cells, cracks, supports, loads with values, dimensions."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, PathPatch, Polygon
from matplotlib.transforms import Bbox

from crackgrow.arrays import Floats
from crackgrow.case.features import line_length
from crackgrow.case.model import Body, Case, Crack, FarField, InSituStress, Stages
from crackgrow.case.on_map import case_on_map
from crackgrow.cover.squares import QUANTA
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.results.atomic import write_atomically
from crackgrow.results.figures import body_path
from crackgrow.results.places import component_text, extent, length_unit
from crackgrow.results.signs import Arrow, Sign, Strokes, load_signs, support_signs
from crackgrow.results.signs import Polygon as Shape
from crackgrow.results.style import own_style, wrapped
from crackgrow.run.layout import cells_of
from crackgrow.run.scene import Scene, make_scene

MOST_NAMES, MOST_WHOLE_NAMES = 12, 2  # of more cracks none is named; of more the names alone are written
SIDE: Final = 6.5  # inches, the longer one of the scene
MARGIN = 0.27  # of the scene's size
NOTE = 0.035  # of the scene's size: a line of words below it
STEEP: Final = 0.6  # of the normal along y, from which words stand on what they name, not beside it
COLOURS: Final = ("#e6e1d8", "#d5dde6", "#dfe6d5", "#e6d5df")  # of bodies

LOAD = "#b2182b"
LAW = "#762a83"
KIND_COLOURS = {"support": "0.25", "ground": "0.25", "hatch": "0.25", "load": LOAD, "given": "#1b7837", "law": LAW}
WIDTHS = {"ground": 1.2, "hatch": 0.6}  # points, of lines

LABEL: Final = "label"  # of words that may be moved
CLEAR: Final = 7.0  # pixels on every side of a place that words leave free
LINE: Final = 26.0  # pixels from one place for words to the next
_TURNS = np.arange(16) * np.pi / 8.0
PLACES: Final = [np.zeros(2), *(n * np.array([np.cos(turn), np.sin(turn)]) for n in range(1, 9) for turn in _TURNS)]
"""Where words may go, the nearest first, in LINEs."""

_ARROW = {"shrinkA": 0.0, "shrinkB": 0.0}  # from the very tail to the very head


@own_style()
def draw_scene(path: Path, case: Case) -> None:
    """Draw the case into a .png or .svg file; raises OutputError."""
    scene, case = make_scene(case), case_on_map(case)
    scale, unit = length_unit(case)
    low, high = extent(case)
    size = float((high - low).max())
    margin = MARGIN * size
    notes = _notes(case)
    bottom = low - margin - [0.0, NOTE * size * len(notes)]
    box = high + margin - bottom
    figure = Figure(figsize=tuple(SIDE * box / box.max() + [0.0, 0.35]), dpi=150)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0 - 0.35 / figure.get_figheight()))
    axes.set(xlim=(bottom[0], high[0] + margin), ylim=(bottom[1], high[1] + margin), aspect="equal")
    axes.set_axis_off()
    for number, body in enumerate(case.bodies):
        _draw_body(axes, body, COLOURS[number % len(COLOURS)], named=len(case.bodies) > 1)
    _draw_cells(axes, case, scene)
    _draw_interfaces(axes, case)
    for crack in case.cracks:
        _draw_crack(axes, crack)
        if len(case.cracks) <= MOST_NAMES:
            _name_crack(axes, crack, size, scale, unit, whole=len(case.cracks) <= MOST_WHOLE_NAMES)
    for sign in (*support_signs(case), *load_signs(case)):
        draw_sign(axes, sign)
    tips = [np.stack(list(ends)) for ends in (_tips(crack).values() for crack in case.cracks) if ends]
    part_labels(axes, np.concatenate([np.zeros((0, 2)), *tips, *(line for i in case.interfaces for line in i.lines)]))
    axes.text(0.02, 0.01, "\n".join(notes), fontsize=7.5, color=LOAD, va="bottom", zorder=8, transform=axes.transAxes)
    corner, below, left = np.array([high[0], low[1]]), np.array([0.0, -0.87 * margin]), np.array([-0.87 * margin, 0.0])
    dimension(axes, low, corner, below, f"{(high - low)[0] * scale:g} {unit}")
    dimension(axes, low, np.array([low[0], high[1]]), left, f"{(high - low)[1] * scale:g} {unit}")
    figure.suptitle(wrapped(f"{case.name}: {case.title}", figure), fontsize=9, y=0.995, va="top")
    write_atomically(path, lambda temporary: figure.savefig(temporary, format=path.suffix[1:].lower()))


def _draw_cells(axes: Axes, case: Case, scene: Scene) -> None:
    """The cells before anything grows, inside of the bodies."""
    cells = cells_of(scene, tuple(map(GrowingCrack.given, scene.case.cracks)))
    corners = cells.low[:, None] + cells.size[:, None, None] * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    squares = scene.lattice.to_map(corners / QUANTA)
    for body in case.bodies:
        low, high = body.outline.min(axis=0), body.outline.max(axis=0)
        near = np.all((squares.max(axis=1) > low) & (squares.min(axis=1) < high), axis=1)
        lines = PolyCollection(list(squares[near]), facecolors="none", edgecolors="0.55", linewidths=0.25, zorder=2.5)
        lines.set_clip_path(PathPatch(body_path(body), transform=axes.transData))
        axes.add_collection(lines)


def _draw_body(axes: Axes, body: Body, colour: str, *, named: bool) -> None:
    axes.add_patch(PathPatch(body_path(body), facecolor=colour, edgecolor="0.2", linewidth=1.0, zorder=2))
    if named:
        low, high = body.outline.min(axis=0), body.outline.max(axis=0)
        label(axes, low + [0.12, 0.85] * (high - low), body.name, "0.35")


def _draw_interfaces(axes: Axes, case: Case) -> None:
    for interface in case.interfaces:
        bonded = isinstance(interface.contact, str)
        for line in interface.lines:
            axes.plot(*line.T, color=LAW, linewidth=1.8, linestyle="-" if bonded else (0, (4, 1.5)), zorder=4)
        words = "bonded" if isinstance(interface.contact, str) else f"μ = {interface.contact.friction:g}"
        line = interface.lines[0]
        label(axes, line[0] + 0.8 * (line[-1] - line[0]), words, LAW)


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
    length = line_length(crack.points) * scale
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


def _notes(case: Case) -> list[str]:
    """What has no place of its own: stresses in bodies and round them, and stages in which bodies are taken out."""
    notes = [
        f"{'in-situ stress' if isinstance(load, InSituStress) else 'far-field stress'} xx, yy, xy in {load.body}: "
        f"{', '.join(component_text(value) for value in load.stress)}{', held' if load.held else ''}"
        for load in case.loads
        if isinstance(load, InSituStress | FarField)
    ]
    if isinstance(case.loading, Stages):
        for body in case.bodies:
            gone = [stage.name for stage in case.loading.stages if body.name in dict(stage.excavated)]
            notes += [f"{body.name} is taken out in stage '{gone[0]}'"] if gone else []
    return notes


def draw_sign(axes: Axes, sign: Sign) -> None:
    """The marks and the words of a support or a load."""
    for mark in sign.marks:
        colour, width = KIND_COLOURS[mark.kind], WIDTHS.get(mark.kind, 1.0)
        if isinstance(mark, Arrow):
            style = {**_ARROW, "arrowstyle": "-|>", "color": colour, "linewidth": 0.9, "mutation_scale": 7}
            head, tail = mark.head.tolist(), mark.tail.tolist()
            axes.annotate("", head, tail, arrowprops=style, zorder=6, annotation_clip=False)
        elif isinstance(mark, Strokes):
            lines = LineCollection(list(mark.ends), colors=colour, linewidths=width, capstyle="butt", zorder=5)
            axes.add_collection(lines)
        else:
            patch: Patch
            patch = Polygon(mark.corners) if isinstance(mark, Shape) else Circle(mark.center.tolist(), mark.radius)
            patch.set(facecolor="white", edgecolor=colour, linewidth=width, zorder=5)
            axes.add_patch(patch)
    for words in sign.words:
        label(axes, words.place, words.text, KIND_COLOURS[words.kind], rotation=90.0 if words.upright else 0.0)


def label(axes: Axes, point: Floats, text: str, colour: str = "black", **looks: Any) -> None:
    """Small words on a white ground, centred unless `looks` say otherwise; `part_labels` may move them."""
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
    looks = {"ha": "center", "va": "center", **looks}
    axes.text(point[0], point[1], text, fontsize=7.5, color=colour, zorder=8, bbox=ground, gid=LABEL, **looks)


def part_labels(axes: Axes, free: Floats) -> None:
    """Move words that lie on others, or on places (n, 2) to be left free, to where there is room; a line leads back."""
    renderer = FigureCanvasAgg(axes.get_figure(root=True)).get_renderer()
    to_pixels, picture = axes.transData, axes.get_window_extent(renderer)
    taken = [Bbox.from_extents(*(place - CLEAR), *(place + CLEAR)) for place in to_pixels.transform(free)]
    for words in [text for text in axes.texts if text.get_gid() == LABEL]:
        box = words.get_window_extent(renderer)
        for away in PLACES:
            there = box.translated(*(away * LINE))
            if picture.containsx(there.x0) and picture.containsx(there.x1) and not there.count_overlaps(taken):
                break
        else:
            away, there = PLACES[0], box
        taken.append(there)
        if away.any():
            start = np.array(words.get_position())
            end = to_pixels.inverted().transform(to_pixels.transform(start) + away * LINE)
            words.set_position((float(end[0]), float(end[1])))
            axes.plot(*np.stack([start, end], axis=1), color="0.6", linewidth=0.5, zorder=7.5)


def beside(direction: Floats) -> str:
    """How words are aligned that stand in a direction (2,), a unit vector, from something, and leave it free."""
    return "center" if abs(direction[0]) < 0.3 else "left" if direction[0] > 0 else "right"


def dimension(axes: Axes, a: Floats, b: Floats, offset: Floats, text: str) -> None:
    """A dimension line of the distance from a to b, moved by `offset`, with extension lines and its value."""
    for end in (a, b):
        far = end + 1.12 * offset
        near = end + 0.35 * offset
        axes.plot([near[0], far[0]], [near[1], far[1]], color="0.55", linewidth=0.5, zorder=1)
    start, stop = a + offset, b + offset
    style = {**_ARROW, "arrowstyle": "<|-|>", "color": "0.35", "linewidth": 0.6, "mutation_scale": 6}
    axes.annotate("", (stop[0], stop[1]), (start[0], start[1]), arrowprops=style, zorder=2, annotation_clip=False)
    upright = abs(b[1] - a[1]) > abs(b[0] - a[0])
    middle = (start + stop) / 2
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    axes.text(middle[0], middle[1], text, fontsize=7.5, color="0.25", ha="center", va="center", zorder=3,
              bbox=ground, rotation=90 if upright else 0)  # fmt: skip
