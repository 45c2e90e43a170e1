"""Contact points of the cover's surfaces: integration points along them, and contact points k with functions N_k.

Tractions are p(s) = sum N_k(s) p_k; gap and slip of a contact point are averages of the jump weighted with N_k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.geometry.polyline import arc_lengths, kink_angles, segment_directions
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.quadrature.rules import gauss, on_edges
from crackgrow.ragged import starts_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

STRETCH_KINK = np.deg2rad(10.0)
"""A kink sharper than this ends a stretch: hat functions do not reach round it, since the normal turns there."""

SHORTEST_STRETCH = 0.1
"""Cells: kinks leave no shorter stretch. A contact point of its own would say what its neighbours say already, and
its traction could be anything: behind a kink of 30 degrees at 1e-3 cells 4000 times the pressure, and K_I 100 times
K_II. From here on its K_I is no worse than without."""

POINTS_PER_EDGE = 8
"""Gauss points between two neighbouring mortar nodes, lattice crossings or kinks."""

GAUSS_PARTS, GAUSS_POINTS = 10, 5
"""The paper's contact segments: each straight stretch in 10 parts with 5 Gauss points."""

STRAIGHT = np.deg2rad(1.5)
"""A line that turns by less than this at its corners is one straight stretch: so are the sides of a disk."""


@dataclass(frozen=True, slots=True, eq=False)
class FacePoints:
    """Points along surfaces where the jump of displacement is evaluated, in lattice coordinates."""

    surface: Ints  # (n,)
    s: Floats  # (n,) arc length from the surface's start
    points: Floats  # (n, 2)
    normal: Floats  # (n, 2) from the minus face (on the right of the line) to the plus face (on the left)
    plus: Ints  # (n,) element on the plus face
    minus: Ints  # (n,) element on the minus face, -1 for a rigid foundation


@dataclass(frozen=True, eq=False)
class ContactFaces:
    """The contact points of the surfaces whose faces can touch."""

    points: FacePoints  # n integration points
    lengths: Floats  # (n,) their integration weights, spacings
    values: Functions
    nodes: FacePoints  # the contact points themselves
    stretch: Ints  # (contact points,) number of the stretch on its surface
    ends: dict[int, Floats]  # surface by surface the arc lengths (m + 1,) at which its m stretches begin and end

    @cached_property
    def functions(self) -> csr_array:
        """N_k (contact points, n)."""
        from scipy.sparse import csr_array  # here: who counts contact points alone needs none of it

        return csr_array((self.values.value, (self.values.node, self.values.point)), shape=(self.n, len(self.lengths)))

    @property
    def surface(self) -> Ints:
        """Surface of every contact point (contact points,)."""
        return self.nodes.surface

    @property
    def s(self) -> Floats:
        """Arc length of every contact point (contact points,), spacings."""
        return self.nodes.s

    @property
    def n(self) -> int:
        """Number of contact points."""
        return len(self.nodes.s)

    @property
    def weights(self) -> Floats:
        """Integral of N_k (contact points,), spacings."""
        return np.asarray(self.functions @ self.lengths)

    def between(self, surface: int, s: Floats, *values: Floats) -> list[Floats]:
        """Each of `values` (contact points,) at arc lengths s (n,) of a surface: (n,), linear along each stretch.

        Constant towards the ends of a stretch, zero on a surface without contact points.
        """
        if surface not in self.ends:
            return [np.zeros(len(s)) for _ in values]
        left, right, share = self._beside(surface, s)
        return [found[left] + share * (found[right] - found[left]) for found in values]

    def nearest(self, surface: int, s: Floats) -> Ints:
        """Number (n,) of the contact point nearest to arc lengths s (n,) of a surface, on the stretch; -1 for none."""
        if surface not in self.ends:
            return np.full(len(s), -1, dtype=np.int64)
        left, right, share = self._beside(surface, s)
        return np.where(share > 0.5, right, left)

    def _beside(self, surface: int, s: Floats) -> tuple[Ints, Ints, Floats]:
        """Numbers (n,) of the contact points on both sides of arc lengths s (n,), and how far from the left."""
        mine = slice(*np.searchsorted(self.surface, (surface, surface + 1)).tolist())
        stretch = np.searchsorted(self.ends[surface][1:-1], s, side="right")
        left, right, share = neighbours(self.s[mine], self.stretch[mine], s, stretch)
        return mine.start + left, mine.start + right, share


