"""The cover of one configuration: lattice, elements, physical patches, tips, and the numbering of all functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.crumbs import Crumbs, find_crumbs, with_crumbs
from crackgrow.cover.elements import Elements, cut_elements
from crackgrow.cover.enrichment import Enrichment, enrichment_of
from crackgrow.cover.face_edges import FaceEdges, edges_of_region
from crackgrow.cover.junctions import with_junctions
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.patches import physical_patches, without_specks
from crackgrow.cover.pieces import cut_in_pieces
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.cover.tiles import tile_lines, tiles_at
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, beyond_far_end, carrying_nodes, make_tip, reach_of_tips
from crackgrow.geometry.arrangement import on_grid


@dataclass(frozen=True, slots=True, eq=False)
class Foundation:
    """A part of a body's rim that a rigid foundation lies under."""

    name: str
    body: int
    sides: Ints  # (k,) sides of the body
    limits: Floats  # (k, 2) fractions of each side's length


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A line where two faces can touch: a crack, an interface, or a body's rim on a foundation."""

    name: str
    points: Floats  # (n, 2) its corners
    edges: FaceEdges
    tip_at_start: bool
    tip_at_end: bool
    junctions: Bools  # (n,) which corners are junctions with other surfaces


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """Everything that depends on where the bodies and cracks lie, and on nothing else.

    Functions are numbered: the physical patches first, one each; then four per singular patch, tip by tip.
    The displacement components of function k are the unknowns 2 k and 2 k + 1.
    """

    lattice: Lattice
    bodies: tuple[BodyGeometry, ...]
    cracks: tuple[CrackGeometry, ...]
    surfaces: tuple[Surface, ...]  # the cracks, then the interfaces, then the foundations
    elements: Elements
    functions: Ints  # (elements, window) physical patch of each node of the window, -1 for none
    patch_nodes: Floats  # (n_patches, 2) node of each physical patch; corners of crumbs
    crumbs: Crumbs
    tips: tuple[Tip, ...]
    tip_ends: tuple[tuple[int, bool], ...]  # crack index and whether the tip is at its end, tip by tip
    tip_function_ids: tuple[Ints, ...]  # tip by tip (n_patches,): first of a patch's four functions, or -1
    n_functions: int
    enrichment: Enrichment  # which tips act on which elements
    crack_tree: shapely.STRtree  # over the cracks
    outline_tree: shapely.STRtree  # over the edges of `elements.outlines`

    @property
    def n_dofs(self) -> int:
        """Number of displacement unknowns."""
        return 2 * self.n_functions

    @property
    def touching(self) -> Bools:
        """Which edges of the arrangement (e,) lie on a surface."""
        on_surface = np.zeros(len(self.elements.edges.a), dtype=bool)
        for surface in self.surfaces:
            on_surface[surface.edges.edge] = True
        return on_surface


def build_cover(
    lattice: Lattice,
    bodies: Sequence[BodyGeometry],
    cracks: Sequence[CrackGeometry],
    interfaces: Sequence[CrackGeometry] = (),
    foundations: Sequence[Foundation] = (),
    before: Cover | None = None,
) -> Cover:
    """Cover of bodies, cracks, interfaces (lines without tips) and foundations, all in lattice coordinates.

    What is cut as in the cover `before` is taken over; the result is the same without it. Raises GeometryError where
    the cover cannot represent a crack.
    """
    bodies = [BodyGeometry(tuple(on_grid(ring) for ring in body.rings), body.name) for body in bodies]
    lines = with_junctions(_on_grid(cracks), _on_grid(interfaces))
    cracks = lines[: len(cracks)]
    known = before.elements if before is not None and _same_bodies(before, lattice, bodies) else None
    elements = cut_elements(lattice, bodies, lines, known)
    surfaces = [
        Surface(line.name, line.points, edges, line.tip_at_start, line.tip_at_end, line.junctions)
        for line, edges in zip(lines, elements.lines, strict=True)
    ]
    surfaces.extend(_on_foundation(elements, bodies, foundation) for foundation in foundations)
    functions, nodes = without_specks(lattice, elements, *physical_patches(lattice, elements))
    crumbs = find_crumbs(lattice, elements, _elements_at_tips(elements, cracks))
    functions, patch_nodes = with_crumbs(crumbs, functions, nodes)
    reach = reach_of_tips(lattice.support)
    tips, tip_ends, tip_function_ids = [], [], []
    n_functions = len(patch_nodes)
    for index, crack in enumerate(cracks):
        for at_end in crack.tips():
            singular = _singular_patches(lattice, elements, functions, patch_nodes, index, crack, at_end)
            from_tip = crack.points[::-1] if at_end else crack.points
            ends_inside = (crack.tip_at_start if at_end else crack.tip_at_end) or _leads_through(
                lattice, elements, functions, singular, beyond_far_end(from_tip, reach)
            )
            tip = make_tip(from_tip, reach, ends_inside)
            singular = singular[carrying_nodes(tip, patch_nodes[singular])]
            tips.append(tip)
            tip_ends.append((index, at_end))
            first = np.full(len(patch_nodes), -1, dtype=np.int64)
            first[singular] = n_functions + N_TIP_FUNCTIONS * np.arange(len(singular))
            n_functions += N_TIP_FUNCTIONS * len(singular)
            tip_function_ids.append(first)
    return Cover(
        lattice,
        tuple(bodies),
        tuple(cracks),
        tuple(surfaces),
        elements,
        functions,
        patch_nodes,
        crumbs,
        tuple(tips),
        tuple(tip_ends),
        tuple(tip_function_ids),
        n_functions,
        enrichment_of(functions, tip_function_ids),
        shapely.STRtree([shapely.LineString(crack.points) for crack in cracks]),
        shapely.STRtree(shapely.linestrings(elements.outlines.points)),
    )


