"""Signs, words and dimensions by matplotlib. Lengths are those of the axes."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.transforms import Bbox

from crackgrow.arrays import Floats
from crackgrow.results.signs import Arrow, Sign, Strokes
from crackgrow.results.signs import Polygon as Shape

LOAD = "#b2182b"
LAW = "#762a83"
COLOURS = {"support": "0.25", "ground": "0.25", "hatch": "0.25", "load": LOAD, "given": "#1b7837", "law": LAW}
WIDTHS = {"ground": 1.2, "hatch": 0.6}  # points, of lines

LABEL: Final = "label"  # of words that may be moved
CLEAR: Final = 7.0  # pixels on every side of a place that words leave free
LINE: Final = 26.0  # pixels from one place for words to the next
_TURNS = np.arange(16) * np.pi / 8.0
AWAY: Final = [np.zeros(2), *(n * np.array([np.cos(turn), np.sin(turn)]) for n in range(1, 9) for turn in _TURNS)]
"""Where words may go, the nearest first, in LINEs."""

_ARROW = {"shrinkA": 0.0, "shrinkB": 0.0}  # from the very tail to the very head


def draw_sign(axes: Axes, sign: Sign) -> None:
    """The marks and the words of a support or a load."""
    for mark in sign.marks:
        colour, width = COLOURS[mark.kind], WIDTHS.get(mark.kind, 1.0)
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
        label(axes, words.place, words.text, COLOURS[words.kind], rotation=90.0 if words.upright else 0.0)


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
        for away in AWAY:
            there = box.translated(*(away * LINE))
            if picture.containsx(there.x0) and picture.containsx(there.x1) and not there.count_overlaps(taken):
                break
        else:
            away, there = AWAY[0], box
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
