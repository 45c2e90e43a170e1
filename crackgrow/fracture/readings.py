"""What is read off the displacement at a place: rows of a matrix, kept while nothing changes that they depend on.

Stress averaged round a tip, and the integrals of K, are linear in the unknowns near by. Their rows follow from the
elements near by with the functions on them, and from what the place itself adds: all of that is hashed. A reading of
the configuration before with the same hash is this one's, under other numbers of the functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints, key_of
from crackgrow.cover.cover import Cover
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.ragged import Ragged, from_lists, numbered
from crackgrow.solid.clusters import Named


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """Where something is read off, in lattice coordinates."""

    low: Floats  # (2,) corners of the box of all its points
    high: Floats  # (2,)
    own: bytes  # all that it adds to the elements there


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """What is read off at a place."""

    rows: Floats  # (q, k) of a component of the displacement, by the coefficients (k,) of some functions
    more: tuple[NDArray[Any], ...]  # that goes with it

    def of(self, u: Floats) -> Floats:
        """What is read off (q, 2), by component, of the coefficients (k, 2) of its functions."""
        return np.asarray(self.rows @ u)


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """A reading under the numbers that its functions have among those near by."""

    used: Ints  # (k,)
    reading: Reading


Made = tuple[Ints, Reading]
"""Functions (k,) of a cover, ascending, and a reading by their coefficients."""


class Readings:
    """The readings of a cover, some of which are those of the cover before."""

    def __init__(self, cover: Cover, named: Named | None = None, before: Readings | None = None) -> None:
        """`named` are the elements by what their functions depend on; None: nothing is taken over."""
        self.cover = cover
        self.n_made = 0
        self._named = named
        self._known: dict[bytes, _Known] = {}
        self._before: Mapping[bytes, _Known] = {} if before is None else before._known

    def at(self, places: Sequence[Place], make: Callable[[list[int]], Iterator[Made]]) -> list[Made]:
        """The reading of each of some places; `make` makes those of the places with some numbers."""
        if self._named is None:
            return list(make(list(range(len(places)))))
        near = list(self._near(self._named, places))
        new = [number for number, (key, _) in enumerate(near) if key not in self._known and key not in self._before]
        for number, (functions, reading) in zip(new, make(new), strict=True):
            key, all_near = near[number]
            self._known[key] = _Known(np.searchsorted(all_near, functions), reading)
        self.n_made += len(new)
        found = []
        for key, all_near in near:
            known = self._known[key] = self._known.get(key) or self._before[key]
            found.append((all_near[known.used], known.reading))
        return found

    def _near(self, named: Named, places: Sequence[Place]) -> Iterator[tuple[bytes, Ints]]:
        """Of each place the hash of all that a reading there depends on, and the functions (n,) near by, ascending."""
        cover, elements = self.cover, self._elements_near(places)
        own, patches = cover.elements, cover.patches
        some = elements.values
        names = np.ascontiguousarray(named.names[named.cluster[some]])
        where = np.column_stack(
            [named.place[some], own.body[some], own.cell[some], own.size[some], own.reference[some]]
        )
        on = cover.functions_on(some)
        nodes = np.column_stack([patches.nodes, patches.weight_half])
        general, n = np.array([cover.lattice.spacing, cover.lattice.support]), cover.n_functions
        for number, place in enumerate(places):
            first, last = elements.start[number : number + 2]
            counts = on.start[first : last + 1] - on.start[first]
            functions, local = numbered(on.values[on.start[first] : on.start[last]], n)
            on_nodes = nodes[functions[functions < len(nodes)]]
            added = np.frombuffer(place.own, dtype=np.uint8)
            yield key_of((general, names[first:last], where[first:last], counts, local, on_nodes, added)), functions

    def _elements_near(self, places: Sequence[Place]) -> Ragged:
        """The elements that touch the box of each place, ascending."""
        elements, lattice = self.cover.elements, self.cover.lattice
        tile = elements.tile[: elements.n_whole]
        corner, size = lattice.tile_low[tile], lattice.tile_size[tile, None]
        found = []
        for place in places:
            low, high = place.low - SAME_PLACE, place.high + SAME_PLACE
            whole = np.flatnonzero(((corner <= high) & (corner + size >= low)).all(axis=1))
            cut = np.sort(elements.tree.query(shapely.box(*low, *high)))
            found.append(np.append(whole, cut + elements.n_whole))
        return from_lists(found)