def _same_bodies(before: Cover, lattice: Lattice, bodies: Sequence[BodyGeometry]) -> bool:
    """Whether a cover has the same lattice and bodies."""
    known, wanted = ([[ring.tobytes() for ring in body.rings] for body in some] for some in (before.bodies, bodies))
    return before.lattice is lattice and known == wanted


def _elements_at_tips(elements: Elements, cracks: Sequence[CrackGeometry]) -> Ints:
    """An element (tips,) at every tip."""
    ends = zip(cracks, elements.lines, strict=False)  # interfaces follow the cracks
    return np.array([edges.plus[-1 if end else 0] for crack, edges in ends for end in crack.tips()], dtype=np.int64)


def _on_grid(lines: Sequence[CrackGeometry]) -> list[CrackGeometry]:
    """Lines with their vertices on the grid of the arrangement."""
    return [replace(line, points=on_grid(line.points)) for line in lines]


def _on_foundation(elements: Elements, bodies: Sequence[BodyGeometry], foundation: Foundation) -> Surface:
    """The surface between a body's rim and a rigid foundation."""
    sides = bodies[foundation.body].sides
    edges = edges_of_region(elements.outlines, foundation.body, sides, foundation.sides, foundation.limits)
    start, step = sides[foundation.sides, 0], np.diff(sides[foundation.sides], axis=1)[:, 0]
    begin = start + foundation.limits[:, :1] * step
    end = start[-1:] + foundation.limits[-1:, 1:] * step[-1:]
    points = np.concatenate([begin, end])
    return Surface(foundation.name, points, edges, False, False, np.zeros(len(points), dtype=bool))


def _singular_patches(
    lattice: Lattice,
    elements: Elements,
    functions: Ints,
    nodes: Floats,
    index: int,
    crack: CrackGeometry,
    at_end: bool,
) -> Ints:
    """Physical patches that a tip ends in: the crack's two faces at the tip belong to the same piece."""
    edges = elements.lines[index]
    last = -1 if at_end else 0
    plus, minus = functions[edges.plus[last]], functions[edges.minus[last]]
    candidates = np.array(sorted({*plus.tolist()} & {*minus.tolist()} - {-1}), dtype=np.int64)
    inside = np.abs(nodes[candidates] - crack.tip_point(at_end)).max(axis=1) < lattice.support
    return np.asarray(candidates[inside])


def _leads_through(lattice: Lattice, elements: Elements, functions: Ints, patches: Ints, segment: Floats) -> bool:
    """Whether a segment (2, 2) leads through an element with one of `patches`."""
    cut = elements.tree.query(shapely.linestrings(segment), predicate="intersects") + elements.n_whole
    pieces = cut_in_pieces(segment[None], *tile_lines(lattice))
    tiles = tiles_at(lattice, np.concatenate([pieces.points, pieces.ends.mean(axis=1)]))
    tiles = tiles[np.all((tiles >= 0) & (tiles < elements.whole_of_tile.shape), axis=1)]
    whole = elements.whole_of_tile[tuple(tiles.T)]
    through = np.concatenate([cut, whole[whole >= 0]])
    return bool((functions[through, :, None] == patches).any())
