"""Manifold elements: the pieces into which tiles, outlines and cracks cut the bodies.

Which piece a point belongs to, and on which side of a crack, is decided here and nowhere else: quadrature points are
made inside an element, contact points know the elements on their two sides, other points are located.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.cover.face_edges import FaceEdges, OutlineEdges, edges_on_lines, edges_on_outlines
from crackgrow.cover.junctions import sides_through_junctions
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.tiles import tile_lines, tile_outlines, tiles_at, touched_tiles
from crackgrow.cover.tips import n_outward, reach_of_tips
from crackgrow.errors import GeometryError
from crackgrow.geometry.arrangement import Edges, edges_between, faces_of, ring_vertices, vertex_ids
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import ON_LINE, TOUCH

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

DIAGONAL = 2.0**0.5
"""No two points of an element are further apart, spacings."""


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """All manifold elements: first the whole tiles that nothing touches, then the polygons cut from the others."""

    n_whole: int
    tile: Ints  # (n, 2)
    body: Ints  # (n,)
    polygons: NDArray[np.object_]  # (n - n_whole,) shapely polygons
    reference: Floats  # (n, 2) a point inside
    vertices: Floats  # (v, 2) all vertices
    ring_start: Ints  # (r,) directed ring edges: first vertex id,
    ring_end: Ints  # (r,) second vertex id,
    ring_element: Ints  # (r,) element on the left
    edges: Edges  # undirected edges between elements
    is_crack: Bools  # (e,) which of `edges` lie on a crack or an interface
    lines: tuple[FaceEdges, ...]  # crack by crack, then interface by interface
    outlines: OutlineEdges
    tree: shapely.STRtree  # over `polygons`
    whole_of_tile: Ints  # (tiles x, tiles y) element of a whole tile, -1 elsewhere

    @property
    def n(self) -> int:
        """Number of elements."""
        return len(self.tile)

    @property
    def passable(self) -> Bools:
        """Which of `edges` (e,) lead through rock: between two elements of one body and not along a crack."""
        passable = (self.edges.right >= 0) & ~self.is_crack
        return np.asarray(passable & (self.body[self.edges.left] == self.body[self.edges.right]))


def cut_elements(lattice: Lattice, bodies: list[BodyGeometry], lines: list[CrackGeometry]) -> Elements:
    """Cut bodies, cracks and interfaces (lines without tips between two bodies) into manifold elements."""
    tips = np.array([line.tip_point(at_end) for line in lines for at_end in line.tips()]).reshape(-1, 2)
    body_sides = [body.sides for body in bodies]
    line_segments = [np.stack([line.points[:-1], line.points[1:]], axis=1) for line in lines]
    extensions = [extension for line in lines for extension in _extensions(lattice, line)]
    cut_sides = [sides_through_junctions(sides, lines) for sides in body_sides]
    segments = np.concatenate(cut_sides + line_segments + extensions)
    touched = touched_tiles(lattice, segments, tips)
    regions = [body.region for body in bodies]
    shapely.prepare(regions)

    whole_tiles, whole_body = _whole_tiles(lattice, touched, regions)
    polygons = faces_of(np.concatenate([tile_outlines(lattice, np.argwhere(touched)), shapely.linestrings(segments)]))
    inside_points = _inside_points(polygons)
    body = _bodies_at(regions, inside_points)
    tile = tiles_at(lattice, inside_points)
    keep = (body >= 0) & touched[tuple(tile.T)]
    polygons, inside_points, body, tile = polygons[keep], inside_points[keep], body[keep], tile[keep]

    x, y = tile_lines(lattice)
    i, j = whole_tiles.T
    n_whole = len(whole_tiles)
    corners = np.stack([(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]).transpose(2, 0, 1)
    whole_ends = (4 * np.arange(n_whole)[:, None] + (1, 2, 3, 0)).ravel()
    points, ends, polygon = ring_vertices(polygons)
    all_points = np.concatenate([corners.reshape(-1, 2), points])
    ids = vertex_ids(all_points)
    vertices = np.empty((int(ids.max(initial=-1)) + 1, 2))
    vertices[ids] = all_points
    ring_end = ids[np.concatenate([whole_ends, ends + 4 * n_whole]).astype(np.int64)]
    ring_element = np.concatenate([np.repeat(np.arange(n_whole), 4), polygon + n_whole])
    edges = edges_between(ids, ring_end, ring_element)
    line_edges, is_crack = edges_on_lines(lines, vertices, edges, n_whole)
    whole_of_tile = np.full(touched.shape, -1, dtype=np.int64)
    whole_of_tile[i, j] = np.arange(n_whole)
    element_body = np.concatenate([whole_body, body])
    return Elements(
        n_whole=n_whole,
        tile=np.concatenate([whole_tiles, tile]),
        body=element_body,
        polygons=polygons,
        reference=np.concatenate([corners.mean(axis=1), inside_points]),
        vertices=vertices,
        ring_start=ids,
        ring_end=ring_end,
        ring_element=ring_element,
        edges=edges,
        is_crack=is_crack,
        lines=line_edges,
        outlines=edges_on_outlines(body_sides, vertices, edges, element_body),
        tree=shapely.STRtree(polygons),
        whole_of_tile=whole_of_tile,
    )


def locate(lattice: Lattice, elements: Elements, points: Floats, body: int | Ints | None = None) -> Ints:
    """Element (n,) that holds each of `points` (n, 2) in lattice coordinates; -1 for none.

    body: the one that it must belong to, for all points or point by point (n,); any if None
    """
    found = np.full(len(points), -1, dtype=np.int64)
    tile = tiles_at(lattice, points)
    inside = np.all((tile >= 0) & (tile < elements.whole_of_tile.shape), axis=1)
    found[inside] = elements.whole_of_tile[tuple(tile[inside].T)]
    rest = np.flatnonzero(inside & (found < 0))
    which, polygon = elements.tree.query(shapely.points(points[rest]), predicate="dwithin", distance=ON_LINE)
    if body is not None:
        found[(found >= 0) & (elements.body[found] != body)] = -1
        mine = elements.body[polygon + elements.n_whole] == np.broadcast_to(body, len(points))[rest[which]]
        which, polygon = which[mine], polygon[mine]
    found[rest[which[::-1]]] = polygon[::-1] + elements.n_whole  # the first hit of a point wins
    return found


def _whole_tiles(lattice: Lattice, touched: Bools, regions: list[shapely.Polygon]) -> tuple[Ints, Ints]:
    """Untouched tiles inside a body (n, 2), and their bodies (n,)."""
    x, y = tile_lines(lattice)
    tiles = np.argwhere(~touched)
    centres = np.stack([0.5 * (x[1:] + x[:-1])[tiles[:, 0]], 0.5 * (y[1:] + y[:-1])[tiles[:, 1]]], axis=1)
    body = _bodies_at(regions, centres)
    return tiles[body >= 0], body[body >= 0]


def _bodies_at(regions: list[shapely.Polygon], points: Floats) -> Ints:
    """The body (n,) that holds each of `points` (n, 2), -1 for none."""
    body = np.full(len(points), -1, dtype=np.int64)
    for index, region in enumerate(regions):
        body[shapely.contains_xy(region, points)] = index
    return body


def _inside_points(polygons: NDArray[np.object_]) -> Floats:
    """A point (n, 2) well inside of each polygon: its centroid where that is inside."""
    centroids = shapely.get_coordinates(shapely.centroid(polygons))
    outside = ~shapely.contains_xy(polygons, centroids)
    centroids[outside] = shapely.get_coordinates(shapely.point_on_surface(polygons[outside]))
    return np.asarray(centroids)


def _extensions(lattice: Lattice, crack: CrackGeometry) -> list[Floats]:
    """Segments (n, 2, 2) that lead on from a crack, so that no element holds two sides of it.

    From a tip one leads through its tile: no crack ends inside of an element. Where the crack ends as seen from a tip,
    the jump of the tip's angle leads on. No element may lie on both sides of that, as long as a part of it is nearer to
    the tip than this end, where the tip functions have not faded out yet.
    """
    least: dict[tuple[int, int], float] = {}  # by the last segment: the vertices that it leads from and to
    n = len(crack.points)
    for at_end in crack.tips():
        numbers = range(n)[::-1] if at_end else range(n)
        least.setdefault((numbers[1], numbers[0]), 0.0)
        from_tip = crack.points[::-1] if at_end else crack.points
        last = n_outward(from_tip)
        if np.hypot(*(from_tip[last] - from_tip[0])) < reach_of_tips(lattice.support):
            least[numbers[last - 1], numbers[last]] = DIAGONAL
    found = []
    for segment, length in least.items():
        extension = _extension(lattice, crack.points[list(segment)], length)
        if extension is not None:
            found.append(extension)
        elif length == 0.0:
            raise GeometryError(f"crack '{crack.name}': its tip lies outside of the lattice")
    return found


def _extension(lattice: Lattice, segment: Floats, least: float) -> Floats | None:
    """The straight extension of a segment (2, 2) to the first tile line further than `least` from its end.

    Where the lattice ends before, to its last tile line; None if there is none. It comes in pieces (n, 2, 2) that end
    on tile lines exactly, and on the corners of tiles that it only just misses, since a speck would be cut off there.
    """
    start = segment[1]
    direction = tip_direction(segment, at_end=True)
    far = start + (least + 2.0) * direction
    lines = tile_lines(lattice)
    exits = []
    for axis in range(2):
        low, high = np.sort([start[axis], far[axis]])
        for line in lines[axis][(lines[axis] > low) & (lines[axis] < high)]:
            length = (line - start[axis]) / direction[axis]
            end, other = start + length * direction, lines[1 - axis]
            end[axis] = line
            if length > ON_LINE and other[0] <= end[1 - axis] <= other[-1]:
                near = other[np.abs(other - end[1 - axis]).argmin()]
                end[1 - axis] = near if abs(near - end[1 - axis]) < TOUCH else end[1 - axis]
                exits.append((length, end))
    if not exits:
        return None
    exits.sort(key=lambda found: found[0])
    last = next((k for k, (length, _) in enumerate(exits) if length > least), len(exits) - 1)
    places = np.array([start, *(end for _, end in exits[: last + 1])])
    places = places[np.append(True, np.any(np.diff(places, axis=0) != 0.0, axis=1))]
    return np.stack([places[:-1], places[1:]], axis=1)
