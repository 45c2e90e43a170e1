"""Cut tiles: the polygons that outlines and cracks cut the touched tiles into, tile by tile.

A tile is cut by its content and nothing else: the pieces of lines inside of it, and the points where lines meet its
rim. So tiles whose content is as before keep their polygons, and the result is the same as without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import as_numbers, faces_of
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.ragged import places
from crackgrow.vectors import cross

_ROUND_TILE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
"""Corners of a tile, counter-clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """What touched tiles are cut by: those of tile k are the rows start[k] to start[k + 1]."""

    tile: Ints  # (k,) numbers of the tiles, ascending
    place: Ints  # (k, 3) lower left corner and side of each, quanta
    start: Ints  # (k + 1,)
    lines: Floats  # (n, 2, 2) pieces of lines inside; a point on the rim, not at a corner, as a piece without length

    def keys(self) -> dict[tuple[int, ...], bytes]:
        """By the places of tiles, all that the polygons depend on."""
        raw, size = self.lines.tobytes(), 32
        begin = (size * self.start).tolist()
        return {tuple(place): raw[begin[k] : begin[k + 1]] for k, place in enumerate(self.place.tolist())}


@dataclass(frozen=True, slots=True, eq=False)
class CutTiles:
    """Polygons inside of bodies, tile by tile."""

    keys: dict[tuple[int, ...], bytes]  # of the contents that they were cut by
    tile: Ints  # (p,) ascending
    place: Ints  # (p, 3) of the tiles
    polygons: NDArray[np.object_]  # (p,)
    reference: Floats  # (p, 2) a point inside
    body: Ints  # (p,)


_NO_IDS = np.empty(0, dtype=np.int64)
NOTHING = CutTiles({}, _NO_IDS, _NO_IDS.reshape(0, 3), np.empty(0, dtype=object), np.empty((0, 2)), _NO_IDS)


def content_of(touched: Bools, lattice: Lattice, ends: Floats, points: Floats) -> Content:
    """The content of the `touched` tiles (tiles,), from pieces `ends` (p, 2, 2) and ends of pieces (n, 2).

    Corners of smaller tiles beside one are points on its rim.
    """
    tiles, corners = lattice.tiles.squares, lattice.tiling.points
    around = tiles.around(0.5 * (ends[:, 0] + ends[:, 1]))  # exact: all ends are on the grid
    inside = np.flatnonzero((around == around[:, :1]).all(axis=1))
    point, on_rim = _on_rims(tiles.around(points))
    ring, some = lattice.tiling.ring, np.flatnonzero(touched)
    divided = some[ring.counts[some] > 4]
    which, at = ring.places(divided)
    tile = np.concatenate([around[inside, 0], on_rim, divided[which]])
    rims = np.concatenate([points[point], corners[ring.values[at]]])
    is_point = np.arange(len(tile)) >= len(inside)
    lines = np.concatenate([ends[inside], np.repeat(rims[:, None], 2, axis=1)])
    size = tiles.size[tile, None]
    at_corner = is_point & np.isin((lines[:, 0] * QUANTA - tiles.low[tile]) / size, (0.0, 1.0)).all(axis=1)
    there = np.flatnonzero((tile >= 0) & touched[tile] & ~at_corner)
    order = there[np.argsort(tile[there], kind="stable")]
    start = np.append(np.searchsorted(tile[order], some), len(order))
    return Content(some, np.column_stack([tiles.low[some], tiles.size[some]]), start, lines[order])


def cut_tiles(
    content: Content, tiles: Squares, regions: Sequence[shapely.Polygon], before: CutTiles
) -> tuple[CutTiles, Floats]:
    """The polygons in bodies (prepared `regions`) of tiles with a content; those of `before` belong to the same bodies.

    Also returns vertices (k, 2) on the rims of tiles that are not part of their content: where lines meet within
    rounding of a tile's side. The tile beside it must have them as well.
    """
    keys, known = content.keys(), before.keys
    new = np.flatnonzero([known.get(place) != key for place, key in keys.items()])
    kept, number = _kept(content, new, before, tiles)
    polygons, owner, extra = _parts(content, new, tiles)
    reference = _inside_points(polygons)
    body = bodies_at(regions, reference)
    inside = body >= 0
    polygons, owner, reference, body = polygons[inside], new[owner[inside]], reference[inside], body[inside]
    tile = np.concatenate([number, content.tile[owner]])
    order = np.argsort(tile, kind="stable")
    return CutTiles(
        keys,
        tile[order],
        np.concatenate([before.place[kept], content.place[owner]])[order],
        np.concatenate([before.polygons[kept], polygons])[order],
        np.concatenate([before.reference[kept], reference])[order],
        np.concatenate([before.body[kept], body])[order],
    ), extra


def _kept(content: Content, new: Ints, before: CutTiles, tiles: Squares) -> tuple[Ints, Ints]:
    """Which polygons of `before` stay, and the numbers of their tiles now; `new` tiles are cut again."""
    number = tiles.at(before.place[:, :2])
    there = np.flatnonzero((number >= 0) & (tiles.size[number] == before.place[:, 2]))
    stays = np.zeros(tiles.n, dtype=bool)
    stays[content.tile] = True
    stays[content.tile[new]] = False
    kept = there[stays[number[there]]]
    return kept, number[kept]


def bodies_at(regions: Sequence[shapely.Polygon], points: Floats) -> Ints:
    """The body (n,) that holds each of `points` (n, 2), -1 for none."""
    body = np.full(len(points), -1, dtype=np.int64)
    for index, region in enumerate(regions):
        body[shapely.contains_xy(region, points)] = index
    return body


