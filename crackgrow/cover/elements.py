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
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.tiles import tile_lines, tile_outlines, tiles_at, touched_tiles
from crackgrow.errors import GeometryError
from crackgrow.geometry.arrangement import Edges, edges_between, faces_of, ring_vertices, vertex_ids
from crackgrow.geometry.polyline import tip_direction
from crackgrow.geometry.tolerance import ON_LINE

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


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
    extensions = [_tip_extension(lattice, line, at_end)[None] for line in lines for at_end in line.tips()]
    segments = np.concatenate(body_sides + line_segments + extensions)
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


def _tip_extension(lattice: Lattice, crack: CrackGeometry, at_end: bool) -> Floats:
    """The segment (2, 2) from a tip straight on through its tile, so that no element has a crack ending inside."""
    tip = crack.tip_point(at_end)
    direction = tip_direction(crack.points, at_end)
    far = tip + 2.0 * direction
    lines = tile_lines(lattice)
    exits = []
    for axis in range(2):
        low, high = np.sort([tip[axis], far[axis]])
        for line in lines[axis][(lines[axis] > low) & (lines[axis] < high)]:
            length = (line - tip[axis]) / direction[axis]
            end = tip + length * direction
            end[axis] = line  # exactly: no vertex beside the line
            exits.append((length, end))
    beyond = [(length, tuple(end)) for length, end in exits if length > ON_LINE]
    if not beyond:
        raise GeometryError(f"crack '{crack.name}': its tip lies outside of the lattice")
    return np.stack([tip, min(beyond)[1]])
