"""A drawing of a scene as an engineer makes it: bodies, cells, cracks, supports, loads with values, dimensions.

`draw_scene` makes a file of it for `check`, `scene_svg` the picture of a report, whose groups have ids by steps.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from markupsafe import Markup
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.transforms import Bbox

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Body, Case, Crack, FarField, InSituStress, Stages
from crackgrow.case.on_map import case_on_map, extent, length_unit
from crackgrow.case.segments import line_length
from crackgrow.results.atomic import write_atomically
from crackgrow.results.run import Run
from crackgrow.results.signs import LAW, LOAD, Sheet
from crackgrow.results.style import give_title, own_style
from crackgrow.results.units import component_text

MOST_NAMES, MOST_WHOLE_NAMES = 12, 2  # of more cracks none is named; of more the names alone are written
SIDE, SIDE_OF_PAGE = 6.5, 4.5  # inches, the longer one of the scene: words are larger beside it on a page
MARGIN = 0.27  # of the scene's size
NOTE = 0.035  # of the scene's size: a line of words below it, in a figure of SIDE
STEEP: Final = 0.6  # of the normal along y, from which words stand on what they name, not beside it
COLOURS: Final = ("#e6e1d8", "#d5dde6", "#dfe6d5", "#e6d5df")  # of bodies
PALEST: Final = 0.85  # of the colour map: what is beyond is lost on the rock

CLEAR: Final = 7.0  # pixels on every side of a place that words leave free
LINE: Final = 26.0  # pixels from one place for words to the next
_TURNS = np.arange(16) * np.pi / 8.0
PLACES: Final = [np.zeros(2), *(n * np.array([np.cos(turn), np.sin(turn)]) for n in range(1, 9) for turn in _TURNS)]
"""Where words may go, the nearest first, in LINEs."""


@own_style()
def draw_scene(path: Path, case: Case, squares: Floats) -> None:
    """Draw the case into a .png or .svg file, with cells whose corners are (n, 4, 2) m; raises OutputError."""
    case = case_on_map(case)
    figure, sheet = _begun(case, SIDE, f"{case.name}: {case.title}")
    for body in case.bodies:
        low, high = body.outline.min(axis=0), body.outline.max(axis=0)
        near = np.all((squares.max(axis=1) > low) & (squares.min(axis=1) < high), axis=1)
        lines = PolyCollection(list(squares[near]), facecolors="none", edgecolors="0.55", linewidths=0.25, zorder=2.5)
        lines.set_clip_path(PathPatch(body_path(body), transform=sheet.axes.transData))
        sheet.axes.add_collection(lines, autolim=False)
    for crack in case.cracks:
        sheet.axes.plot(*crack.points.T, color="black", linewidth=2.0, solid_capstyle="round", zorder=6)
        for tip in _tips(crack).values():
            sheet.axes.plot(*tip, "o", markersize=4.0, markerfacecolor="white", markeredgecolor="black", zorder=7)
        if len(case.cracks) <= MOST_NAMES:
            _name_crack(sheet, crack, whole=len(case.cracks) <= MOST_WHOLE_NAMES)
    tips = [np.stack(list(ends)) for ends in (_tips(crack).values() for crack in case.cracks) if ends]
    part_labels(sheet, np.concatenate([np.zeros((0, 2)), *tips, *(line for i in case.interfaces for line in i.lines)]))
    looks: dict[str, Any] = {"format": path.suffix[1:].lower(), "metadata": {"Date": None}}  # the same at any time
    write_atomically(path, lambda temporary: figure.savefig(temporary, **looks))


@own_style()
def scene_svg(run: Run, steps: Iterable[int]) -> Markup:
    """The scene with its cracks at the end, as SVG.

    What step N has made is in a group `step-N`, the given cracks in `step-0`. For each of `steps` its tips are in a
    hidden group `tips-N`, filled where they advance. A sign is named where the pointer rests on it.
    """
    case = case_on_map(run.case)
    figure, sheet = _begun(case, SIDE_OF_PAGE)
    cracks = run.table("paths").by("crack").values()
    lines = [(np.column_stack([of["x"], of["y"]]), of["step"]) for of in cracks]
    if not lines:  # nothing was solved: the cracks are those given
        lines = [(crack.points, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks]
    draw_steps(sheet.axes, lines)
    of_steps = run.table("tips").by("step")
    for step in steps:
        tips = of_steps[(step,)]
        fills = ["#f0a202" if advanced else "white" for advanced in tips["advanced"]]
        looks: dict[str, Any] = {
            "s": 14,
            "c": fills,
            "edgecolors": "black",
            "linewidths": 0.8,
            "zorder": 7.2,
            "gid": f"tips-{step}",
        }
        sheet.axes.scatter(tips["x"], tips["y"], **looks)
    part_labels(sheet, np.concatenate([np.zeros((0, 2)), *(points for points, _ in lines)]))
    file = io.StringIO()
    figure.savefig(file, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    text = file.getvalue()
    text = text[text.index("<svg") :].replace('<g id="tips-', '<g hidden="" id="tips-')
    text = re.sub(r'<g id="title: (.*?)">', r"<g><title>\1</title>", text)  # in place of ids, which are not one each
    label = Markup("{}: specimen, supports, loads and cracks").format(run.case.title)
    return Markup(text.replace("<svg", f'<svg id="scene" role="img" aria-label="{label}"', 1))


def draw_steps(axes: Axes, cracks: Sequence[tuple[Floats, Ints]], scale: float = 1.0) -> None:
    """Draw lines (n, 2) m times a factor, what each step (n,) has made in its colour and in a group `step-N`."""
    last = max((int(steps.max()) for _, steps in cracks), default=1)
    segments: dict[int, list[Floats]] = {}
    for points, steps in cracks:
        for start, step in enumerate(np.maximum(steps[:-1], steps[1:]).tolist()):  # that of its younger vertex
            segments.setdefault(step, []).append(scale * points[start : start + 2])
    for step, parts in sorted(segments.items()):
        colour, width = (step_colour(step, last), 1.8) if step else ("black", 2.2)
        looks: dict[str, Any] = {"colors": colour, "linewidths": width, "capstyle": "round", "gid": f"step-{step}"}
        axes.add_collection(LineCollection(parts, zorder=7 - step / (last + 1), **looks), autolim=False)


def step_colour(step: int, last: int) -> str:
    """Colour of what step `step` of 1..last has made."""
    return to_hex(colormaps["plasma"](0.05 + (PALEST - 0.05) * (step - 1) / max(last - 1, 1)))


def body_path(body: Body, scale: float = 1.0) -> Outline:
    """The outline of a body and its holes, in metres times a factor."""
    closed = [Outline(np.vstack([ring.points, ring.points[:1]]) * scale, closed=True) for ring in body.rings]
    return Outline.make_compound_path(*closed)


def _begun(case: Case, side: float, title: str = "") -> tuple[Figure, Sheet]:
    """A figure of all but cells and cracks."""
    low, high = extent(case)
    size, (scale, unit), notes = float((high - low).max()), length_unit(case), _notes(case)
    margin = MARGIN * size
    bottom = low - margin - [0.0, NOTE * SIDE / side * size * len(notes)]
    box, head = high + margin - bottom, 0.35 if title else 0.0
    figure = Figure(figsize=tuple(side * box / box.max() + [0.0, head]), dpi=150)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0 - head / figure.get_figheight()))
    axes.set(xlim=(bottom[0], high[0] + margin), ylim=(bottom[1], high[1] + margin), aspect="equal")
    axes.set_axis_off()
    sheet = Sheet(axes, case, size)
    for number, body in enumerate(case.bodies):
        colour, outline = COLOURS[number % len(COLOURS)], body_path(body)
        axes.add_patch(PathPatch(outline, facecolor=colour, edgecolor="0.2", linewidth=1.0, zorder=2, **sheet.titled))
        if len(case.bodies) > 1:
            first, last = body.outline.min(axis=0), body.outline.max(axis=0)
            sheet.label(first + [0.12, 0.85] * (last - first), body.name, "0.35")
    for interface in case.interfaces:
        bonded = isinstance(interface.contact, str)
        for line in interface.lines:
            axes.plot(*line.T, color=LAW, linewidth=1.8, linestyle="-" if bonded else (0, (4, 1.5)), zorder=4)
        words = "bonded" if isinstance(interface.contact, str) else f"μ = {interface.contact.friction:g}"
        for line in interface.lines[:1]:
            sheet.label(line[0] + 0.8 * (line[-1] - line[0]), words, LAW)
    for support in case.supports:
        sheet.draw_support(support)
    for load in case.loads:
        sheet.draw_load(load)
    axes.text(0.02, 0.01, "\n".join(notes), fontsize=7.5, color=LOAD, va="bottom", zorder=8, transform=axes.transAxes)
    corner, below, left = np.array([high[0], low[1]]), np.array([0.0, -0.87 * margin]), np.array([-0.87 * margin, 0.0])
    _dimension(axes, low, corner, below, f"{(high - low)[0] * scale:g} {unit}")
    _dimension(axes, low, np.array([low[0], high[1]]), left, f"{(high - low)[1] * scale:g} {unit}")
    give_title(figure, title, size=9.0)
    return figure, sheet


def _tips(crack: Crack) -> dict[str, Floats]:
    """The ends that can grow."""
    ends = (("start", crack.tip_at_start, crack.points[0]), ("end", crack.tip_at_end, crack.points[-1]))
    return {name: point for name, there, point in ends if there}


def _name_crack(sheet: Sheet, crack: Crack, *, whole: bool) -> None:
    """Say what a crack is, and which tip is which."""
    scale, unit = length_unit(sheet.case)
    length = line_length(crack.points) * scale
    law = "faces never touch" if crack.contact is None else f"μ = {crack.contact.friction:g}"
    chord = crack.points[-1] - crack.points[0]
    normal = np.array([-chord[1], chord[0]]) / max(float(np.hypot(*chord)), 1e-300)
    normal = normal if normal[1] >= 0 else -normal
    middle = crack.points[len(crack.points) // 2] if len(crack.points) > 2 else crack.points.mean(axis=0)
    words = f"{crack.name}: {length:.4g} {unit}\n{law}" if whole else crack.name  # narrow, as specimens are
    upright = "bottom" if normal[1] > STEEP else "center"
    sheet.label(middle + 0.03 * sheet.size * normal, words, ha=_beside(normal), va=upright)
    for name, tip in _tips(crack).items() if whole else ():
        way = (chord if name == "end" else -chord) / max(float(np.hypot(*chord)), 1e-300)
        sheet.label(tip + (0.02 + 0.01 * abs(way[1])) * sheet.size * way, name, "0.35", ha=_beside(way))


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


def part_labels(sheet: Sheet, free: Floats) -> None:
    """Move words that lie on others, or on places (n, 2) to be left free, to where there is room; a line leads back."""
    axes = sheet.axes
    renderer = FigureCanvasAgg(axes.get_figure(root=True)).get_renderer()
    to_pixels, picture = axes.transData, axes.get_window_extent(renderer)
    taken = [Bbox.from_extents(*(place - CLEAR), *(place + CLEAR)) for place in to_pixels.transform(free)]
    for words in sheet.labels:
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


def _beside(direction: Floats) -> str:
    """How words are aligned that stand in a direction (2,), a unit vector, from something, and leave it free."""
    return "center" if abs(direction[0]) < 0.3 else "left" if direction[0] > 0 else "right"


def _dimension(axes: Axes, a: Floats, b: Floats, offset: Floats, text: str) -> None:
    """A dimension line of the distance from a to b, moved by `offset`, with extension lines and its value."""
    for end in (a, b):
        axes.plot(*np.stack([end + 0.35 * offset, end + 1.12 * offset], axis=1), color="0.55", linewidth=0.5, zorder=1)
    start, stop = a + offset, b + offset
    style = {"shrinkA": 0.0, "shrinkB": 0.0, "arrowstyle": "<|-|>", "color": "0.35", "linewidth": 0.6}
    style |= {"mutation_scale": 6}
    axes.annotate("", stop.tolist(), start.tolist(), arrowprops=style, zorder=2, annotation_clip=False)
    upright = abs(b[1] - a[1]) > abs(b[0] - a[0])
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    looks: dict[str, Any] = {"fontsize": 7.5, "color": "0.25", "ha": "center", "va": "center", "bbox": ground}
    middle = (start + stop) / 2
    axes.text(middle[0], middle[1], text, zorder=3, rotation=90 if upright else 0, **looks)
