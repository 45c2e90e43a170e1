"""Mortar nodes: contact points about a cell apart, for averages over the faces weighted with functions N_k.

Along a stretch of length L, in cells (`Surface.in_cells`), the nodes are equally far apart, d, with a constant piece
f_0 d and f_1 d long at its ends:

    n = floor(L / d_min - f_0 - f_1) + 1,    d = L / (n - 1 + f_0 + f_1).

The functions are hats, linear in the arc length, so that a linear pressure is met. Only between a rim and the node next
to it they are the biorthogonal pair 2 - 3 x and 3 x - 1 (x from 0 to 1 along the piece; Wohlmuth 2000, SIAM J. Numer.
Anal. 38, 989-1012): the force of the node on the rim then acts at the rim, and a block topples when its weight passes
over its edge. Of a hat it would act a third of d inside. Rims are the corners of bodies, too, where interfaces meet or
a crack ends on one, as at the foot of columns that stand side by side, and those of rock where one crack ends on
another, along the one that goes on. Nodes on all rims where cracks meet nearly repeat each other: a uniform stress
comes through cracks that stick to 5e-4 only. So the crack that ends has none there, nor have cracks that cross, or all
end.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.faces import (
    ContactFaces,
    Functions,
    Part,
    integration_points,
    joined_faces,
    neighbours,
    stretch_ends,
)
from crackgrow.cover.cover import Cover, Surface
from crackgrow.cover.shapes import ends_at_bonds
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.geometry.tolerance import SAME_PLACE

RIM, KINK, JUNCTION, TIP, BARE_KINK = range(5)
"""What a stretch can end at. A bare kink is one without a node; a junction that is a rim, and has room, is a rim."""

END_PIECE = np.array([0.0, 0.0, 0.5, 1.0, 1.0])
"""Length of the constant piece over the distance of the nodes; at junctions, unlike at tips, faces move."""

KINK_ROOM = 2.0
"""Cells: a stretch has a node on its kink with a neighbour that is at least this long.

