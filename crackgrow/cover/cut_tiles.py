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
from crackgrow.geometry.arrangement import as_numbers, faces_of
from crackgrow.ragged import places

_ROUND_TILE = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
"""Corners of a tile, counter-clockwise, back to the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """What touched tiles are cut by: those of tile k are the rows start[k] to start[k + 1]."""

    tile: Ints  # (k,) numbers of the tiles, ascending: i times the number of tiles in y, plus j
    start: Ints  # (k + 1,)
    lines: Floats  # (n, 2, 2) pieces of lines inside; a point on the rim, not at a corner, as a piece without length

    def keys(self) -> dict[int, bytes]:
        """Tile by tile, all that the polygons depend on."""
        raw, size = self.lines.tobytes(), 32
        begin = (size * self.start).tolist()
        return {tile: raw[begin[k] : begin[k + 1]] for k, tile in enumerate(self.tile.tolist())}


@dataclass(frozen=True, slots=True, eq=False)
class CutTiles:
    """Polygons inside of bodies, tile by tile."""

    keys: dict[int, bytes]  # of the contents that they were cut by
    tile: Ints  # (p,) ascending
    polygons: NDArray[np.object_]  # (p,)
    reference: Floats  # (p, 2) a point inside
    body: Ints  # (p,)


NOTHING = CutTiles(
    {}, np.empty(0, dtype=np.int64), np.empty(0, dtype=object), np.empty((0, 2)), np.empty(0, dtype=np.int64)
)


def content_of(touched: Bools, x: Floats, y: Floats, ends: Floats, points: Floats) -> Content:
    """The content of the `touched` tiles (tiles x, tiles y), from pieces `ends` (p, 2, 2) and ends of pieces (n, 2)."""
    middle = 0.5 * (ends[:, 0] + ends[:, 1])  # exact: all ends are on the grid
    i, j, on_x, on_y = _places(np.concatenate([middle, points]), x, y)
    n = len(middle)
    inside = np.flatnonzero(~(on_x[:n] | on_y[:n]))
    on_rim = n + np.flatnonzero(on_x[n:] != on_y[n:])
    i = np.concatenate([i[inside], i[on_rim], (i - on_x)[on_rim]])
    j = np.concatenate([j[inside], j[on_rim], (j - on_y)[on_rim]])
    lines = np.empty((len(i), 2, 2))
    lines[: len(inside)] = ends[inside]
    lines[len(inside) :].reshape(2, -1, 2, 2)[:] = points[on_rim - n, None]
    there = np.flatnonzero((i >= 0) & (j >= 0) & (i < len(x) - 1) & (j < len(y) - 1))
    there = there[touched[i[there], j[there]]]
    tile = i[there] * (len(y) - 1) + j[there]
    order = np.argsort(tile, kind="stable")
    tiles = np.flatnonzero(touched)
    start = np.searchsorted(tile[order], np.append(tiles, touched.size))
    return Content(tiles, start, lines[there[order]])


def cut_tiles(
    content: Content, x: Floats, y: Floats, regions: Sequence[shapely.Polygon], before: CutTiles
) -> tuple[CutTiles, Floats]:
    """The polygons in bodies (prepared `regions`) of tiles with a content; those of `before` belong to the same bodies.

    Also returns vertices (k, 2) on the rims of tiles that are not part of their content: where lines meet within
    rounding of a tile line. The tile beside it must have them as well.
    """
    keys = content.keys()
    known = before.keys
    new = np.flatnonzero([known.get(tile) != key for tile, key in keys.items()])
    if len(new) == 0 and len(keys) == len(known):
        return before, np.empty((0, 2))
    is_kept = np.zeros((len(x) - 1) * (len(y) - 1), dtype=bool)
    is_kept[content.tile] = True
    is_kept[content.tile[new]] = False
    kept = is_kept[before.tile]
    arrangements, given = _arrangements(content, new, x, y)
    polygons, owner = faces_of(arrangements)
    reference = _inside_points(polygons)
    body = bodies_at(regions, reference)
    inside = body >= 0
    polygons, owner, reference, body = polygons[inside], new[owner[inside]], reference[inside], body[inside]
    points = shapely.get_coordinates(polygons)
    _, _, on_x, on_y = _places(points, x, y)
    points = points[on_x | on_y]
    is_given = set(as_numbers(given).tolist())
    extra = points[[point not in is_given for point in as_numbers(points).tolist()]]
    tile = np.concatenate([before.tile[kept], content.tile[owner]])
    order = np.argsort(tile, kind="stable")
    return CutTiles(
        keys,
        tile[order],
        np.concatenate([before.polygons[kept], polygons])[order],
        np.concatenate([before.reference[kept], reference])[order],
        np.concatenate([before.body[kept], body])[order],
    ), extra


def bodies_at(regions: Sequence[shapely.Polygon], points: Floats) -> Ints:
    """The body (n,) that holds each of `points` (n, 2), -1 for none."""
    body = np.full(len(points), -1, dtype=np.int64)
    for index, region in enumerate(regions):
        body[shapely.contains_xy(region, points)] = index
    return body


def _places(points: Floats, x: Floats, y: Floats) -> tuple[Ints, Ints, Bools, Bools]:
    """Tiles i, j (n,) of points (n, 2) on the grid, the upper right one of several, and if on a line in x, and in y."""
    i = np.searchsorted(x, points[:, 0], side="right") - 1
    j = np.searchsorted(y, points[:, 1], side="right") - 1
    return i, j, x[i] == points[:, 0], y[j] == points[:, 1]


def _arrangements(content: Content, some: Ints, x: Floats, y: Floats) -> tuple[NDArray[np.object_], Floats]:
    """The lines that cut some of the tiles (m,), tile by tile: their outlines, which pass through the points on their
    rims, and the pieces inside. Also returns all corners of the outlines (n, 2)."""
    which, row = places(content.start, some)
    lines = content.lines[row]
    is_point = np.all(lines[:, 0] == lines[:, 1], axis=1)
    i, j = np.divmod(content.tile[some], len(y) - 1)
    n = len(some)
    corners = np.empty((5, n, 2))
    corners[:, :, 0], corners[:, :, 1] = x[i + _ROUND_TILE[:, :1]], y[j + _ROUND_TILE[:, 1:]]
    low, high = corners[0], corners[2]
    owner = np.concatenate([np.tile(np.arange(n), 5), which[is_point]])
    points = np.concatenate([corners.reshape(-1, 2), lines[is_point, 0]])
    along = np.concatenate([np.repeat(np.arange(5.0), n), _round_rim(points[5 * n :], low, high, owner[5 * n :])])
    order = np.lexsort((along, owner))
    points, owner, along = points[order], owner[order], along[order]
    repeated = (owner[1:] == owner[:-1]) & (along[1:] == along[:-1])
    single = np.append(True, ~repeated)
    outlines = shapely.linestrings(points[single], indices=owner[single])
    inner = shapely.linestrings(lines[~is_point])
    owner = np.concatenate([np.arange(n), which[~is_point]])
    order = np.argsort(owner, kind="stable")
    return np.asarray(shapely.multilinestrings(np.concatenate([outlines, inner])[order], indices=owner[order])), points


def _round_rim(points: Floats, low: Floats, high: Floats, owner: Ints) -> Floats:
    """How far (n,) round their tiles from `low` to `high` (m, 2) points (n, 2) on rims are, in sides from `low`."""
    size = (high - low)[owner]
    share, back = (points - low[owner]) / size, (high[owner] - points) / size
    at_low, at_right, at_top = (
        points[:, 1] == low[owner, 1],
        points[:, 0] == high[owner, 0],
        points[:, 1] == high[owner, 1],
    )
    return np.select([at_low, at_right, at_top], [share[:, 0], 1.0 + share[:, 1], 2.0 + back[:, 0]], 3.0 + back[:, 1])


def _inside_points(polygons: NDArray[np.object_]) -> Floats:
    """A point (n, 2) well inside of each polygon: its centroid where that is inside."""
    centroids = shapely.get_coordinates(shapely.centroid(polygons))
    outside = ~shapely.contains_xy(polygons, centroids)
    if outside.any():
        centroids[outside] = shapely.get_coordinates(shapely.point_on_surface(polygons[outside]))
    return np.asarray(centroids)
