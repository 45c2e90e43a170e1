"""The cover of one configuration: lattice, elements, physical patches, tips, and the numbering of all functions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crackgrow.cover.elements import CrackGeometry, Elements, cut_elements
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.patches import physical_patches
from crackgrow.cover.tips import N_TIP_FUNCTIONS, Tip, make_tip
from crackgrow.geometry.arrangement import on_grid
from crackgrow.geometry.tolerance import TOUCH

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SPECK = 1e-15
"""A patch whose weight is nowhere larger than this contributes less than round-off."""


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """Everything that depends on where the bodies and cracks lie, and on nothing else.

    Functions are numbered: the physical patches first, one each; then four per singular patch, tip by tip.
    The displacement components of function k are the unknowns 2 k and 2 k + 1.
    """

    lattice: Lattice
    cracks: tuple[CrackGeometry, ...]
    elements: Elements
    functions: Ints  # (elements, window) physical patch of each node of the window, -1 for none
    patch_nodes: Ints  # (n_patches, 2) node of each physical patch
    tips: tuple[Tip, ...]
    tip_ends: tuple[tuple[int, bool], ...]  # crack index and whether the tip is at its end, tip by tip
    tip_function_ids: tuple[Ints, ...]  # tip by tip (n_patches,): first of a patch's four functions, or -1
    n_functions: int

    @property
    def n_dofs(self) -> int:
        """Number of displacement unknowns."""
        return 2 * self.n_functions


def build_cover(lattice: Lattice, bodies: list[Floats], cracks: list[CrackGeometry]) -> Cover:
    """Cover of bodies (outlines (n, 2)) and cracks, all in lattice coordinates.

    Raises GeometryError where the cover cannot represent a crack.
    """
    bodies = [on_grid(outline) for outline in bodies]
    cracks = [replace(crack, points=on_grid(crack.points)) for crack in cracks]
    elements = cut_elements(lattice, bodies, cracks)
    functions, patch_nodes = physical_patches(lattice, elements)
    functions, patch_nodes = _without_specks(lattice, elements, functions, patch_nodes)
    reach = 2.0 * np.sqrt(2.0) * lattice.support  # the farthest point of a patch that holds the tip
    tips, tip_ends, tip_function_ids = [], [], []
    n_functions = len(patch_nodes)
    for index, crack in enumerate(cracks):
        for at_end in crack.tips():
            from_tip = crack.points[::-1] if at_end else crack.points
            tips.append(make_tip(from_tip, reach, crack.tip_at_start if at_end else crack.tip_at_end))
            tip_ends.append((index, at_end))
            singular = _singular_patches(lattice, elements, functions, patch_nodes, index, crack, at_end)
            first = np.full(len(patch_nodes), -1, dtype=np.int64)
            first[singular] = n_functions + N_TIP_FUNCTIONS * np.arange(len(singular))
            n_functions += N_TIP_FUNCTIONS * len(singular)
            tip_function_ids.append(first)
    return Cover(
        lattice,
        tuple(cracks),
        elements,
        functions,
        patch_nodes,
        tuple(tips),
        tuple(tip_ends),
        tuple(tip_function_ids),
        n_functions,
    )


def _without_specks(lattice: Lattice, elements: Elements, functions: Ints, nodes: Ints) -> tuple[Ints, Ints]:
    """Leave out physical patches in which the weight stays below round-off: they would give zero rows.

    The weight of a patch grows as the cube of the depth inside of the patch, per axis.
    """
    deepest = np.zeros(len(nodes))
    for owner, points in (
        (elements.ring_element, elements.vertices[elements.ring_start]),
        (np.arange(elements.n), elements.reference),
    ):
        used = functions[owner]
        depth = 1.0 - np.abs(points[:, None, :] - nodes[used]) / lattice.support
        weight = np.prod(np.maximum(depth, 0.0), axis=2) ** 3
        np.maximum.at(deepest, used[used >= 0], weight[used >= 0])
    kept = deepest > SPECK
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)  # the last entry serves the index -1
    return number[functions], nodes[kept]


def _singular_patches(
    lattice: Lattice,
    elements: Elements,
    functions: Ints,
    nodes: Ints,
    index: int,
    crack: CrackGeometry,
    at_end: bool,
) -> Ints:
    """Physical patches that a tip ends in: the crack's two faces at the tip belong to the same piece."""
    edges = elements.cracks[index]
    last = -1 if at_end else 0
    plus, minus = functions[edges.plus[last]], functions[edges.minus[last]]
    candidates = np.intersect1d(plus[plus >= 0], minus[minus >= 0])
    inside = np.abs(nodes[candidates] - crack.tip_point(at_end)).max(axis=1) < lattice.support - TOUCH
    return np.asarray(candidates[inside])