def stretch_ends(cover: Cover, index: int, larger: float = 1.0) -> Floats:
    """Arc lengths (m + 1,) at which the m stretches of a surface begin and end: its ends, sharp kinks and junctions.

    Of a stretch that would be too short, in cells of which those here are a part `larger`, the less sharp of its kinks
    is passed over.
    """
    surface = cover.surfaces[index]
    s = arc_lengths(surface.line.points)
    xi = larger * cover.surfaces[index].in_cells.at(s)
    turns = np.concatenate([[np.inf], np.abs(kink_angles(surface.line.points)), [np.inf]])  # of what may end a stretch
    turns[surface.line.junctions] = np.inf
    ends = np.flatnonzero(turns > STRETCH_KINK)
    while True:
        sharpness = np.minimum(turns[ends[:-1]], turns[ends[1:]])  # of the less sharp end of each stretch
        short = np.flatnonzero((np.diff(xi[ends]) < SHORTEST_STRETCH) & np.isfinite(sharpness))
        if len(short) == 0:
            return np.asarray(s[ends])
        first = short[np.argmin(sharpness[short])]
        ends = np.delete(ends, first + np.argmin(turns[ends[first : first + 2]]))


def gauss_faces(cover: Cover, touching: list[int]) -> ContactFaces:
    """Place the contact points of the paper: GAUSS_POINTS Gauss points on each of GAUSS_PARTS of a straight piece.

    `touching` are the numbers of the surfaces with a law of contact. Lengths are in lattice spacings.
    """
    parts = []
    ends = {surface: stretch_ends(cover, surface) for surface in touching}
    x, w = gauss(GAUSS_POINTS)
    for surface in touching:
        path = cover.surfaces[surface].line.points
        bent = np.concatenate([[True], np.abs(kink_angles(path)) > STRAIGHT, [True]])
        corners = arc_lengths(path)[bent]
        size = np.repeat(np.diff(corners) / GAUSS_PARTS, GAUSS_PARTS)
        start = np.concatenate([corners[:1], corners[0] + np.cumsum(size)[:-1]])
        s = (start[:, None] + size[:, None] * x).ravel()
        n = len(s)
        functions = Functions(np.arange(n), np.arange(n), np.ones(n))
        stretch = np.searchsorted(ends[surface][1:-1], s, side="right")
        parts.append((points_at(cover, surface, s), (size[:, None] * w).ravel(), functions, s, stretch))
    return joined_faces(cover, ends, parts)


@dataclass(frozen=True, slots=True, eq=False)
class Functions:
    """What the functions N_k of contact points are at integration points, where they are any."""

    node: Ints  # (m,) number of the contact point
    point: Ints  # (m,) number of the integration point
    value: Floats  # (m,)


Part = tuple[FacePoints, Floats, Functions, Floats, Ints]  # integration points, lengths, N_k, s and stretch of nodes


def neighbours(nodes: Floats, stretch: Ints, s: Floats, stretch_of: Ints) -> tuple[Ints, Ints, Floats]:
    """The nodes on both sides of places s (n,) on their stretches, and how far (0 to 1) each is from the left.

    `nodes` (k,) ascend, stretch by stretch, as `stretch` (k,) tells. Next to an end both are the last of the stretch.
    """
    first = np.searchsorted(stretch, stretch_of)
    last = np.searchsorted(stretch, stretch_of, side="right") - 1
    right = np.searchsorted(nodes, s)
    left, right = np.clip(right - 1, first, last), np.clip(right, first, last)
    way = nodes[right] - nodes[left]
    share = np.divide(s - nodes[left], way, out=np.zeros(len(s)), where=way > 0.0)
    return left, right, share


