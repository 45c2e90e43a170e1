"""Plain elements, rectangles without singular patches among cells of one size, by their kinds.

Those alike in shape, in the patches over them and in place in their cell have the same functions at the same points,
whatever the size of the cell, hence the same element matrix: it is integrated once, in the unit cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.approximation.mls import mls
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.lattice import Lattice
from crackgrow.cover.squares import QUANTA
from crackgrow.cover.windows import regular_window
from crackgrow.quadrature.elements import ElementPoints, element_points
from crackgrow.quadrature.rules import square


def rectangles(cover: Cover, elements: Ints) -> tuple[Floats, Floats]:
    """Lower left corners (n, 2) and sizes (n, 2) of plain elements (n,)."""
    ring = np.searchsorted(cover.elements.rings.face, elements)
    corners = cover.elements.vertices[cover.elements.rings.start[ring[:, None] + np.arange(4)]]
    low = corners.min(axis=1)
    return low, corners.max(axis=1) - low


@dataclass(frozen=True, slots=True, eq=False)
class PlainKind:
    """Plain elements of one kind, measured in sides of their cells."""

    elements: Ints  # (n,)
    body: int
    low: Floats  # (2,) lower left corner in the unit cell
    size: Floats  # (2,)
    slots: Ints  # (k,) which of the nodes round the cell have a patch here

    def patches(self, cover: Cover) -> Ints:
        """Their physical patches (n, k)."""
        return cover.patches.of_element.taken(self.elements).values.reshape(-1, len(self.slots))

    def functions(self, lattice: Lattice, share: Floats) -> tuple[Floats, Floats]:
        """Functions (k, m) and gradients (2, k, m), per side of a cell, at points by `share` (m, 2) of the size."""
        nodes, points = regular_window(lattice.support)[self.slots], self.low + share * self.size
        distance = (nodes - points[:, None]).reshape(-1, 2).T
        half, start = np.full(distance.shape[1], lattice.support), len(nodes) * np.arange(len(points) + 1)
        found = mls(distance, half, start).reshape(3, len(points), len(nodes)).swapaxes(1, 2)
        return found[0], found[1:]


def plain_kinds(cover: Cover) -> list[PlainKind]:
    """All kinds of plain elements."""
    elements = np.flatnonzero(cover.plain)
    if not len(elements):
        return []
    pattern, slots = _patterns(cover, elements)
    body, part = cover.elements.body[elements], _parts(cover.lattice)[cover.elements.tile[elements]]
    whole = int(np.searchsorted(elements, cover.elements.n_whole))  # those before are alike in one part of their cells
    alike = np.concatenate([part[:whole], int(part.max()) + 1 + np.arange(len(elements) - whole)])
    alike = (alike * (int(body.max()) + 1) + body) * len(slots) + pattern
    _, first, group = np.unique(alike, return_index=True, return_inverse=True)
    low, size = rectangles(cover, elements[first])
    cell = cover.elements.size[elements[first], None]
    low, size = (low - cover.elements.cell[elements[first]]) / cell, size / cell
    kinds = np.column_stack([low, size, body[first], pattern[first]])
    _, example, kind = np.unique(kinds, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(kind.ravel()[group], kind="stable")
    ends = np.cumsum(np.bincount(kind.ravel()[group]))
    members = np.split(elements[order], ends[:-1])
    return [
        PlainKind(mine, int(body[first[at]]), low[at], size[at], slots[pattern[first[at]]])
        for mine, at in zip(members, example.tolist(), strict=True)
    ]


def _patterns(cover: Cover, elements: Ints) -> tuple[Ints, list[Ints]]:
    """Which nodes round their cells have a patch over elements (n,): numbers (n,) of the patterns, and all of them."""
    which, place = cover.patches.of_element.places(elements)
    covered = np.zeros((len(elements), 4 * cover.lattice.reach**2), dtype=bool)
    covered[which, cover.patches.slot[place]] = True
    packed = np.packbits(covered, axis=1)
    _, first, number = np.unique(packed.view(f"V{packed.shape[1]}"), return_index=True, return_inverse=True)
    return number.ravel(), [np.flatnonzero(covered[example]) for example in first.tolist()]


def _parts(lattice: Lattice) -> Ints:
    """Which part of its cell each tile (n,) is: equal numbers for equal parts."""
    tiles, cell = lattice.tiles, lattice.tiles.cell
    of_cell = lattice.cells.size[cell] // tiles.squares.size
    place = (tiles.squares.low - lattice.cells.low[cell]) // tiles.squares.size[:, None]
    return np.asarray((of_cell * QUANTA + place[:, 0]) * QUANTA + place[:, 1])


def all_points(cover: Cover, n: int) -> ElementPoints:
    """Points of all elements, plain ones included, in lattice coordinates; `n` Gauss points per direction."""
    cut = element_points(cover, n)
    points, weights, elements = [cut.points], [cut.weights], [cut.element]
    local, weight = square(n)
    for kind in plain_kinds(cover):
        cell, size = cover.elements.cell[kind.elements], cover.elements.size[kind.elements]
        points.append((cell[:, None] + (kind.low + local * kind.size) * size[:, None, None]).reshape(-1, 2))
        weights.append(np.outer(size**2, weight * kind.size.prod()).ravel())
        elements.append(np.repeat(kind.elements, len(weight)))
    return ElementPoints(np.concatenate(points), np.concatenate(weights), np.concatenate(elements))
