"""Clusters: the elements that are not plain, gathered where the same tips act, with all that their stiffness needs.

Elements near a tip share most of their functions: the sum of their matrices is far smaller than all of them. As long
as nothing that it is integrated from has changed it serves the next configuration too, under other numbers of the
functions. What that is, is hashed: the quadrature points, the functions over each element in the cluster's own
numbering, the tips with their geometry, and the material.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crackgrow import ragged
from crackgrow.arrays import KEY, Floats, Ints, key_of
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import Tip
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import rim_points
from crackgrow.ragged import Ragged, by_row, starts_of
from crackgrow.solid.elasticity import PlaneElasticity

BLOCK = 4
"""Cells: elements without tip functions make one cluster in each square of this side, of cells of one size."""

GROUP = 12
"""Cells: clusters are summed in groups, those that begin in one square of this side, of cells of one size."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Quadrature points of all clusters, cluster by cluster and element by element."""

    start: Ints  # (elements of clusters + 1,) where those of each element begin
    points: Floats  # (n, 2)
    weights: Floats  # (n, ...) inside: weights, squared spacings; on the rim: outward normal times length (n, 2)
    element: Ints  # (n,)

    @property
    def counts(self) -> Ints:
        """Number of points of each element."""
        return np.diff(self.start)

    def of_elements(self, places: Ints) -> Points:
        """Those of some elements (m,), in their order."""
        _, at = ragged.places(self.start, places)
        start = starts_of(np.diff(self.start)[places])
        return Points(start, self.points[at], self.weights[at], self.element[at])


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """All clusters.

    Cluster c has the elements `elements.of(c)` and `functions[c]`, of which those at the places `local.of(e)` act on
    the element at place e of `elements.values`.
    """

    elements: Ragged  # clusters -> their elements, m in all
    functions: tuple[Ints, ...]  # (clusters,) of (k,), ascending
    local: Ragged  # (m) -> places of an element's functions among those of its cluster
    inside: Points
    rim: Points
    group: Ints  # (clusters,)

    def span(self, cluster: int) -> slice:
        """The places of a cluster's elements in `elements.values`."""
        return slice(int(self.elements.start[cluster]), int(self.elements.start[cluster + 1]))


@dataclass(frozen=True, slots=True, eq=False)
class Named:
    """Elements by what their functions depend on: the key of their cluster, and their place in it."""

    cluster: Ints  # (elements,) -1 for plain ones
    place: Ints  # (elements,)
    names: NDArray[np.uint8]  # (clusters + 1, bytes) keys; the last one serves the number -1


def named(cover: Cover, clusters: Clusters, names: Sequence[bytes]) -> Named:
    """The elements of a cover by its `clusters` with these `keys`."""
    cluster, place = np.full((2, cover.elements.n), -1)
    own = clusters.elements
    cluster[own.values], place[own.values] = own.row, np.arange(len(own.values)) - own.start[own.row]
    keys_and_none = np.frombuffer(b"".join([*names, bytes(KEY)]), dtype=np.uint8).reshape(-1, KEY)
    return Named(cluster, place, keys_and_none)


def clusters_of(cover: Cover, n: int) -> Clusters:
    """The clusters of a cover and their quadrature points, `n` Gauss points per direction."""
    elements = _gathered(cover)
    on = cover.functions_on(elements.values)
    owner = np.repeat(np.arange(elements.n), np.diff(on.start[elements.start]))
    pairs, place = np.unique(owner * cover.n_functions + on.values, return_inverse=True)
    cluster, function = np.divmod(pairs, max(cover.n_functions, 1))
    functions = by_row(cluster, function, elements.n)
    inside, rim, spacing = element_points(cover, n), rim_points(cover), cover.lattice.spacing
    inside_start, rim_start = (np.searchsorted(some.element, np.arange(cover.elements.n + 1)) for some in (inside, rim))
    return Clusters(
        elements,
        tuple(np.split(function, functions.start[1:-1])[: elements.n]),
        Ragged(on.start, place - functions.start[owner]),
        Points(inside_start, inside.points, inside.weights * spacing**2, inside.element).of_elements(elements.values),
        Points(rim_start, rim.points, rim.normals * spacing, rim.element).of_elements(elements.values),
        _groups(cover, elements),
    )


