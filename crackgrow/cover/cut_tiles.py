"""Cut tiles: the polygons that outlines and cracks cut the touched tiles into, tile by tile.

A tile is cut by the pieces of lines inside of it and the points where lines meet its rim, and by nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cells import along_rim
from crackgrow.cover.lattice import Lattice
from crackgrow.geometry.arrangement import as_complex, faces_of
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.vectors import cross


@dataclass(frozen=True, slots=True, eq=False)
class CutTiles:
    """Polygons inside of bodies, tile by tile."""

    tile: Ints  # (p,) ascending
    polygons: NDArray[np.object_]  # (p,)
    reference: Floats  # (p, 2) a point inside
    body: Ints  # (p,)


def cut_tiles(
    lattice: Lattice, touched: Bools, ends: Floats, points: Floats, regions: Sequence[shapely.Polygon]
) -> tuple[CutTiles, Floats]:
    """The polygons in bodies (prepared `regions`) that pieces with `ends` (k, 2, 2) cut the `touched` tiles (tiles,)
    into; `points` (n, 2) are all ends of pieces, and where lines meet on rims of tiles.

    Also returns vertices (m, 2) of polygons that are on rims of tiles and none of these points: where lines meet within
    rounding of a tile's side. The tile beside it must have them as well.
    """
    some = np.flatnonzero(touched)
    number = np.full(lattice.tiles.squares.n + 1, -1)  # the last entry serves the number -1
    number[some] = np.arange(len(some))
    around = number[lattice.tiles.squares.around(0.5 * (ends[:, 0] + ends[:, 1]))]  # exact: all ends are on the grid
    inside = np.flatnonzero((around[:, 0] >= 0) & (around == around[:, :1]).all(axis=1))
    rims, of_rim = _rims(lattice, some, number, points)
    polygons, owner = _parts(rims, of_rim, ends[inside], around[inside, 0], len(some))
    reference = _inside_points(polygons)
    body = bodies_at(regions, reference)
    kept = np.flatnonzero(body >= 0)
    kept = kept[np.argsort(owner[kept], kind="stable")]
    corners = shapely.get_coordinates(polygons[kept])
    around = lattice.tiles.squares.around(corners)
    on_rim = corners[(around != around[:, :1]).any(axis=1)]
    extra = on_rim[~np.isin(as_complex(on_rim), as_complex(rims))]
    return CutTiles(some[owner[kept]], polygons[kept], reference[kept], body[kept]), extra


def bodies_at(regions: Sequence[shapely.Polygon], points: Floats) -> Ints:
    """The body (n,) that holds each of `points` (n, 2), -1 for none."""
    body = np.full(len(points), -1, dtype=np.int64)
    for index, region in enumerate(regions):
        body[shapely.contains_xy(region, points)] = index
    return body


def _rims(lattice: Lattice, some: Ints, number: Ints, points: Floats) -> tuple[Floats, Ints]:
    """The corners on the rims of some tiles (m,), and those of `points` (n, 2) there, each once and in order from the
    lower left corner round each tile; and the `number` (tiles + 1,) of the tile of each.
    """
    owner, at = lattice.tiles.ring.places(some)
    around = np.sort(number[lattice.tiles.squares.around(points)], axis=1)
    is_other = np.diff(around, prepend=-1, axis=1) != 0
    point, column = np.nonzero(is_other & (around[:, :1] != around[:, -1:]))
    owner = np.concatenate([owner, around[point, column]])
    points = np.concatenate([lattice.tiles.points[lattice.tiles.ring.values[at]], points[point]])
    along = along_rim(points - lattice.tile_low[some[owner]], lattice.tile_size[some[owner]])
    order = np.lexsort((along, owner))
    points, owner, along = points[order], owner[order], along[order]
    single = (np.diff(owner, prepend=-1) > 0) | (np.diff(along, prepend=-1.0) != 0.0)
    return points[single], owner[single]


def _parts(points: Floats, owner: Ints, pieces: Floats, of_piece: Ints, n: int) -> tuple[NDArray[np.object_], Ints]:
    """The parts (p,) that n tiles with `points` (k, 2) round their rims, of `owner` (k,), are cut into by `pieces`
    (m, 2, 2) inside of tiles `of_piece` (m,); and the tile (p,) that each is a part of.

    A tile that one piece crosses from rim to rim, or none, is parted there; lines that may meet are left to GEOS.
    """
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
    return np.concatenate([shapely.polygons(rings), polygons]), np.concatenate([parted, left[of_polygon]])


def _inside_points(polygons: NDArray[np.object_]) -> Floats:
    """A point (n, 2) well inside of each polygon: its centroid where that is inside."""
    centroids = shapely.get_coordinates(shapely.centroid(polygons))
    outside = ~shapely.contains_xy(polygons, centroids)
    if outside.any():
        centroids[outside] = shapely.get_coordinates(shapely.point_on_surface(polygons[outside]))
    return np.asarray(centroids)
