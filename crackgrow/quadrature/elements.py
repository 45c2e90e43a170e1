"""Quadrature points of the manifold elements, in lattice coordinates.

Plain elements share one rule and are not listed here (`plain_kinds`). Polygons are cut into triangles; round a tip the
triangles have their apex at it, and those near it are halved until they are small by their distance from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.geometry.arrangement import as_numbers, ring_vertices
from crackgrow.quadrature.rules import on_tip_triangles, on_triangles, square
from crackgrow.ragged import Ragged
from crackgrow.vectors import cross

LARGEST = 2.0
"""Triangles with tip functions are no larger than this many times their distance from the tip."""

NEAREST = 1e-5
"""Triangles smaller than this part of their cell are not halved any further: their share is below that of the rules."""

MORE_POINTS_WHERE_FADING = 1
"""Points per direction on top where tip functions fade out: chi folds inside of elements. Without, 4e-4 of K_II."""

MORE_POINTS_AT_TIPS = 1
"""The same for triangles with their apex at a tip."""

FEWER_IN_IRREGULAR_TILES = 1
"""Points per direction less in whole tiles beside cells of another size, of which most are halves: 1e-5 of K."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementPoints:
    """Quadrature points, sorted by element."""

    points: Floats  # (n, 2)
    weights: Floats  # (n,) in squared spacings
    element: Ints  # (n,)


def element_points(cover: Cover, n: int) -> ElementPoints:
    """Points of all elements that are not plain; `n` Gauss points per direction, more where tip functions act."""
    enriched = cover.enrichment.acted_on
    n_whole = cover.elements.n_whole
    cut = np.flatnonzero(~cover.plain[n_whole:])
    corners, owner = _triangles(cover.elements.polygons[cut])
    owner = cut[owner] + n_whole
    more = MORE_POINTS_WHERE_FADING if any(np.isfinite(tip.fade) for tip in cover.tips) else 0
    irregular = np.flatnonzero(~(cover.plain | enriched)[:n_whole])
    parts = [_on_tiles(cover, np.flatnonzero(enriched[:n_whole]), n + more)]
    parts.append(_on_tiles(cover, irregular, max(n - FEWER_IN_IRREGULAR_TILES, 1)))
    smooth = ~enriched[owner]
    parts.append(_on_corners(corners[smooth], owner[smooth], n))
    corners, owner = corners[~smooth], owner[~smooth]
    if len(corners):
        tips = np.array([tip.point for tip in cover.tips])
        at_tip, corners = _tip_first(corners, tips)
        points, weights = on_tip_triangles(corners[at_tip], n + MORE_POINTS_AT_TIPS + more)
        sides = corners[at_tip, 1:] - corners[at_tip, :1]
        exact = 0.5 * np.abs(cross(sides[:, 0], sides[:, 1]))  # the rule gives areas to 1e-5
        parts.append(_flat(points, weights * (exact / weights.sum(axis=1))[:, None], owner[at_tip]))
        nearest = NEAREST * cover.elements.size
        near = _halved(corners[~at_tip], owner[~at_tip], tips, cover.enrichment.tips, nearest)
        parts.append(_on_corners(*near, n + more))
    points, weights, element = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(element, kind="stable")
    return ElementPoints(points[order], weights[order], element[order])


def triangulate(polygons: NDArray[np.object_]) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 2), counter-clockwise, on all vertices of the polygons and no others; their polygon (t,)."""
    triangles, owner = shapely.get_parts(shapely.constrained_delaunay_triangles(polygons), return_index=True)
    triangles = shapely.orient_polygons(triangles)
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    return corners, owner.astype(np.int64)


def _triangles(polygons: NDArray[np.object_]) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 2) of polygons, and their polygon (t,), that a mirror image of the polygons has as well.

    Delaunay triangles are unique unless four corners lie on a circle: rectangles are cut from their middle.
    """
    x0, y0, x1, y1 = shapely.bounds(polygons).T
    rectangular = shapely.area(polygons) == (x1 - x0) * (y1 - y0)  # exact: vertices are on a grid
    others, rectangles = np.flatnonzero(~rectangular), np.flatnonzero(rectangular)
    corners, owner = triangulate(polygons[others])
    start, end, which = ring_vertices(polygons[rectangles])
    middle = 0.5 * np.stack([x0 + x1, y0 + y1], axis=1)[rectangles[which]]
    fans = np.stack([start, start[end], middle], axis=1)
    return np.concatenate([corners, fans]), np.concatenate([others[owner], rectangles[which]])