def _groups(cover: Cover, elements: Ragged) -> Ints:
    """The groups (clusters,) of clusters with these `elements`."""
    first = elements.values[elements.start[:-1]]
    size = cover.elements.size[first]
    square = np.column_stack([cover.elements.cell[first] // (GROUP * size[:, None]), size])
    return np.unique(square, axis=0, return_inverse=True)[1].reshape(-1)


def keys(cover: Cover, clusters: Clusters, materials: Sequence[PlaneElasticity]) -> list[bytes]:
    """What the stiffness of each cluster depends on, hashed."""
    elements, lattice = clusters.elements.values, cover.lattice
    moduli = np.array([(material.c11, material.c12, material.c33) for material in materials])
    general = np.full((clusters.elements.n, 2), (lattice.spacing, lattice.support))
    body = cover.elements.body[elements[clusters.elements.start[:-1]]]
    tables = [(np.arange(clusters.elements.n + 1), np.column_stack([general, moduli[body]]))]
    tables += [(start[clusters.elements.start], table) for start, table in _contents(cover, clusters)]
    rows = [(start.tolist(), np.ascontiguousarray(table)) for start, table in tables]
    geometry = [_geometry(tip) for tip in cover.tips]
    found = []
    for cluster in range(clusters.elements.n):
        parts = [table[start[cluster] : start[cluster + 1]] for start, table in rows]
        acting = cover.enrichment.tips.of(elements[clusters.elements.start[cluster]])  # on all of its elements
        parts += [geometry[tip] for tip in acting.tolist()]
        found.append(key_of(parts))
    return found


def _contents(cover: Cover, clusters: Clusters) -> Iterator[tuple[Ints, NDArray[np.generic]]]:
    """Tables of what the elements of clusters are integrated from, and which rows belong to each: starts (m + 1,)."""
    elements, enrichment, patches = clusters.elements.values, cover.enrichment, cover.patches
    tips, over = enrichment.tips.taken(elements), patches.of_element.taken(elements)
    _, pair = enrichment.tips.places(elements)
    carriers = enrichment.first.taken(pair)
    _, carrier = enrichment.first.places(pair)
    place = enrichment.place.taken(carrier)
    share = enrichment.share[enrichment.place.places(carrier)[1]]
    inside, rim, own = clusters.inside, clusters.rim, cover.elements
    counts = np.column_stack([inside.counts, rim.counts, over.counts, tips.counts, patches.in_crumb[elements]])
    places = np.column_stack([own.cell, own.size, own.reference])[elements]
    yield np.arange(len(elements) + 1), counts
    yield np.arange(len(elements) + 1), places
    yield over.start, np.column_stack([patches.nodes, patches.half])[over.values]
    yield clusters.local.start, clusters.local.values
    yield tips.start, carriers.counts
    yield carriers.start[tips.start], place.counts
    yield place.start[carriers.start[tips.start]], np.column_stack([place.values, share])
    yield inside.start, np.column_stack([inside.points, inside.weights])
    yield rim.start, np.column_stack([rim.points, rim.weights])


def _gathered(cover: Cover) -> Ragged:
    """The elements of all clusters. Their order is that of their places: it is the same in every configuration."""
    cut = np.flatnonzero(~cover.plain)
    size, tips = cover.elements.size[cut], cover.enrichment.tips
    x, y = cover.elements.reference[cut].T
    together = np.full(len(cut), -1)  # those on which the same tips act
    numbers: dict[tuple[int, ...], int] = {}
    for place in np.flatnonzero(tips.counts[cut]).tolist():
        together[place] = numbers.setdefault(tuple(tips.of(cut[place]).tolist()), len(numbers))
    block = np.column_stack([cover.elements.cell[cut] // (BLOCK * size[:, None]), size])
    block[together >= 0] = 0.0
    alike = np.column_stack([cover.elements.body[cut], together, block])
    order = np.lexsort((y, x, *alike.T))
    new = np.any(np.diff(alike[order], axis=0) != 0.0, axis=1)
    cluster = np.append(0, np.cumsum(new))[: len(cut)]
    return by_row(cluster, cut[order], int(cluster.max(initial=-1)) + 1)


def _geometry(tip: Tip) -> Floats:
    """All that the functions of a tip depend on, as far as they are seen."""
    seen = int(np.searchsorted(tip.radii, tip.carriers.reach)) + 1
    return np.concatenate([tip.point, tip.rotation.ravel(), tip.path[:seen].ravel(), tip.radii[:seen], [tip.fade]])
