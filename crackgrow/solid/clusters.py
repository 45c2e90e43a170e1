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

from crackgrow.approximation.basis import functions_on
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.enrichment import entries, list_starts
from crackgrow.cover.tips import Tip, reach_of_tips
from crackgrow.quadrature.elements import element_points, plain_elements
from crackgrow.quadrature.rims import rim_points
from crackgrow.solid.elasticity import PlaneElasticity

BLOCK = 4
"""Cells: elements without tip functions make one cluster in each square of this side."""


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Quadrature points of all clusters, cluster by cluster and element by element."""

    start: Ints  # (elements of clusters + 1,) where those of each element begin
    points: Floats  # (n, 2)
    weights: Floats  # (n, ...) inside: weights, squared spacings; on the rim: outward normal times length (n, 2)
    element: Ints  # (n,)


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """All clusters.

    Cluster c has `elements[start[c] : start[c + 1]]` and `functions[c]`, of which those at the places
    `local[local_start[e] : local_start[e + 1]]` act on the element at place e of `elements`.
    """

    start: Ints  # (clusters + 1,)
    elements: Ints  # (m,)
    functions: tuple[Ints, ...]  # (clusters,) of (k,), ascending
    local_start: Ints  # (m + 1,)
    local: Ints
    inside: Points
    rim: Points

    def span(self, cluster: int) -> slice:
        """The places of a cluster's elements in `elements`."""
        return slice(int(self.start[cluster]), int(self.start[cluster + 1]))

    def local_of(self, cluster: int) -> Ints:
        """The places among its functions of those of a cluster's elements, one element after the other."""
        return self.local[self.local_start[self.start[cluster]] : self.local_start[self.start[cluster + 1]]]


def clusters_of(cover: Cover, n: int) -> Clusters:
    """The clusters of a cover and their quadrature points, `n` Gauss points per direction."""
    elements, start = _gathered(cover)
    local_start, ids = functions_on(cover, elements)
    owner = np.repeat(np.arange(len(start) - 1), np.diff(local_start[start]))
    pairs, place = np.unique(owner * cover.n_functions + ids, return_inverse=True)
    cluster, function = np.divmod(pairs, max(cover.n_functions, 1))
    first = list_starts(cluster, len(start) - 1)
    inside, rim = element_points(cover, n), rim_points(cover)
    spacing = cover.lattice.spacing
    return Clusters(
        start,
        elements,
        tuple(np.split(function, first[1:-1])),
        local_start,
        place - first[owner],
        _in_order(elements, cover.elements.n, inside.points, inside.weights * spacing**2, inside.element),
        _in_order(elements, cover.elements.n, rim.points, rim.normals * spacing, rim.element),
    )


def keys(cover: Cover, clusters: Clusters, materials: Sequence[PlaneElasticity]) -> list[bytes]:
    """What the stiffness of each cluster depends on, hashed."""
    elements, acting = clusters.elements, cover.enrichment.tips
    lattice, body = cover.lattice, cover.elements.body
    moduli = np.array([(material.c11, material.c12, material.c33) for material in materials])
    _, pair = acting.of(elements)
    pair_start = np.append(0, np.cumsum(np.diff(acting.start)[elements]))
    _, entry = entries(cover.enrichment.start, pair)
    patch_start = np.append(0, np.cumsum(cover.enrichment.n_patches[elements]))
    n_patches, slot = np.diff(cover.enrichment.start)[pair], cover.enrichment.slot[entry]
    covers, tile, reference = cover.functions[elements] >= 0, cover.elements.tile[elements], cover.elements.reference
    reference = reference[elements]
    crumb = cover.crumbs.of_element[elements]
    geometry = [_geometry(tip, reach_of_tips(lattice.support)) for tip in cover.tips]
    inside, rim = clusters.inside, clusters.rim
    found = []
    for cluster in range(len(clusters.start) - 1):
        mine = clusters.span(cluster)
        pairs, patches = (slice(start[mine.start], start[mine.stop]) for start in (pair_start, patch_start))
        at, on = (slice(part.start[mine.start], part.start[mine.stop]) for part in (inside, rim))
        parts: list[NDArray[np.generic]] = [
            np.array([lattice.spacing, lattice.support, *moduli[body[elements[mine.start]]]]),
            np.diff(inside.start[mine.start : mine.stop + 1]),
            np.diff(rim.start[mine.start : mine.stop + 1]),
            tile[mine],
            covers[mine],
            reference[mine],
            clusters.local_of(cluster),
            n_patches[pairs],
            slot[patches],
            crumb[mine] >= 0,
            cover.crumbs.corners[crumb[mine][crumb[mine] >= 0]],
            inside.points[at],
            inside.weights[at],
            rim.points[on],
            rim.weights[on],
            *(geometry[tip] for tip in np.unique(acting.tip[pair[pairs]])),
        ]
        digest = blake2b(digest_size=20)
        for part in parts:
            digest.update(np.int64(part.size).tobytes() + np.ascontiguousarray(part).tobytes())
        found.append(digest.digest())
    return found


def _gathered(cover: Cover) -> tuple[Ints, Ints]:
    """The elements of all clusters (m,), and where those of each cluster begin (clusters + 1,).

    Their order is that of their places: it is the same in every configuration.
    """
    cut = np.flatnonzero(~plain_elements(cover))
    acting, parts = cover.enrichment.tips, len(cover.lattice.breaks) - 1
    ends = acting.start.tolist()
    block = (cover.elements.tile[cut] // (BLOCK * parts)).tolist()
    x, y = cover.elements.reference[cut].T
    numbers: dict[tuple[object, ...], int] = {}
    cluster = np.empty(len(cut), dtype=np.int64)
    for place, (element, body) in enumerate(zip(cut.tolist(), cover.elements.body[cut].tolist(), strict=True)):
        tips = acting.tip[ends[element] : ends[element + 1]].tolist()
        where = tuple(tips) if tips else (None, *block[place])
        cluster[place] = numbers.setdefault((body, where), len(numbers))
    order = np.lexsort((y, x, cluster))
    return cut[order], list_starts(cluster[order], len(numbers))


def _in_order(elements: Ints, n_elements: int, points: Floats, weights: Floats, owner: Ints) -> Points:
    """Points sorted by their `owner`, in the order of `elements`."""
    start = list_starts(owner, n_elements)
    _, at = entries(start, elements)
    return Points(np.append(0, np.cumsum(np.diff(start)[elements])), points[at], weights[at], owner[at])


def _geometry(tip: Tip, reach: float) -> Floats:
    """All that the functions of a tip depend on, as far as they are seen."""
    seen = int(np.searchsorted(tip.radii, reach)) + 1
    return np.concatenate([tip.point, tip.rotation.ravel(), tip.path[:seen].ravel(), tip.radii[:seen], [tip.fade]])
