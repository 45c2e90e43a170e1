"""Plain elements, rectangles without singular patches, by their kinds.

Those alike in shape, in rim, in window and the patches there, and in place in their cell have the same functions at
the same points, hence the same element matrix: it is integrated once, in the unit cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.approximation.basis import functions_in_window
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.lattice import Lattice
from crackgrow.ragged import Ragged, spans, starts_of


def rectangles(cover: Cover, elements: Ints) -> tuple[Floats, Floats]:
    """Lower left corners (n, 2) and sizes (n, 2) of plain elements (n,)."""
    ring = ring_places(cover, elements)
    corners, which = cover.elements.vertices[cover.elements.ring_start[ring.values]], ring.start[:-1]
    low, high = np.minimum.reduceat(corners, which, axis=0), np.maximum.reduceat(corners, which, axis=0)
    return low, high - low


def ring_places(cover: Cover, elements: Ints) -> Ragged:
    """The edges round elements (n,): places among all ring edges."""
    start = np.searchsorted(cover.elements.ring_element, np.arange(cover.elements.n + 1))
    counts = np.diff(start)[elements]
    return Ragged(starts_of(counts), spans(start[elements], counts))


@dataclass(frozen=True, slots=True, eq=False)
class PlainKind:
    """Plain elements of one kind, measured in sides of their cells."""

    elements: Ints  # (n,)
    body: int
    low: Floats  # (2,) lower left corner
    size: Floats  # (2,)
    rim: Floats  # (e, 2) vertices round it, counter-clockwise
    window: int
    slots: Ints  # (k,) which nodes of the window have a patch here

    def patches(self, cover: Cover) -> Ints:
        """Their physical patches (n, k)."""
        return cover.patches.of_element.taken(self.elements).values.reshape(-1, len(self.slots))

    def functions(self, lattice: Lattice, local: Floats) -> tuple[Floats, Floats]:
        """Functions (k, m) and their gradients (2, k, m) per side of the cell at points `local` (m, 2) of the cell."""
        found = functions_in_window(lattice, np.full(len(local), self.window), local)
        return found[0, self.slots], found[1:, self.slots]

    def at(self, share: Floats) -> Floats:
        """Points in the cell (m, 2) by their `share` (m, 2) of the size."""
        return np.asarray(self.low + share * self.size)


def plain_kinds(cover: Cover) -> list[PlainKind]:
    """All kinds of plain elements."""
    elements = np.flatnonzero(cover.plain)
    if not len(elements):
        return []
    of_element, every = cover.patches.of_element, cover.elements
    ring = ring_places(cover, elements)
    cell, size = every.cell[elements], every.size[elements]
    rim = (every.vertices[every.ring_start[ring.values]] - cell[ring.row]) / size[ring.row, None]
    _, place = of_element.places(elements)
    slots, n_slots = cover.patches.slot[place], of_element.counts[elements]
    window, body = cover.lattice.windows.of_tile[every.tile[elements]], every.body[elements]
    numbers: dict[tuple[object, ...], int] = {}
    number = np.empty(len(elements), dtype=np.int64)
    slot_start, raw_slots, raw_rim = starts_of(n_slots), slots.tobytes(), rim.tobytes()
    heads = zip(body.tolist(), window.tolist(), slot_start.tolist(), ring.start.tolist(), strict=False)
    ends = zip(slot_start[1:].tolist(), ring.start[1:].tolist(), strict=True)
    for k, ((of_body, of_window, i, m), (j, n)) in enumerate(zip(heads, ends, strict=False)):
        key = (of_body, of_window, raw_slots[8 * i : 8 * j], raw_rim[16 * m : 16 * n])
        number[k] = numbers.setdefault(key, len(numbers))
    first = np.unique(number, return_index=True)[1]
    members = np.split(elements[np.argsort(number, kind="stable")], np.cumsum(np.bincount(number))[:-1])
    found = []
    for mine, at in zip(members, first.tolist(), strict=True):
        round_it = rim[ring.start[at] : ring.start[at + 1]]
        low, high = round_it.min(axis=0), round_it.max(axis=0)
        nodes = slots[slot_start[at] : slot_start[at + 1]]
        found.append(PlainKind(mine, int(body[at]), low, high - low, round_it, int(window[at]), nodes))
    return found