def integration_points(cover: Cover, index: int, breaks: Floats) -> tuple[FacePoints, Floats]:
    """Gauss points, and their lengths (n,), between the ends of a surface's edges and `breaks` (arc lengths).

    They are drawn to the tips, where sqrt(distance) acts.
    """
    surface = cover.surfaces[index]
    limits = np.unique(np.concatenate([surface.edges.s.ravel(), breaks]))
    start, size = limits[:-1], np.diff(limits)
    keep = size > 1e-9  # edges that are the same place but for rounding
    start, size = start[keep], size[keep]
    tip_at_start, tip_at_end = np.zeros((2, len(start)), dtype=bool)
    tip_at_start[0], tip_at_end[-1] = surface.line.tip_at_start, surface.line.tip_at_end
    position, weights = on_edges(tip_at_start, tip_at_end, POINTS_PER_EDGE)
    s = (start[:, None] + size[:, None] * position).ravel()
    return points_at(cover, index, s), (size[:, None] * weights).ravel()


def points_at(cover: Cover, surface: int, s: Floats) -> FacePoints:
    """Face points at arc lengths s (n,) of a surface; cracks are the first surfaces, in their order."""
    return _on_edges(cover, surface, _edges_at(cover, surface, s), s)


def _edges_at(cover: Cover, surface: int, s: Floats) -> Ints:
    """Numbers (n,) of the edges of a surface that arc lengths s (n,) lie on; of two that meet there the second."""
    edges = cover.surfaces[surface].edges
    return np.clip(np.searchsorted(edges.s[:, 0], s, side="right") - 1, 0, len(edges.s) - 1)


def _nodes_at(cover: Cover, surface: int, s: Floats, stretch: Ints, ends: Floats) -> FacePoints:
    """Contact points at arc lengths s (n,) on their `stretch` (n,): at its end, too, with the normal that it has."""
    inside = np.clip(s, ends[stretch] + SAME_PLACE, ends[stretch + 1] - SAME_PLACE)
    return _on_edges(cover, surface, _edges_at(cover, surface, inside), s)


def _on_edges(cover: Cover, surface: int, owner: Ints, s: Floats) -> FacePoints:
    """Face points at arc lengths s (n,) that lie on edges `owner` (n,) of a surface."""
    edges = cover.surfaces[surface].edges
    tangent = segment_directions(cover.surfaces[surface].line.points)[edges.segment[owner]]
    points = edges.points[owner, 0] + (s - edges.s[owner, 0])[:, None] * tangent
    return FacePoints(
        np.full(len(s), surface),
        s,
        points,
        np.stack([-tangent[:, 1], tangent[:, 0]], axis=1),
        edges.plus[owner],
        edges.minus[owner],
    )


def joined_faces(cover: Cover, ends: dict[int, Floats], parts: list[Part]) -> ContactFaces:
    """All surfaces' contact points as one set."""
    if not parts:
        return _NO_FACES
    points, lengths, functions, nodes, stretches = zip(*parts, strict=True)
    first_node, first_point = (starts_of(np.array([len(each) for each in some])) for some in (nodes, lengths))
    return ContactFaces(
        points=joined(points),
        lengths=np.concatenate(lengths),
        values=Functions(
            node=np.concatenate([part.node + first for part, first in zip(functions, first_node, strict=False)]),
            point=np.concatenate([part.point + first for part, first in zip(functions, first_point, strict=False)]),
            value=np.concatenate([part.value for part in functions]),
        ),
        nodes=joined([_nodes_at(cover, *node) for node in zip(ends, nodes, stretches, ends.values(), strict=True)]),
        stretch=np.concatenate(stretches),
        ends=ends,
    )


def joined(parts: Sequence[FacePoints]) -> FacePoints:
    """Face points of several sets as one set."""
    names = [each.name for each in fields(FacePoints)]
    return FacePoints(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


_NO_NUMBERS, _NO_PLACES, _NO_IDS = np.empty(0), np.empty((0, 2)), np.empty(0, dtype=np.int64)
_NO_POINTS = FacePoints(_NO_IDS, _NO_NUMBERS, _NO_PLACES, _NO_PLACES, _NO_IDS, _NO_IDS)
_NO_FACES = ContactFaces(_NO_POINTS, _NO_NUMBERS, Functions(_NO_IDS, _NO_IDS, _NO_NUMBERS), _NO_POINTS, _NO_IDS, {})
