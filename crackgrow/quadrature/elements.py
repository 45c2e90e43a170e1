"""Quadrature points of the manifold elements, in lattice coordinates.

Whole tiles take a product rule, cut ones triangles: round a tip these have their apex at it, and those near
it are halved until they are small by their distance from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.geometry.arrangement import as_complex, ring_vertices
from crackgrow.geometry.tolerance import SAME_PART
from crackgrow.quadrature.rules import on_tip_triangles, on_triangles, square
from crackgrow.ragged import Ragged, places
from crackgrow.vectors import cross

LARGEST = 2.0
"""Triangles, and pieces of edges, with tip functions are no larger than this many times their distance from the tip."""

NEAREST = 1e-5
"""Triangles smaller than this part of their cell are not halved any further: their share is below that of the rules."""

THIN = 1e-4
"""Triangles with a side below this part of the longest: the other two are alike whatever they are. Which of them is
halved matters by the area, which is nothing."""

MORE_POINTS = 1
"""Points per direction on top in triangles, whose rule is not a product of two: without, 1e-4 of K; once more in those
with their apex at a tip; and once more where tip functions fade out: chi folds inside of elements. Without, 4e-4 of
K_II; of cracks no longer than three cells the compliance is 3 % off where whole tiles take no more, 0.1 % where they
do."""

FAR = 0.5
"""Triangles no larger than this part of their distance from a tip take as few points as whole tiles: 1e-5 of K."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementPoints:
    """Quadrature points, sorted by element."""

    points: Floats  # (n, 2)
    weights: Floats  # (n,) in squared spacings
    element: Ints  # (n,)


def element_points(cover: Cover, n: int) -> ElementPoints:
    """Points of all elements; `n` Gauss points per direction on whole tiles, more in cut ones, and near tips."""
    enriched = cover.enrichment.acted_on
    n_whole = cover.elements.n_whole
    corners, owner = _triangles(cover.elements.polygons)
    owner += n_whole
    more = MORE_POINTS if any(np.isfinite(tip.fade) for tip in cover.tips) else 0
    cut = n + MORE_POINTS
    far = cut + more if more else n
    parts = [_on_tiles(cover, np.flatnonzero(~enriched[:n_whole]), n)]
    parts.append(_on_tiles(cover, np.flatnonzero(enriched[:n_whole]), far))
    smooth = ~enriched[owner]
    parts.append(_on_corners(corners[smooth], owner[smooth], cut))
    corners, owner = corners[~smooth], owner[~smooth]
    if len(corners):
        tips = np.array([tip.point for tip in cover.tips])
        at_tip, corners, owner = _tip_first(corners, owner, tips)
        points, weights = on_tip_triangles(corners[at_tip], cut + MORE_POINTS + more)
        sides = corners[at_tip, 1:] - corners[at_tip, :1]
        exact = 0.5 * np.abs(cross(sides[:, 0], sides[:, 1]))  # the rule gives areas to 1e-5
        parts.append(_flat(points, weights * (exact / weights.sum(axis=1))[:, None], owner[at_tip]))
        nearest = NEAREST * cover.elements.size
        corners, owner, size = _halved(corners[~at_tip], owner[~at_tip], tips, cover.enrichment.tips, nearest)
        near = size > FAR
        parts.append(_on_corners(corners[near], owner[near], cut + more))
        parts.append(_on_corners(corners[~near], owner[~near], far))
    points, weights, element = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(element, kind="stable")
    return ElementPoints(points[order], weights[order], element[order])


