"""Extensions: segments that lead on from the ends of cracks, so that no element holds two sides of a crack."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.tiles import tile_lines
from crackgrow.cover.tips import n_outward, reach_of_tips
from crackgrow.errors import GeometryError
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import ON_LINE, TOUCH

Floats = NDArray[np.float64]

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
        from_tip = crack.points[::-1] if at_end else crack.points
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
    start = segment[1]
    direction = tip_direction(segment, at_end=True)
    far = start + (least + 2.0) * direction
    lines = tile_lines(lattice)
    exits = []
    for axis in range(2):
        low, high = np.sort([start[axis], far[axis]])
        for line in lines[axis][(lines[axis] > low) & (lines[axis] < high)]:
            length = (line - start[axis]) / direction[axis]
            end, other = start + length * direction, lines[1 - axis]
            end[axis] = line
            if length > ON_LINE and other[0] <= end[1 - axis] <= other[-1]:
                near = other[np.abs(other - end[1 - axis]).argmin()]
                end[1 - axis] = near if abs(near - end[1 - axis]) < TOUCH else end[1 - axis]
                exits.append((length, end))
    if not exits:
        return None
    exits.sort(key=lambda found: found[0])
    last = next((k for k, (length, _) in enumerate(exits) if length > least), len(exits) - 1)
    places = np.array([start, *(end for _, end in exits[: last + 1])])
    places = places[np.append(True, np.any(np.diff(places, axis=0) != 0.0, axis=1))]
    return np.stack([places[:-1], places[1:]], axis=1)
