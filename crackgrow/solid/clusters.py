"""Clusters: the elements that are not plain, gathered where the same tips act, with all that their stiffness needs.

Elements near a tip share most of their functions: the sum of their matrices is far smaller than all of them. As long
as nothing that it is integrated from has changed it serves the next configuration too, under other numbers of the
functions. What that is, is hashed: the quadrature points, the functions over each element in the cluster's own
numbering, the tips with their geometry, and the material.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from crackgrow import ragged
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import Tip
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import rim_points
from crackgrow.ragged import Ragged, by_row, starts_of
from crackgrow.solid.elasticity import PlaneElasticity

BLOCK = 4
"""Cells: elements without tip functions make one cluster in each square of this side, of cells of one size."""


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

    def span(self, cluster: int) -> slice:
        """The places of a cluster's elements in `elements.values`."""
        return slice(int(self.elements.start[cluster]), int(self.elements.start[cluster + 1]))

    def local_of(self, cluster: int) -> Ints:
        """The places among its functions of those of a cluster's elements, one element after the other."""
        mine = self.span(cluster)
        return self.local.values[self.local.start[mine.start] : self.local.start[mine.stop]]


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
        tuple(np.split(function, functions.start[1:-1])),
        Ragged(on.start, place - functions.start[owner]),
        Points(inside_start, inside.points, inside.weights * spacing**2, inside.element).of_elements(elements.values),
        Points(rim_start, rim.points, rim.normals * spacing, rim.element).of_elements(elements.values),
    )


def keys(cover: Cover, clusters: Clusters, materials: Sequence[PlaneElasticity]) -> list[bytes]:
    """What the stiffness of each cluster depends on, hashed."""
    elements, enrichment, patches = clusters.elements.values, cover.enrichment, cover.patches
    lattice, body = cover.lattice, cover.elements.body
    moduli = np.array([(material.c11, material.c12, material.c33) for material in materials])
    tips = enrichment.tips.taken(elements)
    _, pair = enrichment.tips.places(elements)
    carriers = enrichment.first.taken(pair)
    _, carrier = enrichment.first.places(pair)
    place = enrichment.place.taken(carrier)
    share = enrichment.share[enrichment.place.places(carrier)[1]]
    over = patches.of_element.taken(elements)
    cell = np.column_stack([cover.elements.cell, cover.elements.size])[elements]
    reference, in_crumb = cover.elements.reference[elements], patches.in_crumb
    geometry = [_geometry(tip) for tip in cover.tips]
    inside, rim = clusters.inside, clusters.rim
    found = []
    for cluster in range(clusters.elements.n):
        mine = clusters.span(cluster)
        pairs, owned = (slice(start[mine.start], start[mine.stop]) for start in (tips.start, over.start))
        carried = slice(carriers.start[pairs.start], carriers.start[pairs.stop])
        at, on = (slice(part.start[mine.start], part.start[mine.stop]) for part in (inside, rim))
        parts: list[NDArray[np.generic]] = [
            np.array([lattice.spacing, lattice.support, *moduli[body[elements[mine.start]]]]),
            np.diff(inside.start[mine.start : mine.stop + 1]),
            np.diff(rim.start[mine.start : mine.stop + 1]),
            cell[mine],
            reference[mine],
            over.counts[mine],
            np.column_stack([patches.nodes, patches.half])[over.values[owned]],
            in_crumb[elements[mine]],
            clusters.local_of(cluster),
            carriers.counts[pairs],
            place.counts[carried],
            place.values[place.start[carried.start] : place.start[carried.stop]],
            share[place.start[carried.start] : place.start[carried.stop]],
            inside.points[at],
            inside.weights[at],
            rim.points[on],
            rim.weights[on],
            *(geometry[tip] for tip in np.unique(tips.values[pairs])),
        ]
        digest = blake2b(digest_size=20)
        for part in parts:
            digest.update(np.int64(part.size).tobytes() + np.ascontiguousarray(part).tobytes())
        found.append(digest.digest())
    return found


def _gathered(cover: Cover) -> Ragged:
    """The elements of all clusters. Their order is that of their places: it is the same in every configuration."""
    cut = np.flatnonzero(~cover.plain)
    size = cover.elements.size[cut]
    block = np.column_stack([cover.elements.cell[cut] // (BLOCK * size[:, None]), size]).tolist()
    ends = cover.enrichment.tips.start.tolist()
    x, y = cover.elements.reference[cut].T
    numbers: dict[tuple[object, ...], int] = {}
    cluster = np.empty(len(cut), dtype=np.int64)
    for place, (element, body) in enumerate(zip(cut.tolist(), cover.elements.body[cut].tolist(), strict=True)):
        tips = cover.enrichment.tips.values[ends[element] : ends[element + 1]].tolist()
        where = tuple(tips) if tips else (None, *block[place])
        cluster[place] = numbers.setdefault((body, where), len(numbers))
    order = np.lexsort((y, x, cluster))
    return by_row(cluster[order], cut[order], len(numbers))


def _geometry(tip: Tip) -> Floats:
    """All that the functions of a tip depend on, as far as they are seen."""
    seen = int(np.searchsorted(tip.radii, tip.carriers.reach)) + 1
    return np.concatenate([tip.point, tip.rotation.ravel(), tip.path[:seen].ravel(), tip.radii[:seen], [tip.fade]])