def triangulate(polygons: NDArray[np.object_]) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 2), counter-clockwise, on all vertices of the polygons and no others; their polygon (t,)."""
    triangles, owner = shapely.get_parts(shapely.constrained_delaunay_triangles(polygons), return_index=True)
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    clockwise = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) < 0.0
    corners[clockwise] = corners[clockwise][:, [0, 2, 1]]
    return corners, owner.astype(np.int64)


def _triangles(polygons: NDArray[np.object_]) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 2) of polygons, and their polygon (t,), that a mirror image of the polygons has as well.

    Delaunay triangles are unique unless four corners lie on a circle: such polygons are cut from their middle.
    """
    corners, owner = triangulate(polygons)
    cut = shapely.area(polygons) >= (1.0 - SAME_PART) * shapely.area(shapely.convex_hull(polygons))
    cut[cut] = _on_a_circle(polygons, corners, owner)[cut]
    start, end, which = ring_vertices(polygons[cut])
    middle = shapely.get_coordinates(shapely.centroid(polygons[cut]))[which]
    fans = np.stack([start, start[end], middle], axis=1)
    unique = ~cut[owner]
    return np.concatenate([corners[unique], fans]), np.concatenate([owner[unique], np.flatnonzero(cut)[which]])


def _on_a_circle(polygons: NDArray[np.object_], corners: Floats, owner: Ints) -> Bools:
    """Of which polygons (n,) a corner lies on the circle round one of their triangles (t, 3, 2), besides those of it.

    With a, b and p from one corner of a triangle to the others and to the point, it does where
    |a|^2 b x p + |b|^2 p x a + |p|^2 a x b = 0.
    """
    points, _, ring = ring_vertices(polygons)
    row, at = places(np.append(0, np.cumsum(np.bincount(ring, minlength=len(polygons)))), owner)
    point, first = points[at], corners[row, 0]
    a, b, p = corners[row, 1] - first, corners[row, 2] - first, point - first
    aa, bb, pp = (np.sum(v * v, axis=1) for v in (a, b, p))
    off = np.abs(aa * cross(b, p) + bb * cross(p, a) + pp * cross(a, b))
    own = (corners[row] == point[:, None]).all(axis=2).any(axis=1)
    on = (off <= SAME_PART * np.maximum(np.maximum(aa, bb), pp) ** 2) & ~own
    found = np.zeros(len(polygons), dtype=bool)
    found[owner[row[on]]] = True
    return found


