"""Signs, words and dimensions by matplotlib. Lengths are those of the axes."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Circle, Patch, Polygon

from crackgrow.arrays import Floats
from crackgrow.results.signs import Arrow, Sign, Strokes
from crackgrow.results.signs import Polygon as Shape

LOAD = "#b2182b"
LAW = "#762a83"
COLOURS = {"support": "0.25", "ground": "0.25", "hatch": "0.25", "load": LOAD, "given": "#1b7837", "law": LAW}
WIDTHS = {"ground": 1.2, "hatch": 0.6}  # points, of lines

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


def label(
    axes: Axes,
    point: Floats,
    text: str,
    colour: str = "black",
    ha: str = "center",
    va: str = "center",
    rotation: float = 0.0,
) -> None:
    """Small words on a white ground."""
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
    axes.text(
        point[0],
        point[1],
        text,
        fontsize=7.5,
        color=colour,
        zorder=8,
        bbox=ground,
        ha=ha,
        va=va,
        rotation=rotation,
    )


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
