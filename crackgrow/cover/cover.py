"""The cover of one configuration: lattice, elements, physical patches, tips, and the numbering of all functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats
from crackgrow.case.regions import EdgeRegion
from crackgrow.case.surface import SurfaceName
from crackgrow.cover.cell_lengths import CellLengths, cell_lengths, sizes_beside
from crackgrow.cover.elements import Elements, cut_elements
from crackgrow.cover.enrichment import Enrichment, enrichment_of, make_tips
from crackgrow.cover.face_edges import FaceEdges, edges_of_region
from crackgrow.cover.junctions import with_junctions
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.patches import Patches, physical_patches
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry, body_index
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, tip_table
from crackgrow.geometry.arrangement import on_grid
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.ragged import Ragged, starts_of


@dataclass(frozen=True, slots=True, eq=False)
class Foundation:
    """A part of a body's rim that a rigid foundation lies under."""

    name: SurfaceName
    region: EdgeRegion
    moves: tuple[float, float] = (0.0, 0.0)  # m, at load factor 1


@dataclass(frozen=True, eq=False)
class Surface:
    """A line where two faces can touch: a crack, an interface, or a body's rim on a foundation."""

    line: CrackGeometry
    edges: FaceEdges
    sizes: Floats  # (edges,) side of the cells beside each edge, spacings: of the larger on its two faces

    @property
    def name(self) -> SurfaceName:
        """Which surface it is."""
        return self.line.name

    @cached_property
    def in_cells(self) -> CellLengths:
        """Lengths along it in cells."""
        return cell_lengths(arc_lengths(self.line.points)[-1], self.edges, self.sizes)


@dataclass(frozen=True, eq=False)
class Cover:
    """Everything that depends on where the bodies and cracks lie, and on nothing else.

    Functions are numbered: the physical patches first, one each; then four per carrier, tip by tip.
    The displacement components of function k are the unknowns 2 k and 2 k + 1.
    """

    lattice: Lattice
    bodies: tuple[BodyGeometry, ...]
    cracks: tuple[CrackGeometry, ...]
    surfaces: tuple[Surface, ...]  # the cracks, then the interfaces, then the foundations
    elements: Elements
    patches: Patches
    tips: tuple[Tip, ...]
    enrichment: Enrichment  # which tips act on which elements
    touching: Bools  # (e,) which edges of the arrangement lie on a surface
    crack_tree: shapely.STRtree  # over the cracks
    outline_tree: shapely.STRtree  # over the edges of `elements.outlines`

    @property
    def n_dofs(self) -> int:
        """Number of displacement unknowns."""
        return 2 * self.n_functions

    @property
    def n_functions(self) -> int:
        """Number of functions."""
        if not self.tips:
            return len(self.patches.nodes)
        last = self.tips[-1]
        return last.first_function + N_TIP_FUNCTIONS * last.carriers.n

    @property
    def tip_ends(self) -> list[tuple[int, bool]]:
        """Tip by tip the number of its crack, and whether it is at the crack's end."""
        return [(tip.crack, tip.at_end) for tip in self.tips]

    def edges_on(self, region: EdgeRegion) -> FaceEdges:
        """The edges along a part of a rim."""
        return edges_of_region(self.elements.outlines, self.bodies, region)

    @cached_property
    def functions(self) -> Ragged:
        """All functions of each element: its physical patches, then four for each carrier, tip by tip."""
        plain, enrichment = self.patches.of_element, self.enrichment
        numbers = enrichment.first.values[:, None] + np.arange(N_TIP_FUNCTIONS)
        n_tip = N_TIP_FUNCTIONS * np.diff(enrichment.first.start[enrichment.tips.start])
        is_tip = np.repeat(np.arange(2 * plain.n) % 2 == 1, np.stack([plain.counts, n_tip], axis=1).ravel())
        values = np.empty(len(is_tip), dtype=np.int64)
        values[~is_tip], values[is_tip] = plain.values, numbers.ravel()
        return Ragged(starts_of(plain.counts + n_tip), values)

    @cached_property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """What kernels evaluate the functions of elements by (`approximation.basis`)."""
        patches, enrichment = self.patches, self.enrichment
        return (
            np.ascontiguousarray(patches.nodes),
            1.0 / patches.weight_half,
            patches.of_element.start,
            patches.of_element.values,
            enrichment.tips.start,
            enrichment.tips.values,
            enrichment.side,
            enrichment.first.start,
            enrichment.place.start,
            enrichment.place.values,
            enrichment.share,
            tip_table(self.tips, [self.bodies[tip.body].roots for tip in self.tips]),
        )


def build_cover(
    lattice: Lattice,
    bodies: Sequence[BodyGeometry],
    cracks: Sequence[CrackGeometry],
    interfaces: Sequence[CrackGeometry] = (),
    foundations: Sequence[Foundation] = (),
) -> Cover:
    """Cover of bodies, cracks, interfaces (lines without tips) and foundations, all in lattice coordinates.

    Raises GeometryError where the cover cannot represent a crack.
    """
    bodies = [replace(body, rings=tuple(on_grid(ring) for ring in body.rings)) for body in bodies]
    lines = with_junctions(_on_grid(cracks), _on_grid(interfaces))
    cracks = lines[: len(cracks)]
    elements = cut_elements(lattice, bodies, lines)
    surfaces = _surfaces(elements, bodies, lines, foundations)
    patches = physical_patches(lattice, elements, cracks)
    tips = make_tips(lattice, elements, cracks, patches)
    enrichment = enrichment_of(patches.of_element, tips, elements.reference)
    touching = np.zeros(len(elements.edges.a), dtype=bool)
    for surface in surfaces:
        touching[surface.edges.edge] = True
    return Cover(
        lattice=lattice,
        bodies=tuple(bodies),
        cracks=tuple(cracks),
        surfaces=surfaces,
        elements=elements,
        patches=patches,
        tips=tips,
        enrichment=enrichment,
        touching=touching,
        crack_tree=shapely.STRtree([shapely.LineString(crack.points) for crack in cracks]),
        outline_tree=shapely.STRtree(shapely.linestrings(elements.outlines.points)),
    )


def _surfaces(
    elements: Elements,
    bodies: Sequence[BodyGeometry],
    lines: Sequence[CrackGeometry],
    foundations: Sequence[Foundation],
) -> tuple[Surface, ...]:
    """The surfaces along `lines` and `foundations`."""
    along = [*zip(lines, elements.lines, strict=True)]
    along += [_on_foundation(elements, bodies, foundation) for foundation in foundations]
    return tuple(Surface(line, edges, sizes_beside(edges, elements.size)) for line, edges in along)


def _on_grid(lines: Sequence[CrackGeometry]) -> list[CrackGeometry]:
    """Lines with their vertices on the grid of the arrangement."""
    return [replace(line, points=on_grid(line.points)) for line in lines]


def _on_foundation(
    elements: Elements, bodies: Sequence[BodyGeometry], foundation: Foundation
) -> tuple[CrackGeometry, FaceEdges]:
    """The line between a body's rim and a rigid foundation, and the edges along it."""
    region, limits = foundation.region, foundation.region.limits
    edges, sides = edges_of_region(elements.outlines, bodies, region), bodies[body_index(bodies, region.body)].sides
    start, step = sides[region.sides, 0], np.diff(sides[region.sides], axis=1)[:, 0]
    begin = start + limits[:, :1] * step
    end = start[-1:] + limits[-1:, 1:] * step[-1:]
    return CrackGeometry(foundation.name, np.concatenate([begin, end]), False, False), edges