def _on_tiles(cover: Cover, elements: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    local, weights = square(n)
    tile = cover.elements.tile[elements]
    low, size = cover.lattice.tile_low[tile], cover.lattice.tile_size[tile]
    points = low[:, None] + size[:, None, None] * local
    return _flat(points, size[:, None] ** 2 * weights, elements)


def _on_corners(corners: Floats, owner: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    points, weights = on_triangles(_apex_second(corners), n)
    return _flat(points, weights, owner)


def _apex_second(corners: Floats) -> Floats:
    """Triangles (t, 3, 2) turned so that the rule sees them alike, mirrored or not.

    The rule's apex, the second corner, lies opposite the longest side; opposite the third one if two are the longest.
    """
    sides, first, second = _longest(corners)
    base = np.where(_alike(sides, first, second), 3 - first - second, first)
    return _turned(corners, base + 1)


def _longest(corners: Floats) -> tuple[Floats, Ints, Ints]:
    """Lengths (t, 3) of the sides of triangles (t, 3, 2), each from its corner to the next, and the two longest."""
    sides = np.sqrt(np.sum((np.roll(corners, -1, axis=1) - corners) ** 2, axis=2))
    order = np.argsort(sides, axis=1)
    return sides, order[:, 2], order[:, 1]


def _alike(sides: Floats, first: Ints, second: Ints) -> Bools:
    """Whether two sides (t,) of triangles are equally long, of lengths (t, 3)."""
    at = np.arange(len(sides))
    return np.asarray(sides[at, second] >= (1.0 - SAME_PART) * sides[at, first])


def _turned(corners: Floats, first: Ints) -> Floats:
    """Triangles (t, 3, 2) that begin with their corners `first` (t,), or those counted on."""
    turn = (first[:, None] + np.arange(3)) % 3
    return np.asarray(np.take_along_axis(corners, turn[:, :, None], axis=1))


def _flat(points: Floats, weights: Floats, owner: Ints) -> tuple[Floats, Floats, Ints]:
    return points.reshape(-1, 2), weights.ravel(), np.repeat(owner, points.shape[1])


def _tip_first(corners: Floats, owner: Ints, tips: Floats) -> tuple[Bools, Floats, Ints]:
    """Which triangles (t, 3, 2) have a tip as a corner, all of them with that corner in front, and their element (t,).

    Those with a tip at several corners are halved between two of them.
    """
    numbers = as_complex(tips)
    while True:
        is_tip = np.isin(as_complex(corners), numbers)
        several = is_tip.sum(axis=1) > 1
        if not several.any():
            return np.asarray(is_tip.any(axis=1)), _turned(corners, np.argmax(is_tip, axis=1)), owner
        between = is_tip[several] & np.roll(is_tip[several], -1, axis=1)
        halves = _halves(_turned(corners[several], np.argmax(between, axis=1)))
        corners = np.concatenate([corners[~several], *halves])
        owner = np.concatenate([owner[~several], *[owner[several]] * len(halves)])


def _halved(corners: Floats, owner: Ints, tips: Floats, acting: Ragged, nearest: Floats) -> tuple[Floats, Ints, Floats]:
    """Halve triangles across their longest side until all are small by their distance from their tips.

    Returns them, their elements, and how large each is by its distance. Those smaller than `nearest` (elements,) are
    left. Halving the longest side keeps needles, which a crack close to a lattice line leaves, from being cut
    lengthwise. Where two sides are the longest, all three are halved; not so of `THIN` ones: each part would be as
    thin, and two of its sides the longest.
    """
    done_corners, done_owner, done_size = [np.empty((0, 3, 2))], [np.empty(0, dtype=np.int64)], [np.empty(0)]
    while len(corners):
        sides, longest, second = _longest(corners)
        size = sides.max(axis=1)
        distance = np.full(len(corners), np.inf)
        which, pair = acting.places(owner)
        np.minimum.at(distance, which, _distance(corners[which], tips[acting.values[pair]]))
        large = (size > LARGEST * distance) & (size > nearest[owner])
        done_corners.append(corners[~large])
        done_owner.append(owner[~large])
        done_size.append(size[~large] / np.maximum(distance[~large], np.finfo(float).tiny))
        alike = _alike(sides, longest, second) & (sides.min(axis=1) > THIN * size)
        in_two, in_four = large & ~alike, large & alike
        halves, quarters = _halves(_turned(corners, longest)[in_two]), _quarters(corners[in_four])
        corners = np.concatenate([*halves, *quarters])
        owner = np.concatenate([*[owner[in_two]] * len(halves), *[owner[in_four]] * len(quarters)])
    return np.concatenate(done_corners), np.concatenate(done_owner), np.concatenate(done_size)


def _halves(corners: Floats) -> tuple[Floats, ...]:
    """Two parts of triangles (t, 3, 2) whose first side is halved."""
    a, b, c = corners.transpose(1, 0, 2)
    middle = 0.5 * (a + b)
    return np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)


def _quarters(corners: Floats) -> tuple[Floats, ...]:
    """Four parts of triangles (t, 3, 2), of their shape."""
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    a, b, c = corners.transpose(1, 0, 2)
    ab, bc, ca = middles.transpose(1, 0, 2)
    return tuple(np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab)))


def _distance(corners: Floats, point: Floats) -> Floats:
    """Distances (t,) of points (t, 2) outside from triangles (t, 3, 2)."""
    start, point = corners, point[:, None]
    step = np.roll(corners, -1, axis=1) - start
    tau = np.sum((point - start) * step, axis=2) / np.maximum(np.sum(step * step, axis=2), 1e-300)
    nearest = start + np.clip(tau, 0.0, 1.0)[:, :, None] * step
    return np.asarray(np.sqrt(np.min(np.sum((nearest - point) ** 2, axis=2), axis=1)))
