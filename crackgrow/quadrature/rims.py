"""Quadrature points on the rims of the manifold elements, in lattice coordinates.

Both elements on an edge, and loads on it, use the same points: what one element gains there the other loses, exactly,
however accurate the rule. Where tip functions act, edges are halved until they are short by their distance from the
tip, and points are drawn to a tip at their end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.compiled import kernel
from crackgrow.cover.cover import Cover
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.quadrature.elements import LARGEST
from crackgrow.quadrature.rules import on_edges, on_edges_with_tips
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


def points_on_edges(
    cover: Cover, ends: Floats, acting: Ragged, n: int = POINTS_PER_EDGE
) -> tuple[Ints, Floats, Floats]:
    """Points on edges `ends` (m, 2, 2) on which the functions of the tips `acting` on them act.

    Returns the edge (n,), sorted, position (n, 2) and length (n,), in spacings, of every point.
    """
    smooth = np.flatnonzero(acting.counts == 0)
    parts = [_flat(smooth, np.zeros(len(smooth)), np.ones(len(smooth)), *on_edges(len(smooth), n))]
    if len(smooth) < len(ends):
        tips = np.array([tip.point for tip in cover.tips])
        owner, start, size, tip_at_start, tip_at_end = _split(ends, acting.start, acting.values, tips)
        parts.append(_flat(owner, start, size, *on_edges_with_tips(tip_at_start, tip_at_end, n)))
    edge, position, share = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(edge, kind="stable")
    edge, position, share = edge[order], position[order], share[order]
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


def _flat(owner: Ints, start: Floats, size: Floats, x: Floats, w: Floats) -> tuple[Ints, Floats, Floats]:
    """Points at x (m, n), weights w (m, n), of the pieces `start` to `start + size` (m,) of their edges."""
    position = start[:, None] + size[:, None] * x
    return np.repeat(owner, x.shape[1]), position.ravel(), (size[:, None] * w).ravel()


@kernel
def _split(ends: Floats, acting_at: Ints, acting: Ints, tips: Floats) -> tuple[Ints, Floats, Floats, Bools, Bools]:
    """Halve edges (m, 2, 2) that tip functions act on until all pieces are short by their distance from the tips.

    The tips of edge i are acting[acting_at[i] : acting_at[i + 1]]. Returns edge, start and size (as fractions of the
    edge) and whether a tip is at the start or at the end.
    """
    room = 2 * len(acting) + 8
    owner, start, size, at_tip = np.empty(room, np.int64), np.empty(room), np.empty(room), np.empty((2, room), np.bool_)
    n, waiting = 0, np.empty((64, 2))
    for edge in range(len(ends)):
        if acting_at[edge] == acting_at[edge + 1]:
            continue
        waiting[0, 0], waiting[0, 1], left = 0.0, 1.0, 1
        whole_x, whole_y = ends[edge, 1, 0] - ends[edge, 0, 0], ends[edge, 1, 1] - ends[edge, 0, 1]
        while left:
            left -= 1
            begin, part = waiting[left, 0], waiting[left, 1]
            step_x, step_y, nearest, at_start, at_end = part * whole_x, part * whole_y, np.inf, False, False
            length = math.hypot(step_x, step_y)
            for tip in tips[acting[acting_at[edge] : acting_at[edge + 1]]]:
                x, y = tip[0] - ends[edge, 0, 0] - begin * whole_x, tip[1] - ends[edge, 0, 1] - begin * whole_y
                if math.hypot(x, y) < ON_LINE:
                    at_start = True
                elif math.hypot(x - step_x, y - step_y) < ON_LINE:
                    at_end = True
                else:
                    along = min(max((x * step_x + y * step_y) / (length * length), 0.0), 1.0)
                    nearest = min(nearest, math.hypot(x - along * step_x, y - along * step_y))
            if length > LARGEST * nearest and length > SHORTEST:
                if left + 2 > len(waiting):
                    waiting = np.concatenate((waiting, waiting))
                waiting[left, 0], waiting[left + 1, 0] = begin + 0.5 * part, begin
                waiting[left, 1] = waiting[left + 1, 1] = 0.5 * part
                left += 2
                continue
            if n == len(owner):
                owner, start, size = np.append(owner, owner), np.append(start, start), np.append(size, size)
                at_tip = np.concatenate((at_tip, at_tip), axis=1)
            owner[n], start[n], size[n], at_tip[0, n], at_tip[1, n] = edge, begin, part, at_start, at_end
            n += 1
    return owner[:n], start[:n], size[:n], at_tip[0, :n], at_tip[1, :n]


def _norm(vectors: Floats) -> Floats:
    """Lengths (...) of vectors (..., 2)."""
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))
