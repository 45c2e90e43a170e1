"""Quadrature points of the manifold elements, in lattice coordinates.

Whole tiles without singular patches share one rule and are not listed here: every one of them has the same element
matrix. Polygons are cut into triangles; round a tip the triangles have their apex at it, and those near it are halved
until they are no larger than their distance from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.cover.cover import Cover
from crackgrow.cover.tiles import tile_lines
from crackgrow.quadrature.rules import on_tip_triangles, on_triangles, square

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

NEAREST = 1e-5
"""Triangles smaller than this many spacings are not halved any further: their share is below round-off of the rest."""

MORE_POINTS_AT_TIPS = 2
"""Points per direction that elements with tip functions get on top."""


@dataclass(frozen=True, slots=True, eq=False)
class ElementPoints:
    """Quadrature points, sorted by element."""

    points: Floats  # (n, 2)
    weights: Floats  # (n,) in squared spacings
    element: Ints  # (n,)


def enriched_elements(cover: Cover) -> Bools:
    """Which elements carry tip functions, tip by tip: (tips, elements)."""
    carries = np.zeros((len(cover.tips), cover.elements.n), dtype=bool)
    for row, first in zip(carries, cover.tip_function_ids, strict=True):
        singular = np.append(first >= 0, False)  # noqa: FBT003  (the last entry serves the index -1)
        row[:] = singular[cover.functions].any(axis=1)
    return carries


def plain_elements(cover: Cover) -> Bools:
    """Which elements are whole tiles without tip functions: (elements,)."""
    plain = ~enriched_elements(cover).any(axis=0)
    plain[cover.elements.n_whole :] = False
    return plain


def element_points(cover: Cover, n: int) -> ElementPoints:
    """Points of all elements that are not plain; `n` Gauss points per direction, more where tip functions act."""
    carries = enriched_elements(cover)
    enriched = carries.any(axis=0)
    whole = np.flatnonzero(enriched[: cover.elements.n_whole])
    corners, owner = triangulate(cover.elements.polygons)
    owner = owner + cover.elements.n_whole
    parts = [_on_tiles(cover, whole, n + MORE_POINTS_AT_TIPS)]
    smooth = ~enriched[owner]
    parts.append(_on_corners(corners[smooth], owner[smooth], n))
    corners, owner = corners[~smooth], owner[~smooth]
    if len(corners):
        tips = np.array([tip.point for tip in cover.tips])
        at_tip, corners = _tip_first(corners, tips)
        points, weights = on_tip_triangles(corners[at_tip], 2 * n)
        parts.append(_flat(points, weights, owner[at_tip]))
        near = _halved(corners[~at_tip], owner[~at_tip], tips, carries)
        parts.append(_on_corners(*near, n + MORE_POINTS_AT_TIPS))
    points, weights, element = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(element, kind="stable")
    return ElementPoints(points[order], weights[order], element[order])


def triangulate(polygons: NDArray[np.object_]) -> tuple[Floats, Ints]:
    """Triangles (t, 3, 2), counter-clockwise, that use all vertices of the polygons and no others; their polygon (t,)."""
    triangles, owner = shapely.get_parts(shapely.constrained_delaunay_triangles(polygons), return_index=True)
    triangles = shapely.orient_polygons(triangles)
    corners = shapely.get_coordinates(triangles).reshape(-1, 4, 2)[:, :3]
    return corners, owner.astype(np.int64)


def _on_tiles(cover: Cover, elements: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    local, weights = square(n)
    lines = tile_lines(cover.lattice)
    tile = cover.elements.tile[elements]
    low = np.stack([lines[axis][tile[:, axis]] for axis in range(2)], axis=1)
    size = np.stack([np.diff(lines[axis])[tile[:, axis]] for axis in range(2)], axis=1)
    points = low[:, None] + size[:, None] * local[None]
    return _flat(points, np.prod(size, axis=1)[:, None] * weights, elements)


def _on_corners(corners: Floats, owner: Ints, n: int) -> tuple[Floats, Floats, Ints]:
    points, weights = on_triangles(corners, n)
    return _flat(points, weights, owner)


def _flat(points: Floats, weights: Floats, owner: Ints) -> tuple[Floats, Floats, Ints]:
    return points.reshape(-1, 2), weights.ravel(), np.repeat(owner, points.shape[1])


def _tip_first(corners: Floats, tips: Floats) -> tuple[Bools, Floats]:
    """Which triangles (t, 3, 2) have a tip as a corner, and all triangles with that corner turned to the front."""
    is_tip = (corners[:, :, None, :] == tips[None, None]).all(axis=3).any(axis=2)
    turn = np.argmax(is_tip, axis=1)
    turned = np.take_along_axis(corners, ((np.arange(3) + turn[:, None]) % 3)[:, :, None], axis=1)
    return is_tip.any(axis=1), turned


def _halved(corners: Floats, owner: Ints, tips: Floats, carries: Bools) -> tuple[Floats, Ints]:
    """Split triangles into four until none is larger than its distance from the tips whose functions it carries."""
    done_corners, done_owner = [], []
    while len(corners):
        size = np.sqrt(np.max(np.sum((corners - np.roll(corners, 1, axis=1)) ** 2, axis=2), axis=1))
        distance = np.full(len(corners), np.inf)
        for tip, carried in zip(tips, carries, strict=True):
            mine = carried[owner]
            distance[mine] = np.minimum(distance[mine], _distance(corners[mine], tip))
        large = (size > distance) & (size > NEAREST)
        done_corners.append(corners[~large])
        done_owner.append(owner[~large])
        corners = corners[large]
        a, b, c = corners.transpose(1, 0, 2)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        children = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(child, axis=1) for child in children])
        owner = np.tile(owner[large], 4)
    if not done_corners:
        return np.empty((0, 3, 2)), np.empty(0, dtype=np.int64)
    return np.concatenate(done_corners), np.concatenate(done_owner)


def _distance(corners: Floats, point: Floats) -> Floats:
    """Distance of a point (2,) outside from triangles (t, 3, 2)."""
    start = corners
    step = np.roll(corners, -1, axis=1) - start
    tau = np.sum((point - start) * step, axis=2) / np.maximum(np.sum(step * step, axis=2), 1e-300)
    nearest = start + np.clip(tau, 0.0, 1.0)[:, :, None] * step
    return np.asarray(np.sqrt(np.min(np.sum((nearest - point) ** 2, axis=2), axis=1)))
