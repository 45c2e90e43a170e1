"""Signs of engineering drawings as SVG: arrows, supports, ground. All lengths are pixels, y downwards."""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results.report.markup import Markup, join, tag
from crackgrow.results.report.view import line_data

ARROW = 30.0  # length of an arrow
HEAD = (7.0, 3.0)  # length and half width of its head
ARROW_GAP = 24.0  # from arrow to arrow along an edge
TRIANGLE = (12.0, 7.0)  # height and half base of a support
HATCH = (6.0, 5.0)  # from hatch to hatch, and how far it goes down
ROLLER = 3.0  # radius


def arrow(tail: Floats, head: Floats) -> Markup:
    """An arrow between two points (2,)."""
    along = (head - tail) / np.linalg.norm(head - tail)
    across = np.array([-along[1], along[0]])
    neck = head - HEAD[0] * along
    tip = [head, neck + HEAD[1] * across, neck - HEAD[1] * across]
    shaft = tag("path", d=line_data([tail, neck]), class_="shaft")
    return join([shaft, tag("path", d=line_data(tip, closed=True), class_="head")])


def arrows_along(line: Floats, direction: Floats, outward: Floats) -> Markup:
    """Arrows along a line (n, 2) in a direction (2,), that push on it where they point against `outward`, else pull."""
    unit = direction / np.linalg.norm(direction)
    reach = ARROW * unit
    drawn = []
    for place in spaced(line, ARROW_GAP):
        tail = place - reach if unit @ outward < -1e-9 else place
        if abs(unit @ outward) <= 1e-9:  # along the edge: beside it, centred
            tail = place - reach / 2 + 5.0 * outward
        drawn.append(arrow(tail, tail + reach))
    return join(drawn)


def triangle(place: Floats, outward: Floats, rolls: bool) -> Markup:
    """A support whose apex is at `place`; on rollers, or else on hatched ground."""
    across = np.array([-outward[1], outward[0]])
    base = place + TRIANGLE[0] * outward
    corners = [place, base + TRIANGLE[1] * across, base - TRIANGLE[1] * across]
    foot = base + (2.0 if rolls else 0.0) * outward
    ends = np.array([foot - 1.4 * TRIANGLE[1] * across, foot + 1.4 * TRIANGLE[1] * across])
    below = tag("path", d=line_data(ends), class_="ground") if rolls else ground(ends, outward)
    return join([tag("path", d=line_data(corners, closed=True), class_="support"), below])


def rollers(line: Floats, outward: Floats) -> Markup:
    """Rollers along a line (n, 2), with ground behind them."""
    circles = [tag("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r=ROLLER, class_="support")
               for x, y in spaced(line, 4 * ROLLER) + ROLLER * outward]  # fmt: skip
    return join([*circles, ground(line + 2 * ROLLER * outward, outward)])


def ground(line: Floats, outward: Floats) -> Markup:
    """A line (n, 2) with hatches on the side that `outward` (2,) points to."""
    across = np.array([-outward[1], outward[0]])
    hatches = [line_data([place, place + HATCH[1] * (outward - across)]) for place in spaced(line, HATCH[0])]
    return join([tag("path", d=line_data(line), class_="ground"), tag("path", d="".join(hatches), class_="hatch")])


def spaced(line: Floats, gap: float) -> Floats:
    """Points (k, 2) on a line (n, 2), about `gap` apart and half of that from its ends; at least one."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    count = max(1, round(lengths[-1] / gap))
    places = (np.arange(count) + 0.5) * lengths[-1] / count
    return np.column_stack([np.interp(places, lengths, line[:, 0]), np.interp(places, lengths, line[:, 1])])