def _on_tiles(cover: Cover, elements: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    local, weights = square(n)
    tile = cover.elements.tile[elements]
    low, size = cover.lattice.tile_low[tile], cover.lattice.tile_size[tile]
    points = low[:, None] + size[:, None, None] * local
    return _flat(points, size[:, None] ** 2 * weights, elements)


def _on_corners(corners: Floats, owner: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    points, weights = on_triangles(_longest_first(corners), n)
    return _flat(points, weights, owner)


def _longest_first(corners: Floats) -> Floats:
    """Triangles (t, 3, 2) turned so that the rule sees them alike, mirrored or not: the longest side runs from the last
    to the first corner."""
    sides = np.sum((corners - np.roll(corners, 1, axis=1)) ** 2, axis=2)  # of each corner from the one before it
    turn = (np.argmax(sides, axis=1)[:, None] + np.arange(3)) % 3
    return np.asarray(np.take_along_axis(corners, turn[:, :, None], axis=1))


def _flat(points: Floats, weights: Floats, owner: Ints) -> tuple[Floats, Floats, Ints]:
    return points.reshape(-1, 2), weights.ravel(), np.repeat(owner, points.shape[1])


def _tip_first(corners: Floats, tips: Floats) -> tuple[Bools, Floats]:
    """Which triangles (t, 3, 2) have a tip as a corner, and all triangles with that corner turned to the front."""
    is_tip = np.isin(as_numbers(corners), as_numbers(tips))
    turn = np.argmax(is_tip, axis=1)
    turned = np.take_along_axis(corners, ((np.arange(3) + turn[:, None]) % 3)[:, :, None], axis=1)
    return np.asarray(is_tip.any(axis=1)), turned


def _halved(corners: Floats, owner: Ints, tips: Floats, acting: Ragged, nearest: Floats) -> tuple[Floats, Ints]:
    """Halve triangles across their longest side until all are small by their distance from their tips.

    Those smaller than `nearest` (elements,) are left. Halving the longest side keeps needles, which a crack close to a
    lattice line leaves, from being cut lengthwise.
    """
    done_corners, done_owner = [np.empty((0, 3, 2))], [np.empty(0, dtype=np.int64)]
    while len(corners):
        sides = np.sqrt(np.sum((np.roll(corners, -1, axis=1) - corners) ** 2, axis=2))
        longest = np.argmax(sides, axis=1)
        size = sides.max(axis=1)
        distance = np.full(len(corners), np.inf)
        which, pair = acting.places(owner)
        np.minimum.at(distance, which, _distance(corners[which], tips[acting.values[pair]]))
        large = (size > LARGEST * distance) & (size > nearest[owner])
        done_corners.append(corners[~large])
        done_owner.append(owner[~large])
        turn = (longest[large, None] + np.arange(3)) % 3  # the longest side runs from the first to the second corner
        a, b, c = np.take_along_axis(corners[large], turn[:, :, None], axis=1).transpose(1, 0, 2)
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.tile(owner[large], 2)
    return np.concatenate(done_corners), np.concatenate(done_owner)


def _distance(corners: Floats, point: Floats) -> Floats:
    """Distances (t,) of points (t, 2) outside from triangles (t, 3, 2)."""
    start, point = corners, point[:, None]
    step = np.roll(corners, -1, axis=1) - start
    tau = np.sum((point - start) * step, axis=2) / np.maximum(np.sum(step * step, axis=2), 1e-300)
    nearest = start + np.clip(tau, 0.0, 1.0)[:, :, None] * step
    return np.asarray(np.sqrt(np.min(np.sum((nearest - point) ** 2, axis=2), axis=1)))