Closed faces on both sides of a kink can hardly move there: without the node K_I of a closed wing of 2 to 5 cells is
off by 30 to 40 % of the flaw's K, with it by 2 to 10 %. Next to a shorter wing that opens, the node would keep the flaw
closed farther than the lattice can follow: K_II of a wing of half a cell would be off by 6 % instead of 0.2 %.
"""

FEW_NODES = 5
"""So many nodes a stretch from a kink or, where it would have less than four, a tip has, if they are not too close for
that: the pressure may vary along it. Not so one that ends on a junction or on a kink without a node, where the lattice
does not follow the faces.
"""

CLOSEST = 0.55
"""They are too close below this part of the distance that is asked for: then tractions say nothing for themselves."""

CORNER_ROOM = 2.0
"""Cells: a stretch has a node on a junction that is a rim if it is at least this long. Of shorter ones, as between two
cracks that end on both sides of a third one, nodes on both ends and between them would say the same: at 0.1 cells
their pressures were 0 to twice what is there.
"""

THREE_NODES = 1.0
"""Cells: from here on a stretch with a node on a kink has three, however close. Shorter ones are not resolved."""


def mortar_faces(cover: Cover, touching: list[int], spacing: float, *, nested: bool = False) -> ContactFaces:
    """Mortar nodes at least `spacing` (cells) apart along each stretch of the surfaces `touching` (indices).

    A node lies on every end of a stretch that lies on a rim, and on kinks between stretches that are long enough. At
    tips and other junctions and kinks the end pieces are constant: no node lies there. Short stretches have closer
    nodes where they would have less than `FEW_NODES`. Where cells are `nested` in those of a companion mesh so are the
    nodes: each piece of that between nodes, and at ends, is halved.
    """
    ends = {surface: stretch_ends(cover, surface, 0.5 if nested else 1.0) for surface in touching}
    inner = (surface.line.points[1:-1][surface.line.junctions[1:-1]] for surface in cover.surfaces)
    passed = Counter(place.tobytes() for places in inner for place in places)  # how many go on at each junction
    tips = [*ends_at_bonds([surface.line for surface in cover.surfaces])]
    at_tip = {index: [at_end for number, at_end in tips if number == index] for index in touching}
    parts = [_on_surface(cover, index, (spacing, nested), ends[index], passed, at_tip[index]) for index in touching]
    return joined_faces(cover, ends, parts)


def _on_surface(
    cover: Cover, index: int, asked: tuple[float, bool], ends: Floats, passed: Counter[bytes], at_bonds: Sequence[bool]
) -> Part:
    """Integration points, lengths, functions, and arc lengths and stretches of the nodes of one surface."""
    along, (spacing, nested) = cover.surfaces[index].in_cells, asked
    larger = 2.0 if nested else 1.0  # cells of the companion, over those here
    in_cells = along.at(ends) / larger
    kinds = _kinds(cover.surfaces[index], ends, in_cells, passed, at_bonds)
    limits = enumerate(pairwise(in_cells.tolist()))
    places = [_places(*stretch, spacing, kinds[number], nested=nested) for number, stretch in limits]
    nodes = [along.place(larger * there) for there in places]
    stretch = np.repeat(np.arange(len(nodes)), [len(places) for places in nodes])
    s = np.concatenate(nodes)
    points, lengths = integration_points(cover, index, np.concatenate([ends[1:-1], s]))
    stretch_of_point = np.searchsorted(ends[1:-1], points.s, side="right")
    left, right, x = neighbours(s, stretch, points.s, stretch_of_point)
    first, last = (np.searchsorted(stretch, stretch_of_point, side=side) for side in ("left", "right"))
    on_rim = (kinds == RIM)[stretch_of_point]
    between = left != right
    beside_rim = between & ((on_rim[:, 0] & (left == first)) | (on_rim[:, 1] & (right == last - 1)))
    x = np.where(beside_rim, 3.0 * x - 1.0, x)
    there = np.arange(len(points.s))
    functions = Functions(
        node=np.concatenate([left, right[between]]),
        point=np.concatenate([there, there[between]]),
        value=np.concatenate([1.0 - x, x[between]]),
    )
    return points, lengths, functions, s, stretch


def _kinds(surface: Surface, ends: Floats, in_cells: Floats, passed: Counter[bytes], at_bonds: Sequence[bool]) -> Ints:
    """What both ends (m, 2) of each of the m stretches of a surface are, which lie at `ends` (m + 1,): arc lengths.

    `in_cells` (m + 1,) are the same in cells; `passed` says how many surfaces go on at junctions.
    """
    line, m = surface.line, len(ends) - 1
    kind = np.full(m + 1, KINK)
    kind[[0, -1]] = [TIP if at_tip else RIM for at_tip in (line.tip_at_start, line.tip_at_end)]
    at_corner = np.zeros(m + 1, dtype=bool)
    vertices = np.searchsorted(arc_lengths(line.points), ends)
    for number, vertex in enumerate(vertices.tolist()):
        if line.junctions[vertex]:
            kind[number] = JUNCTION
            goes_on = 0 < number < m and passed[line.points[vertex].tobytes()] == 1
            at_corner[number] = goes_on or not surface.name.is_crack
    for at_end in at_bonds:  # a node there would share the pressure with the bond's, and friction would be off by that
        kind[-at_end], at_corner[-at_end] = TIP, False
    both = np.arange(m)[:, None] + np.arange(2)
    has_room = np.diff(in_cells)[:, None] >= CORNER_ROOM - SAME_PLACE
    of_stretch = np.where(at_corner[both] & has_room, RIM, kind[both])
    neighbour = np.concatenate([[np.inf], np.diff(in_cells), [np.inf]])[np.arange(m)[:, None] + np.array([0, 2])]
    return np.where((of_stretch == KINK) & (neighbour < KINK_ROOM - SAME_PLACE), BARE_KINK, of_stretch)


def _places(start: float, end: float, spacing: float, kinds: Ints, *, nested: bool = False) -> Floats:
    """Lengths to the nodes of a stretch between two ends of these kinds (2,); all lengths in cells of a companion."""
    free, on_kink = END_PIECE[kinds], KINK in kinds

    def most(distance: float) -> int:
        return int((end - start) / distance + SAME_PLACE - free.sum()) + 1

    if on_kink:
        least = 3 if end - start >= THREE_NODES - SAME_PLACE else 1
    else:
        least = 1 if JUNCTION in kinds else 3 - int(free.sum())  # on the rims, and in the middle
    n = max(most(spacing), least)
    if on_kink or (n < FEW_NODES - 1 and TIP in kinds):
        resolved = BARE_KINK not in kinds and JUNCTION not in kinds
        n = max(n, min(FEW_NODES, most(CLOSEST * spacing)) if resolved else 0)
    if nested:
        n = 2 * n - 1 + round(free.sum()) if n > 1 else 2
    if n == 1:
        return np.array([start + (end - start) * (free[0] / free.sum() if JUNCTION in kinds else 0.5)])
    return np.asarray(start + (end - start) * (free[0] + np.arange(n)) / (n - 1 + free.sum()))
