"""Assembly of the stiffness matrix.

All plain elements of one shape, at the same place of their cell, share the gradients at their quadrature points, hence
one element matrix per material. The others are integrated one by one and summed cluster by cluster; a cluster that the
configuration before had too is not integrated again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.linear import SymmetricMatrix, symmetric
from crackgrow.quadrature.plain_kinds import PlainKind, plain_kinds
from crackgrow.quadrature.rims import rectangle_rim
from crackgrow.quadrature.rules import square
from crackgrow.ragged import starts_of
from crackgrow.solid.clusters import Clusters, Named, clusters_of, keys, named
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.element_products import consistent, products, products_over
from crackgrow.solid.halves import HalfMatrix, half
from crackgrow.solid.summed import EqualElements, Summed, blocks_of

BATCH = 500000
"""Values of functions at points that are held at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Stiffness:
    """A stiffness matrix, and its parts that the next configuration may have in common with this one."""

    matrix: SymmetricMatrix  # (n_dofs, n_dofs) Pa, per metre of thickness
    summed: Summed
    clusters: Mapping[bytes, HalfMatrix]
    plain: Mapping[bytes, Floats]  # (2 k, 2 k) of the kinds of plain elements
    named: Named  # the elements by what their functions depend on
    n_integrated: int  # clusters that were not known before


def stiffness(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> csc_array:
    """Stiffness K (n_dofs, n_dofs) in Pa, per metre of thickness, with `n` Gauss points per direction.

    `materials` are one per body.
    """
    return stiffness_after(cover, materials, n).matrix.tocsc()


def stiffness_after(
    cover: Cover, materials: Sequence[PlaneElasticity], n: int, before: Stiffness | None = None
) -> Stiffness:
    """As `stiffness`, with what is known from the configuration before."""
    known: Mapping[bytes, HalfMatrix] = {} if before is None else before.clusters
    clusters = clusters_of(cover, n)
    names = keys(cover, clusters, materials)
    new = [number for number, name in enumerate(names) if name not in known]
    integrated = {names[number]: part for number, part in _integrated(cover, materials, clusters, new)}
    matrices = {name: known[name] if name in known else integrated[name] for name in names}
    halves = [matrices[name] for name in names]
    blocks = blocks_of(clusters.functions, halves, clusters.group, None if before is None else before.summed.blocks)
    none = csc_array((cover.n_dofs, cover.n_dofs))
    plain: dict[bytes, Floats] = {}
    elements = []
    for kind in plain_kinds(cover):
        name = plain_key(cover, kind, materials[kind.body], n)
        ready = None if before is None else before.plain.get(name)
        plain[name] = _plain(cover, kind, materials[kind.body], n) if ready is None else ready
        elements.append(EqualElements(kind.patches(cover), plain[name], name))
    summed = Summed(tuple(elements), none, blocks)
    matrix = symmetric(summed.tocsc())
    return Stiffness(matrix, summed, matrices, plain, named(cover, clusters, names), len(new))


def element_matrix(material: PlaneElasticity, gradients: Floats, weights: Floats) -> Floats:
    """Integral of B' D B (k, 2, k, 2) from gradients (2, k, n) and weights (n,): function, component, twice."""
    xx, xy, yy = products(gradients, weights)
    return _elastic(material, xx, xy, xy.T, yy).transpose(2, 0, 3, 1)


def _elastic(material: PlaneElasticity, xx: Floats, xy: Floats, yx: Floats, yy: Floats) -> Floats:
    """The matrix (2, 2, ...) [component, component, pair of functions] from their `products` (...)."""
    c11, c12, c33 = material.c11, material.c12, material.c33
    return np.array([[c11 * xx + c33 * yy, c12 * xy + c33 * yx], [c12 * yx + c33 * xy, c11 * yy + c33 * xx]])


def plain_key(cover: Cover, kind: PlainKind, material: PlaneElasticity, n: int) -> bytes:
    """All that the matrix of a kind of plain elements depends on."""
    moduli = (material.c11, material.c12, material.c33)
    return np.array([cover.lattice.support, *moduli, n, *kind.low, *kind.size, *kind.slots]).tobytes()


def _plain(cover: Cover, kind: PlainKind, material: PlaneElasticity, n: int) -> Floats:
    """The element matrix (2 k, 2 k) of a kind of plain elements, function by function."""
    share, weights = square(n)
    area = weights * kind.size.prod()
    _, gradients = kind.functions(cover.lattice, share)
    rim, normals = rectangle_rim(kind.size)
    rim_values, _ = kind.functions(cover.lattice, rim)
    matrix = element_matrix(material, consistent(gradients, area, rim_values @ normals), area)
    return matrix.reshape(2 * len(matrix), -1)


def _integrated(
    cover: Cover, materials: Sequence[PlaneElasticity], clusters: Clusters, chosen: Sequence[int]
) -> Iterator[tuple[int, HalfMatrix]]:
    """The matrices of the clusters `chosen`; they share the evaluation of the basis."""
    for batch in _batches(clusters, chosen):
        owner, at = clusters.elements.places(np.array(batch))
        n = np.array([len(clusters.functions[number]) for number in batch])
        coupled, sums = _summed(cover, clusters, at, owner, n)
        start = starts_of(n * n)
        for place, (number, k) in enumerate(zip(batch, n.tolist(), strict=True)):
            own = slice(start[place], start[place + 1])
            pairs = np.flatnonzero(np.triu(coupled[own].reshape(k, k)))
            xx, xy, yy = sums[:, own]
            material = materials[cover.elements.body[clusters.elements.values[clusters.span(number).start]]]
            mirrored = xy[pairs % k * k + pairs // k]
            yield number, half(k, pairs, _elastic(material, xx[pairs], xy[pairs], mirrored, yy[pairs]))


def _summed(cover: Cover, clusters: Clusters, at: Ints, owner: Ints, n: Ints) -> tuple[Bools, Floats]:
    """The `products` (3, q) of clusters with n (c,) functions, and which (q,) there are: tables (n, n) one by one.

    The elements are those at the places `at` (m,) of all clusters, of the clusters `owner` (m,).
    """
    start, own = starts_of(n * n), clusters.local.taken(at)
    inside, rim = clusters.inside.of_elements(at), clusters.rim.of_elements(at)
    places, terms = [], []
    for group, found in products_over(cover, clusters.elements.values[at], own.counts, inside, rim):
        local, mine = own.values[own.start[group, None] + np.arange(found.xx.shape[1])], owner[group, None]
        row = start[mine] + n[mine] * local
        places.append((row[:, :, None] + local[:, None]).ravel())
        terms.append([term.ravel() for term in found])
    place = np.concatenate(places)
    coupled = np.zeros(start[-1], dtype=bool)
    coupled[place] = True
    sums = [np.bincount(place, np.concatenate(parts), start[-1]) for parts in zip(*terms, strict=True)]
    return coupled, np.stack(sums).astype(np.float64, copy=False)


def _batches(clusters: Clusters, chosen: Sequence[int]) -> list[list[int]]:
    """The clusters `chosen`, in batches."""
    numbers = np.array(chosen, dtype=np.int64)
    if len(numbers) == 0:
        return []
    n_values = starts_of(np.diff(clusters.inside.start) * clusters.local.counts)[clusters.elements.start]
    batch = np.cumsum(np.diff(n_values)[numbers]) // BATCH
    return [part.tolist() for part in np.split(numbers, np.flatnonzero(np.diff(batch)) + 1)]
