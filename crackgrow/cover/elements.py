"""Manifold elements: the pieces into which tiles, outlines and cracks cut the bodies.

Which piece a point belongs to, and on which side of a crack, is decided here and nowhere else: quadrature points are
made inside an element, contact points know the elements on their two sides, other points are located.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from crackgrow.cover.lattice import Lattice
from crackgrow.cover.tiles import tile_lines, tile_outlines, tiles_at, touched_tiles
from crackgrow.errors import GeometryError
from crackgrow.geometry.arrangement import Edges, edges_between, faces_of, ring_vertices, vertex_ids
from crackgrow.geometry.polyline import arc_lengths, segment_directions, tip_direction
from crackgrow.geometry.tolerance import ON_LINE

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class CrackGeometry:
    """A crack in lattice coordinates."""

    name: str
    points: Floats  # (n, 2)
    tip_at_start: bool
    tip_at_end: bool

    def tips(self) -> list[bool]:
        """The ends that are tips: False for the start, True for the end."""
        return [at_end for at_end, tip in ((False, self.tip_at_start), (True, self.tip_at_end)) if tip]

    def tip_point(self, at_end: bool) -> Floats:
        """Position (2,) of the tip at the end or start."""
        return np.asarray(self.points[-1 if at_end else 0])


@dataclass(frozen=True, slots=True, eq=False)
class CrackEdges:
    """Edges of the arrangement along one crack, in order of arc length from its start."""

    s: Floats  # (n, 2) arc length at both ends, spacings
    points: Floats  # (n, 2, 2) both ends
    segment: Ints  # (n,) segment of the polyline
    plus: Ints  # (n,) element on the left of the direction from start to end
    minus: Ints  # (n,) element on the right


@dataclass(frozen=True, slots=True, eq=False)
class OutlineEdges:
    """Edges of the arrangement along the outlines."""

    points: Floats  # (n, 2, 2) both ends, counter-clockwise
    body: Ints  # (n,)
    segment: Ints  # (n,) edge of the body's outline
    element: Ints  # (n,) element inside


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
    is_crack: Bools  # (e,) which of `edges` lie on a crack
    cracks: tuple[CrackEdges, ...]  # crack by crack
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


def cut_elements(lattice: Lattice, bodies: list[Floats], cracks: list[CrackGeometry]) -> Elements:
    """Cut bodies (outlines (n, 2), lattice coordinates, counter-clockwise) and cracks into manifold elements."""
    tips = np.array([crack.tip_point(at_end) for crack in cracks for at_end in crack.tips()]).reshape(-1, 2)
    outline_segments = [np.stack([outline, np.roll(outline, -1, axis=0)], axis=1) for outline in bodies]
    crack_segments = [np.stack([crack.points[:-1], crack.points[1:]], axis=1) for crack in cracks]
    extensions = [_tip_extension(lattice, crack, at_end)[None] for crack in cracks for at_end in crack.tips()]
    segments = np.concatenate(outline_segments + crack_segments + extensions)
    touched = touched_tiles(lattice, segments, tips)
    regions = [shapely.Polygon(outline) for outline in bodies]
    shapely.prepare(regions)

    whole_tiles, whole_body = _whole_tiles(lattice, touched, regions)
    lines = np.concatenate(
        [
            tile_outlines(lattice, np.argwhere(touched)),
            shapely.linestrings(segments),
        ]
    )
    polygons = faces_of(lines)
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
    crack_edges, is_crack = _edges_on_cracks(cracks, vertices, edges, n_whole)
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
        cracks=crack_edges,
        outlines=_edges_on_outlines(bodies, vertices, edges, element_body),
        tree=shapely.STRtree(polygons),
        whole_of_tile=whole_of_tile,
    )


def locate(lattice: Lattice, elements: Elements, points: Floats) -> Ints:
    """Element (n,) that holds each of `points` (n, 2) in lattice coordinates; -1 outside of all bodies."""
    found = np.full(len(points), -1, dtype=np.int64)
    tile = tiles_at(lattice, points)
    inside = np.all((tile >= 0) & (tile < elements.whole_of_tile.shape), axis=1)
    found[inside] = elements.whole_of_tile[tuple(tile[inside].T)]
    rest = np.flatnonzero(inside & (found < 0))
    which, polygon = elements.tree.query(shapely.points(points[rest]), predicate="dwithin", distance=ON_LINE)
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


def _edges_on_cracks(
    cracks: list[CrackGeometry], vertices: Floats, edges: Edges, n_whole: int
) -> tuple[tuple[CrackEdges, ...], Bools]:
    """The edges along each crack, sorted and turned along it, and which of all edges they are."""
    is_crack = np.zeros(len(edges.a), dtype=bool)
    candidates = np.flatnonzero((edges.right >= n_whole) & (edges.left >= n_whole))
    middles = shapely.points(0.5 * (vertices[edges.a[candidates]] + vertices[edges.b[candidates]]))
    tree = shapely.STRtree(middles)
    found = []
    for crack in cracks:
        lines = shapely.linestrings(np.stack([crack.points[:-1], crack.points[1:]], axis=1))
        segment, hit = tree.query(lines, predicate="dwithin", distance=ON_LINE)
        hit, first = np.unique(hit, return_index=True)
        chain = _chain(vertices, edges.a[candidates[hit]], edges.b[candidates[hit]], crack)
        edge, segment = candidates[hit[chain]], segment[first[chain]]
        along = segment_directions(crack.points)[segment]
        forward = np.sum((vertices[edges.b[edge]] - vertices[edges.a[edge]]) * along, axis=1) > 0
        start = np.where(forward, edges.a[edge], edges.b[edge])
        end = np.where(forward, edges.b[edge], edges.a[edge])
        offset = np.sum((vertices[start] - crack.points[segment]) * along, axis=1)
        lengths = np.sum((vertices[end] - vertices[start]) * along, axis=1)
        s = arc_lengths(crack.points)[segment] + offset
        is_crack[edge] = True
        found.append(
            CrackEdges(
                s=np.stack([s, s + lengths], axis=1),
                points=np.stack([vertices[start], vertices[end]], axis=1),
                segment=segment,
                plus=np.where(forward, edges.left[edge], edges.right[edge]),
                minus=np.where(forward, edges.right[edge], edges.left[edge]),
            )
        )
    return tuple(found), is_crack


def _chain(vertices: Floats, a: Ints, b: Ints, crack: CrackGeometry) -> Ints:
    """The edges (a, b), of those that lie on a crack within rounding, that lead from its start to its end, in order.

    A lattice line closer to the crack than rounding gives more than one way; the shortest is taken.
    """
    used, ends = np.unique(np.concatenate([a, b]), return_inverse=True)
    ends = ends.reshape(2, -1)
    n = len(used)
    lengths = np.hypot(*(vertices[b] - vertices[a]).T)
    graph = coo_array((lengths, tuple(ends)), shape=(n, n)).tocsr()
    number = coo_array((np.arange(1, len(a) + 1), tuple(ends)), shape=(n, n)).tocsr()
    first, last = (int(np.argmin(np.hypot(*(vertices[used] - p).T))) for p in crack.points[[0, -1]])
    length, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    total = arc_lengths(crack.points)[-1]
    if abs(length[last] - total) > 1e-6 * max(total, 1.0):
        raise GeometryError(f"crack '{crack.name}' could not be cut along all of its {total:g} spacings")
    chain = []
    while last != first:
        chain.append(number[before[last], last] + number[last, before[last]] - 1)
        last = int(before[last])
    return np.array(chain[::-1], dtype=np.int64)


def _edges_on_outlines(bodies: list[Floats], vertices: Floats, edges: Edges, body: Ints) -> OutlineEdges:
    """The edges along the outlines, with the outline's edge that each lies on."""
    free = np.flatnonzero(edges.right < 0)
    points = np.stack([vertices[edges.a[free]], vertices[edges.b[free]]], axis=1)
    middles = points.mean(axis=1)
    element = edges.left[free]
    segment = np.full(len(free), -1, dtype=np.int64)
    for index, outline in enumerate(bodies):
        mine = np.flatnonzero(body[element] == index)
        lines = shapely.linestrings(np.stack([outline, np.roll(outline, -1, axis=0)], axis=1))
        distances = shapely.distance(shapely.points(middles[mine])[:, None], lines[None, :])
        segment[mine] = np.argmin(distances, axis=1)
        if len(mine) and distances.min(axis=1).max() > ON_LINE:
            raise GeometryError("an element has a side that is neither shared nor on an outline")
    return OutlineEdges(points, body[element], segment, element)
