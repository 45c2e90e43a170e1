"""Signs of structural drawings: triangles, rollers, hatching, arrows, dimensions. Lengths are those of the axes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from crackgrow.arrays import Floats

SUPPORT = "0.25"
LOAD = "#b2182b"
GIVEN = "#1b7837"  # prescribed displacements that are not zero


_ARROW = {"shrinkA": 0.0, "shrinkB": 0.0}  # from the very tail to the very head


def triangle(axes: Axes, point: Floats, outward: Floats, size: float, *, roller: bool) -> None:
    """A support at a point: a triangle towards `outward` (2,), a unit vector, on ground or, as a roller, on wheels."""
    along = np.array([-outward[1], outward[0]])
    base = point + size * outward
    corners = [point, base + 0.6 * size * along, base - 0.6 * size * along]
    axes.add_patch(Polygon(corners, closed=True, facecolor="white", edgecolor=SUPPORT, linewidth=1.0, zorder=5))
    if roller:
        for place in (-0.35, 0.35):
            center = base + 0.18 * size * outward + place * size * along
            axes.add_patch(Circle((center[0], center[1]), 0.17 * size, facecolor="white", edgecolor=SUPPORT, zorder=5))
        base = base + 0.36 * size * outward
    hatch(axes, np.array([base - 0.9 * size * along, base + 0.9 * size * along]), outward, 0.35 * size)


def hatch(axes: Axes, line: Floats, outward: Floats, size: float) -> None:
    """Solid ground: a line (2, 2) with strokes on its outer side."""
    (x0, y0), (x1, y1) = line
    axes.plot([x0, x1], [y0, y1], color=SUPPORT, linewidth=1.2, zorder=5, solid_capstyle="butt")
    along = line[1] - line[0]
    length = float(np.hypot(*along))
    n = max(2, round(length / (0.9 * size)))
    slant = (outward - along / max(length, 1e-300)) * size
    for place in (np.arange(n) + 0.75) / n:
        a = line[0] + place * along
        axes.plot([a[0], a[0] + slant[0]], [a[1], a[1] + slant[1]], color=SUPPORT, linewidth=0.6, zorder=4)


def rollers(axes: Axes, line: Floats, outward: Floats, size: float) -> None:
    """An edge (2, 2) that slides along rigid ground: wheels between the two."""
    along = line[1] - line[0]
    n = max(2, round(float(np.hypot(*along)) / (2.0 * size)))
    for place in (np.arange(n) + 0.5) / n:
        x, y = line[0] + place * along + 0.5 * size * outward
        axes.add_patch(Circle((x, y), 0.4 * size, facecolor="white", edgecolor=SUPPORT, linewidth=0.8, zorder=5))
    hatch(axes, line + size * outward, outward, 0.8 * size)


def arrow(axes: Axes, tail: Floats, head: Floats, colour: str) -> None:
    """A straight arrow."""
    style = {**_ARROW, "arrowstyle": "-|>", "color": colour, "linewidth": 0.9, "mutation_scale": 7}
    axes.annotate("", (head[0], head[1]), (tail[0], tail[1]), arrowprops=style, zorder=6, annotation_clip=False)


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
