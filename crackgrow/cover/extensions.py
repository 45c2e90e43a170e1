"""Extensions: segments that lead on from the ends of cracks, so that no element holds two sides of a crack."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.pieces import cut_in_pieces
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.cover.tips import largest_cells_at, n_outward, reach_of_tips
from crackgrow.errors import GeometryError
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import ON_LINE, TOUCH

DIAGONAL = 2.0**0.5
"""No two points of an element are further apart, sides of its cell."""


def extensions_of(lattice: Lattice, cracks: Sequence[CrackGeometry]) -> list[Floats]:
    """Segments (n, 2, 2) that lead on from each of some cracks, so that no element holds two sides of it.

    From a tip one leads through its tile: no crack ends inside of an element. Where the crack ends as seen from a tip,
    the jump of the tip's angle leads on. No element may lie on both sides of that, as long as a part of it is nearer to
    the tip than this end, where the tip functions have not faded out yet.
    """
    wanted = [
        (crack, crack.points[list(segment)], least)
        for crack, ends in zip(cracks, _ends(lattice, cracks), strict=True)
        for segment, least in ends.items()
    ]
    if not wanted:
        return []
    segments = np.array([segment for _, segment, _ in wanted])
    least = np.array([length for _, _, length in wanted])
    found = []
    for (crack, _, length), extension in zip(wanted, _extended(lattice, segments, least), strict=True):
        if extension is not None:
            found.append(extension)
        elif length == 0.0:
            raise GeometryError(f"{crack.name.words}: its tip lies outside of the lattice")
    return found


def _ends(lattice: Lattice, cracks: Sequence[CrackGeometry]) -> list[dict[tuple[int, int], float]]:
    """The vertices that lead to each end of some cracks which is to be extended, and by how much at least."""
    least: list[dict[tuple[int, int], float]] = [{} for _ in cracks]  # by the last segment: from and to which vertex
    tips = [(number, at_end) for number, crack in enumerate(cracks) for at_end in crack.tips()]
    paths = [cracks[number].seen_from(at_end) for number, at_end in tips]
    outward = [n_outward(path) for path in paths]  # where the crack ends as seen from the tip
    limits = np.array([path[[0, last]] for path, last in zip(paths, outward, strict=True)]).reshape(-1, 2, 2)
    sizes = largest_cells_at(lattice, limits.reshape(-1, 2)).reshape(-1, 2)
    near = np.hypot(*(limits[:, 1] - limits[:, 0]).T) < reach_of_tips(lattice.support) * sizes[:, 0]
    for (number, at_end), last, is_near, size in zip(tips, outward, near.tolist(), sizes[:, 1].tolist(), strict=True):
        vertices = range(len(cracks[number].points))[:: -1 if at_end else 1]
        least[number].setdefault((vertices[1], vertices[0]), 0.0)
        if is_near:
            least[number][vertices[last - 1], vertices[last]] = DIAGONAL * size
    return least


def _extended(lattice: Lattice, segments: Floats, least: Floats) -> Iterator[Floats | None]:
    """The extension of each of some segments (n, 2, 2), by `least` (n,) or more."""
    directions = [tip_direction(segment, at_end=True) for segment in segments]
    far = [
        segment[1] + min(length + 2.0, _to_edge(lattice, segment[1], direction)) * direction
        for segment, length, direction in zip(segments, least.tolist(), directions, strict=True)
    ]
    pieces = cut_in_pieces(np.stack([segments[:, 1], far], axis=1), lattice.tiles.squares)
    first, points = np.searchsorted(pieces.segment, np.arange(1, len(segments))), pieces.ends[:, 1]
    ends, on_sides = (np.split(each, first) for each in (points, _at_corners(lattice, points)))
    for segment, direction, length, *own in zip(segments, directions, least.tolist(), ends, on_sides, strict=True):
        yield _extension(segment[1], direction, length, *own) if len(own[0]) else None


def _extension(start: Floats, direction: Floats, least: float, ends: Floats, on_sides: Floats) -> Floats | None:
    """The straight extension from a point (2,) to the first side of a tile further than `least` from it.

    It crosses sides at `ends` (k, 2), or at the corners beside them, which are `on_sides` (k, 2) then. Where the
    lattice ends before, to its last tile; None if there is none. It comes in pieces (n, 2, 2) that end on sides of
    tiles exactly, and on the corners of tiles that it only just misses, since a speck would be cut off there.
    """
    length = (ends - start) @ direction
    if not (length > ON_LINE).any():
        return None
    last = int(np.argmax(length > max(least, ON_LINE))) if length[-1] > max(least, ON_LINE) else len(length) - 1
    places = [start, *on_sides[: last + 1][length[: last + 1] > ON_LINE]]
    return np.array([pair for pair in pairwise(places) if (pair[0] != pair[1]).any()]).reshape(-1, 2, 2)


def _to_edge(lattice: Lattice, start: Floats, direction: Floats) -> float:
    """How far the edge of the lattice is from a point (2,) inside, in a direction (2,)."""
    limits = np.where(direction > 0.0, np.array(lattice.shape, dtype=float), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.where(direction == 0.0, np.inf, (limits - start) / direction)
    return max(float(distance.min()), 0.0)


def _at_corners(lattice: Lattice, points: Floats) -> Floats:
    """Corners of tiles that touch points (n, 2), where one is within rounding of them; else the points themselves."""
    around = lattice.tiles.squares.around(points)
    point, column = np.nonzero(around >= 0)
    which, place = lattice.tiles.ring.places(around[point, column])
    owner, corners = point[which], lattice.tiles.points[lattice.tiles.ring.values[place]]
    distance = np.abs(corners - points[owner]).max(axis=1)
    nearest = np.lexsort((distance, owner))
    nearest = nearest[np.diff(owner[nearest], prepend=-1) > 0]
    nearest = nearest[distance[nearest] < TOUCH]
    found = points.copy()
    found[owner[nearest]] = corners[nearest]
    return found
