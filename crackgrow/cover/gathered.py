"""Tip functions gathered: few coefficients for a whole tip, in place of one for every patch that the tip lies in.

    u_tip = sum_k F_k sum_i chi_i phi_i (a_k + b_k x_i + c_k y_i),    chi_i = (1 - (r_i/R)^4)^2,

over the patches i with nodes nearer than R to the tip, those that the crack cuts through too; x_i, y_i, r_i from the
tip (after Laborde et al. 2005, who gather, and Chahine et al. 2008, who fade out). Patches that hold the tip have no
jump of their own, and the four functions alone, constant round the tip, miss that of the next term, r^(3/2). Errors of
K where the tip lies worst in its cell, cells of a fifth of the crack's half length: 1 % with a_k alone and R of four
cells; with b_k and c_k 1.4e-3 at four cells, 2e-4 at five, which is that of one coefficient for every patch.
"""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.elements import Elements
from crackgrow.cover.patches import Patches
from crackgrow.cover.tips import Carriers, TipView, seen_from_tip

RADIUS = 5.0
"""R, sides of the cells at the tip."""

STRAIGHT = 2.0
"""Sides of cells: the length that the last segment has at least. With a kink of 60 degrees 1.2 cells behind the tip
K is 0.1 % worse than with functions on every patch, from 2 cells on it is the same."""

OUTLINE = -1
"""In place of a line's number."""


Surroundings = tuple[shapely.STRtree, Ints]
"""Tree over the edges on lines and outlines, and the number (edges,) of the line that each lies on, or `OUTLINE`."""


def surroundings(elements: Elements) -> Surroundings:
    """What there is round tips among these elements."""
    ends = [*(line.points for line in elements.lines), elements.outlines.points]
    line = np.repeat([*range(len(elements.lines)), OUTLINE], [len(some) for some in ends])
    return shapely.STRtree(shapely.linestrings(np.concatenate(ends))), line


def gathered(
    around: Surroundings, patches: Patches, crack: int, points: Floats, size: float
) -> tuple[TipView, Carriers] | None:
    """The functions of the tip of a crack given by its vertices (n, 2) from the tip on; None where it has no room.

    Nothing but its own crack may be nearer than R, and as far as the functions are seen that must be one line. With
    an outline or another crack at 0.4 R K is 0.1 to 0.2 % worse than with functions on every patch, at 0.25 R 1 %.
    """
    (edges, line), radius = around, RADIUS * size
    near = edges.query(shapely.Point(points[0]), predicate="dwithin", distance=radius)
    if (line[near] != crack).any() or np.hypot(*(points[1] - points[0])) < STRAIGHT * size:
        return None
    off = patches.nodes[: patches.n_of_lattice] - points[0]
    mine = np.flatnonzero((off**2).sum(axis=1) <= radius**2)
    off = off[mine]
    distance = np.hypot(*off.T)
    reach = float((distance + np.sqrt(2.0) * patches.half[mine]).max())
    view = seen_from_tip(points, reach, ends_inside=True)
    if np.isfinite(view.fade):
        return None
    fading = np.maximum(1.0 - (distance / radius) ** 4, 0.0) ** 2
    shares = fading * np.stack([np.ones(len(mine)), *(off.T / size)])
    return view, Carriers(np.tile(mine, 3), shares.ravel(), np.repeat(np.arange(3), len(mine)), reach)
