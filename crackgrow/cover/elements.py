"""Manifold elements: the pieces into which tiles, outlines and cracks cut the bodies.

Which piece a point belongs to, and on which side of a crack, is decided here and nowhere else: quadrature points are
made inside an element, contact points know the elements on their two sides, other points are located.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cells import Tiles
from crackgrow.cover.cut_tiles import CutTiles, bodies_at, cut_tiles
from crackgrow.cover.extensions import extensions_of
from crackgrow.cover.face_edges import FaceEdges, OutlineEdges, edges_along, edges_on_lines, edges_on_outlines
from crackgrow.cover.junctions import sides_through_junctions
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.pieces import Pieces, cut_in_pieces
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.squares import QUANTA, Squares
from crackgrow.geometry.arrangement import Edges, Rings, as_complex, edges_between, ring_vertices
from crackgrow.geometry.tolerance import ON_LINE, TOUCH
from crackgrow.ragged import distinct, starts_of

_TOUCHING = TOUCH * np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])

_ROUND_TIP = np.array([(x, y) for x in (-1, 1, 3, 5, 7, 9) for y in (-1, 1, 3, 5, 7, 9)])
"""Places in and round a tile, in eighths of its side: neighbours are no smaller than a quarter of a tile."""


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """All manifold elements: first the whole tiles that nothing touches, then the polygons cut from the others."""

    n_whole: int
    tile: Ints  # (n,) tile of the lattice that it is, or is a piece of
    size: Floats  # (n,) side of the tile's cell, spacings
    body: Ints  # (n,)
    polygons: NDArray[np.object_]  # (n - n_whole,) shapely polygons
    reference: Floats  # (n, 2) a point inside
    vertices: Floats  # (v, 2) all vertices
    rings: Rings  # round the elements
    edges: Edges  # undirected edges between elements
    is_crack: Bools  # (e,) which of `edges` lie on a crack or an interface
    lines: tuple[FaceEdges, ...]  # crack by crack, then interface by interface
    outlines: OutlineEdges
    tree: shapely.STRtree  # over `polygons`
    whole_of_tile: Ints  # (tiles,) element of a whole tile, -1 elsewhere

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.body)

    @property
    def passable(self) -> Bools:
        """Which of `edges` (e,) lead through rock: between two elements of one body and not along a crack."""
        passable = (self.edges.right >= 0) & ~self.is_crack
        return np.asarray(passable & (self.body[self.edges.left] == self.body[self.edges.right]))


def cut_elements(lattice: Lattice, bodies: Sequence[BodyGeometry], lines: Sequence[CrackGeometry]) -> Elements:
    """Cut bodies, cracks and interfaces (lines without tips between two bodies) into manifold elements."""
    cutting = _cutting_lines(lattice, bodies, lines)
    regions = [body.region for body in bodies]
    shapely.prepare(regions)
    body_of_tile = bodies_at(regions, lattice.tile_low + 0.5 * lattice.tile_size[:, None])
    touched, cut = _cut(lattice, cutting, regions)
    whole = np.flatnonzero(~touched & (body_of_tile >= 0))
    vertices, rings = _rings(lattice.tiles, whole, cut.polygons)
    edges = edges_between(rings, len(vertices))
    on_sides, on_lines = cutting.traces(*edges_along(cutting.pieces, cutting.start[-1], vertices, edges))
    line_edges = edges_on_lines(lines, on_lines, vertices, edges)
    is_crack = np.zeros(len(edges.a), dtype=bool)
    is_crack[np.concatenate([edge for edge, _ in on_lines] or [np.empty(0, dtype=np.int64)])] = True
    whole_of_tile = np.full(lattice.tiles.squares.n, -1, dtype=np.int64)
    whole_of_tile[whole] = np.arange(len(whole))
    body = np.concatenate([body_of_tile[whole], cut.body])
    tile = np.concatenate([whole, cut.tile])
    middles = lattice.tile_low[whole] + 0.5 * lattice.tile_size[whole, None]
    return Elements(
        n_whole=len(whole),
        tile=tile,
        size=lattice.cells.size[lattice.tiles.cell[tile]] / QUANTA,
        body=body,
        polygons=cut.polygons,
        reference=np.concatenate([middles, cut.reference]),
        vertices=vertices,
        rings=rings,
        edges=edges,
        is_crack=is_crack,
        lines=line_edges,
        outlines=edges_on_outlines(on_sides, vertices, edges, body),
        tree=shapely.STRtree(cut.polygons),
        whole_of_tile=whole_of_tile,
    )


def _rings(tiles: Tiles, whole: Ints, polygons: NDArray[np.object_]) -> tuple[Floats, Rings]:
    """All vertices (v, 2): corners of tiles and of polygons that tiles are cut into; and the rings of the `whole` tiles
    (n_whole,), then of these polygons.
    """
    points, ends, polygon = ring_vertices(polygons)
    numbers = distinct(np.concatenate([tiles.corners, as_complex(points)]))
    corner, vertex = (np.searchsorted(numbers, some) for some in (tiles.corners, as_complex(points)))
    of_whole, place = tiles.ring.places(whole)
    return np.stack([numbers.real, numbers.imag], axis=1), Rings(
        start=np.concatenate([corner[tiles.ring.values[place]], vertex]),
        end=np.concatenate([corner[tiles.following[place]], vertex[ends]]),
        face=np.concatenate([of_whole, polygon + len(whole)]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _CuttingLines:
    """All that cuts tiles: sides of bodies, lines, and what leads on from their tips."""

    pieces: Pieces
    start: Ints  # (bodies + lines + 1,) numbers of the first segments of each body and line, then of the extensions
    sides: list[Ints]  # body by body the sides that its segments lie on
    tips: Floats  # (k, 2)

    def traces(self, edge: Ints, segment: Ints) -> tuple[list[tuple[Ints, Ints]], list[tuple[Ints, Ints]]]:
        """Body by body the edges (p,) on its pieces and its sides (p,) that they lie on; line by line these and the
        segments. From all edges (k,) on segments (k,), ascending.
        """
        limits = zip(pairwise(np.searchsorted(segment, self.start).tolist()), self.start[:-1], strict=True)
        found = [(edge[i:j], segment[i:j] - first) for (i, j), first in limits]
        n = len(self.sides)
        return [(at, side[part]) for (at, part), side in zip(found[:n], self.sides, strict=True)], found[n:]


def _cutting_lines(lattice: Lattice, bodies: Sequence[BodyGeometry], lines: Sequence[CrackGeometry]) -> _CuttingLines:
    cut_sides = [sides_through_junctions(body.sides, lines) for body in bodies]
    segments = [
        *(parts for parts, _ in cut_sides),
        *(np.stack([line.points[:-1], line.points[1:]], axis=1) for line in lines),
    ]
    pieces = cut_in_pieces(np.concatenate([*segments, *extensions_of(lattice, lines)]), lattice.tiles.squares)
    start = starts_of(np.array([len(part) for part in segments], dtype=np.int64))
    tips = [line.seen_from(at_end)[0] for line in lines for at_end in line.tips()]
    return _CuttingLines(pieces, start, [side for _, side in cut_sides], np.array(tips).reshape(-1, 2))


def _cut(lattice: Lattice, cutting: _CuttingLines, regions: Sequence[shapely.Polygon]) -> tuple[Bools, CutTiles]:
    """The touched tiles (tiles,) and the polygons that they are cut into.

    Where lines meet within rounding of a tile's side, both tiles beside it get that point, and are cut again.
    """
    ends, points = cutting.pieces.ends, cutting.pieces.points
    while True:
        samples = np.concatenate([points, 0.5 * (ends[:, 0] + ends[:, 1])])
        touched = _touched(lattice.tiles.squares, samples, cutting.tips)
        cut, extra = cut_tiles(lattice, touched, ends, points, regions)
        if len(extra) == 0:
            return touched, cut
        points = np.concatenate([points, extra])


def _touched(tiles: Squares, samples: Floats, tips: Floats) -> Bools:
    """Which tiles (tiles,) one of `samples` (n, 2) touches, those round the tiles with a tip (k, 2) included."""
    touched = np.zeros(tiles.n + 1, dtype=bool)  # the last entry serves the number -1
    near = (samples + _TOUCHING[:, None]).reshape(-1, 2)
    tip = np.unique(tiles.around(tips))  # all that touch it: the mirrored tip has the mirrored ones
    tip = tip[tip >= 0]
    beside = tiles.low[tip] + (tiles.size[tip, None] * _ROUND_TIP[:, None]) // 8
    places = np.concatenate([np.floor(near * QUANTA).astype(np.int64), beside.reshape(-1, 2)])
    touched[tiles.at(places)] = True
    return touched[:-1]


def locate(lattice: Lattice, elements: Elements, points: Floats, body: int | Ints | None = None) -> Ints:
    """Element (n,) that holds each of `points` (n, 2) in lattice coordinates; -1 for none.

    Of several, on whose rims a point lies, it is the first, whatever there is elsewhere.

    body: the one that it must belong to, for all points or point by point (n,); any if None
    """
    found = np.full(len(points), -1, dtype=np.int64)
    tile = lattice.tiles_at(points)
    inside = tile >= 0
    found[inside] = elements.whole_of_tile[tile[inside]]
    rest = np.flatnonzero(inside & (found < 0))
    which, polygon = elements.tree.query(shapely.points(points[rest]), predicate="dwithin", distance=ON_LINE)
    if body is not None:
        found[(found >= 0) & (elements.body[found] != body)] = -1
        mine = elements.body[polygon + elements.n_whole] == np.broadcast_to(body, len(points))[rest[which]]
        which, polygon = which[mine], polygon[mine]
    order = np.argsort(-polygon, kind="stable")  # hits come in the order of the tree
    found[rest[which[order]]] = polygon[order] + elements.n_whole  # the last one stays
    return found