def _on_rims(around: Ints) -> tuple[Ints, Ints]:
    """Points (k,) on rims of tiles, and these tiles (k,); `around` (n, 4) are the tiles round all points."""
    sides = np.sort(around, axis=1)
    first = np.column_stack([np.ones(len(sides), dtype=bool), sides[:, 1:] != sides[:, :-1]])
    first[first.sum(axis=1) == 1] = False
    point, column = np.nonzero(first & (sides >= 0))
    return point, sides[point, column]


def _parts(content: Content, some: Ints, tiles: Squares) -> tuple[NDArray[np.object_], Ints, Floats]:
    """The parts (p,) of some of the tiles (m,), the number (p,) among these that each is of, and vertices (k, 2) of
    parts that are on the rim of a tile, but not among the points there.

    A tile that one piece crosses from rim to rim, or none, is parted there; lines that may meet are left to GEOS.
    """
    n = len(some)
    which, row = places(content.start, some)
    lines, is_piece = content.lines[row], np.any(content.lines[row, 0] != content.lines[row, 1], axis=1)
    pieces, of_piece = lines[is_piece], which[is_piece]
    points, owner = _rims(content.place[some], lines[~is_piece, 0], which[~is_piece])
    ends = np.full((n, 2, 2), np.nan)
    ends[of_piece] = pieces
    ends, step = ends[owner], np.diff(ends, axis=1)[owner, 0]
    is_end = (points[:, None] == ends).all(axis=2).any(axis=1)
    beside = np.abs(cross(step, points - ends[:, 0])) > ON_LINE * np.hypot(*step.T)
    n_pieces, n_ends = np.bincount(of_piece, minlength=n), np.bincount(owner, is_end, n)
    crossed = (n_pieces == 1) & (n_ends == 2) & (np.bincount(owner, ~beside, n) == 2)
    simple = crossed | (n_pieces == 0)

    is_end &= crossed[owner]
    behind = np.cumsum(is_end) % 2 == 1  # of the two ends on the rim that one has been passed
    first, second = np.flatnonzero(is_end | behind), np.flatnonzero((is_end | ~behind) & simple[owner])
    tile = np.concatenate([owner[first], n + owner[second]])
    rings = shapely.linearrings(
        points[np.append(first, second)], indices=np.cumsum(np.diff(tile, prepend=tile[:1]) > 0)
    )
    parted = np.concatenate([np.flatnonzero(crossed), np.flatnonzero(simple)])

    left, number = np.flatnonzero(~simple), np.cumsum(~simple) - 1
    on_rim, inside = ~simple[owner], ~simple[of_piece]
    rims = shapely.linearrings(points[on_rim], indices=number[owner[on_rim]])
    lines = np.concatenate([rims, shapely.linestrings(pieces[inside])])
    owner = np.concatenate([np.arange(len(left)), number[of_piece[inside]]])
    order = np.argsort(owner, kind="stable")
    polygons, of_polygon = faces_of(shapely.multilinestrings(lines[order], indices=owner[order]))
    corners = shapely.get_coordinates(polygons)
    around = tiles.around(corners)
    corners = corners[(around != around[:, :1]).any(axis=1)]
    extra = corners[~np.isin(as_numbers(corners), as_numbers(points[on_rim]))]
    return np.concatenate([shapely.polygons(rings), polygons]), np.concatenate([parted, left[of_polygon]]), extra


def _rims(place: Ints, points: Floats, owner: Ints) -> tuple[Floats, Ints]:
    """The corners of tiles at these places (n, 3) and points on their rims (k, 2), each once, in order from the lower
    left corner round each tile; and the tile of each.
    """
    low, size = place[:, :2] / QUANTA, place[:, 2] / QUANTA
    corners = low + size[:, None] * _ROUND_TILE[:, None]
    along = _round_rim(points, low[owner], low[owner] + size[owner, None])
    along = np.concatenate([np.repeat(np.arange(4.0), len(place)), along])
    points, owner = (
        np.concatenate([corners.reshape(-1, 2), points]),
        np.append(np.tile(np.arange(len(place)), 4), owner),
    )
    order = np.lexsort((along, owner))
    points, owner, along = points[order], owner[order], along[order]
    single = (np.diff(owner, prepend=-1) > 0) | (np.diff(along, prepend=-1.0) != 0.0)
    return points[single], owner[single]


def _round_rim(points: Floats, low: Floats, high: Floats) -> Floats:
    """How far (n,) round tiles from `low` to `high` (n, 2) points (n, 2) on their rims are, in sides from `low`."""
    size = high - low
    share, back = (points - low) / size, (high - points) / size
    at_low, at_right, at_top = points[:, 1] == low[:, 1], points[:, 0] == high[:, 0], points[:, 1] == high[:, 1]
    return np.select([at_low, at_right, at_top], [share[:, 0], 1.0 + share[:, 1], 2.0 + back[:, 0]], 3.0 + back[:, 1])


def _inside_points(polygons: NDArray[np.object_]) -> Floats:
    """A point (n, 2) well inside of each polygon: its centroid where that is inside."""
    centroids = shapely.get_coordinates(shapely.centroid(polygons))
    outside = ~shapely.contains_xy(polygons, centroids)
    if outside.any():
        centroids[outside] = shapely.get_coordinates(shapely.point_on_surface(polygons[outside]))
    return np.asarray(centroids)
