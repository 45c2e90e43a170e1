"""Quadrature points on the rims of the manifold elements, in lattice coordinates.

Both elements on an edge, and loads on it, use the same points: what one element gains there the other loses, exactly,
however accurate the rule. Where tip functions act, edges are halved until they are short by their distance from the
tip, and points are drawn to a tip at their end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.quadrature.elements import LARGEST
from crackgrow.quadrature.rules import on_edges
from crackgrow.ragged import Ragged, by_row

POINTS_PER_EDGE = 4
"""Gauss points on an edge of the arrangement, exact to degree 7: that of the functions at support 2 is lower."""

POINTS_BETWEEN_TILES = 2
"""The same on edges between whole tiles without tip functions: 1e-5 of K."""

POINTS_ON_SURFACES = 8
"""The same along surfaces, where contact pressures use other points: a stuck crack passes the patch test at 1e-10."""

SHORTEST = 1e-5
"""Pieces shorter than this many spacings are not halved any further."""


@dataclass(frozen=True, slots=True, eq=False)
class RimPoints:
    """Quadrature points on the rims of elements, sorted by element."""

    points: Floats  # (n, 2)
    normals: Floats  # (n, 2) outward normal times length, spacings
    element: Ints  # (n,)


def rim_points(cover: Cover) -> RimPoints:
    """Points on the rims of all elements."""
    elements, edges = cover.elements, cover.elements.edges
    parts = []
    smooth = np.append(
        (np.arange(elements.n) < elements.n_whole) & ~cover.enrichment.acted_on, [False]
    )  # [-1]: outside
    between = smooth[edges.left] & smooth[edges.right] & ~cover.touching
    for few, touching, n in (
        (True, False, POINTS_BETWEEN_TILES),
        (False, False, POINTS_PER_EDGE),
        (False, True, POINTS_ON_SURFACES),
    ):
        chosen = np.flatnonzero((between == few) & (cover.touching == touching))
        left, right = edges.left[chosen], edges.right[chosen]
        ends = np.stack([elements.vertices[edges.a[chosen]], elements.vertices[edges.b[chosen]]], axis=1)
        acting = _tips_on_edges(cover, left, right, elements.passable[chosen])
        edge, points, lengths = points_on_edges(cover, ends, acting, n)
        step = ends[:, 1] - ends[:, 0]
        unit = step / _norm(step)[:, None]
        normals = lengths[:, None] * np.stack([unit[:, 1], -unit[:, 0]], axis=1)[edge]
        parts += [(points, normals, left[edge]), (points, -normals, right[edge])]
    points, normals, element = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(element, kind="stable")
    order = order[element[order] >= 0]
    return RimPoints(points[order], normals[order], element[order])


def points_on_outlines(cover: Cover, ends: Floats, element: Ints, edge: Ints) -> tuple[Ints, Floats, Floats]:
    """The points of `rim_points` on edges of outlines, or on parts of them, with ends (m, 2, 2), elements and numbers.

    Returns which of the edges (n,), position (n, 2) and length (n,), in spacings, of every point.
    """
    parts = []
    for touching, n in ((False, POINTS_PER_EDGE), (True, POINTS_ON_SURFACES)):
        chosen = np.flatnonzero(cover.touching[edge] == touching)
        nothing = np.full(len(chosen), -1)
        acting = _tips_on_edges(cover, element[chosen], nothing, np.zeros(len(chosen), dtype=bool))
        which, points, lengths = points_on_edges(cover, ends[chosen], acting, n)
        parts.append((chosen[which], points, lengths))
    which, points, lengths = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return which, points, lengths


def points_on_edges(cover: Cover, ends: Floats, acting: Ragged, n: int) -> tuple[Ints, Floats, Floats]:
    """Points on edges `ends` (m, 2, 2), n on each piece, on which the functions of the tips `acting` on them act.

    Returns the edge (n,), sorted, position (n, 2) and length (n,), in spacings, of every point.
    """
    owner, start, size, tip_at_start, tip_at_end = _halved(cover, ends, acting)
    x, w = on_edges(tip_at_start, tip_at_end, n)
    edge, position, share = np.repeat(owner, n), (start[:, None] + size[:, None] * x).ravel(), size[:, None] * w
    order = np.argsort(edge, kind="stable")
    edge, position, share = edge[order], position[order], share.ravel()[order]
    step = (ends[:, 1] - ends[:, 0])[edge]
    return edge, ends[edge, 0] + position[:, None] * step, share * _norm(step)


def _tips_on_edges(cover: Cover, left: Ints, right: Ints, passable: Bools) -> Ragged:
    """The tips that act on edges (m,) between elements `left` and `right` (m,), -1 for none.

    Functions of only one of two neighbours vanish on the edge between them if it is `passable` (m,).
    """
    acting, n_tips = cover.enrichment.tips, max(len(cover.tips), 1)
    found = []
    for element in (left, right):
        there = np.flatnonzero(element >= 0)
        which, pair = acting.places(element[there])
        found.append(there[which] * n_tips + acting.values[pair])
    pairs, sides = np.unique(np.concatenate(found), return_counts=True)
    edge, tip = np.divmod(pairs, n_tips)
    seen = (sides == 2) | ~passable[edge]
    return by_row(edge[seen], tip[seen], len(left))


def _halved(cover: Cover, ends: Floats, acting: Ragged) -> tuple[Ints, Floats, Floats, Bools, Bools]:
    """Halve edges (m, 2, 2) until all pieces are short by their distance from the tips whose functions act on them.

    Returns edge, start and size (as fractions of the edge) and whether a tip is at the start or at the end.
    """
    tips = np.array([tip.point for tip in cover.tips]).reshape(-1, 2)
    owner = np.arange(len(ends))
    start, size = np.zeros(len(owner)), np.ones(len(owner))
    done = []
    while True:
        whole = (ends[:, 1] - ends[:, 0])[owner]
        first, step = ends[owner, 0] + start[:, None] * whole, size[:, None] * whole
        length = _norm(step)
        piece, pair = acting.places(owner)
        offset, along = tips[acting.values[pair]] - first[piece], step[piece]
        share = np.clip(np.sum(offset * along, axis=1) / length[piece] ** 2, 0.0, 1.0)
        distance = _norm(offset - share[:, None] * along)
        at_start, at_end = _norm(offset) < ON_LINE, _norm(offset - along) < ON_LINE
        nearest = np.full(len(owner), np.inf)
        np.minimum.at(nearest, piece, np.where(at_start | at_end, np.inf, distance))
        large = (length > LARGEST * nearest) & (length > SHORTEST)
        tip_at = np.zeros((2, len(owner)), dtype=bool)
        tip_at[0, piece[at_start]], tip_at[1, piece[at_end]] = True, True
        done.append((owner[~large], start[~large], size[~large], *tip_at[:, ~large]))
        if not large.any():
            break
        half = 0.5 * size[large]
        owner = np.tile(owner[large], 2)
        start, size = np.concatenate([start[large], start[large] + half]), np.tile(half, 2)
    owner, start, size, tip_at_start, tip_at_end = (np.concatenate(arrays) for arrays in zip(*done, strict=True))
    return owner, start, size, tip_at_start, tip_at_end


def _norm(vectors: Floats) -> Floats:
    """Lengths (...) of vectors (..., 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    return np.asarray(np.sqrt(x * x + y * y))
