"""Extensions: segments that lead on from the ends of cracks, so that no element holds two sides of a crack."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.tips import n_outward, reach_of_tips
from crackgrow.errors import GeometryError
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import ON_LINE, TOUCH

DIAGONAL = 2.0**0.5
"""No two points of an element are further apart, spacings."""


def extensions_of(lattice: Lattice, crack: CrackGeometry) -> list[Floats]:
    """Segments (n, 2, 2) that lead on from a crack, so that no element holds two sides of it.

    From a tip one leads through its tile: no crack ends inside of an element. Where the crack ends as seen from a tip,
    the jump of the tip's angle leads on. No element may lie on both sides of that, as long as a part of it is nearer to
    the tip than this end, where the tip functions have not faded out yet.
    """
    least: dict[tuple[int, int], float] = {}  # by the last segment: the vertices that it leads from and to
    n = len(crack.points)
    for at_end in crack.tips():
        numbers = range(n)[::-1] if at_end else range(n)
        least.setdefault((numbers[1], numbers[0]), 0.0)
        from_tip = crack.seen_from(at_end)
        last = n_outward(from_tip)
        if np.hypot(*(from_tip[last] - from_tip[0])) < reach_of_tips(lattice.support):
            least[numbers[last - 1], numbers[last]] = DIAGONAL
    found = []
    for segment, length in least.items():
        extension = _extension(lattice, crack.points[list(segment)], length)
        if extension is not None:
            found.append(extension)
        elif length == 0.0:
            raise GeometryError(f"crack '{crack.name}': its tip lies outside of the lattice")
    return found


def _extension(lattice: Lattice, segment: Floats, least: float) -> Floats | None:
    """The straight extension of a segment (2, 2) to the first tile line further than `least` from its end.

    Where the lattice ends before, to its last tile line; None if there is none. It comes in pieces (n, 2, 2) that end
    on tile lines exactly, and on the corners of tiles that it only just misses, since a speck would be cut off there.
    """
    start, direction = segment[1].tolist(), tip_direction(segment, at_end=True).tolist()
    exits = []
    for axis, lines, others in zip((0, 1), lattice.tile_lines, lattice.tile_lines[::-1], strict=True):
        low, high = sorted((start[axis], start[axis] + (least + 2.0) * direction[axis]))
        begin, end = lines.searchsorted(low, side="right"), lines.searchsorted(high, side="left")
        for line in lines[begin:end].tolist():
            length = (line - start[axis]) / direction[axis]
            across = start[1 - axis] + length * direction[1 - axis]
            if length > ON_LINE and others[0] <= across <= others[-1]:
                place = others.searchsorted(across)
                near = min(others[max(place - 1, 0) : place + 1].tolist(), key=lambda other: abs(other - across))
                across = near if abs(near - across) < TOUCH else across
                exits.append((length, (across, line) if axis else (line, across)))
    if not exits:
        return None
    exits.sort(key=lambda found: found[0])
    last = next((k for k, (length, _) in enumerate(exits) if length > least), len(exits) - 1)
    places = [(start[0], start[1])]
    places.extend(end for _, end in exits[: last + 1])
    return np.array([pair for pair in pairwise(places) if pair[0] != pair[1]]).reshape(-1, 2, 2)
