"""Integrals over elements of products of gradients, from which their stiffness is made.

The gradients are corrected so that those of every element satisfy the divergence theorem at its quadrature points: the
linear patch test then passes at round-off whatever the rules, and the matrix stays symmetric (after Chen et al. 2001,
who smooth the gradients over nodal cells; here their deviation from the mean over an element is kept).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from crackgrow.approximation.basis import Basis, basis_at, values_at
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.ragged import alike_columns, starts_of
from crackgrow.solid.clusters import Points


class Products(NamedTuple):
    """Integrals of products of the gradients of k functions over an element: (k, k), or (e, k, k) over e of them."""

    xx: Floats  # phi_i,x phi_j,x
    xy: Floats  # phi_i,x phi_j,y
    yy: Floats


def products(gradients: Floats, weights: Floats) -> Products:
    """The products from gradients (2, ..., k, n) at points with weights (..., n)."""
    x, y = gradients * np.sqrt(weights)[..., None, :]
    return Products(x @ x.swapaxes(-1, -2), x @ y.swapaxes(-1, -2), y @ y.swapaxes(-1, -2))


def consistent(gradients: Floats, weights: Floats, on_rim: Floats) -> Floats:
    """Gradients (2, ..., k, n) of k functions at points with weights (..., n), shifted by a constant per function.

    Their integral is then that of the functions times the outward normal along the rim, `on_rim` (..., k, 2).
    """
    inside = (gradients @ weights[..., None])[..., 0]
    shift = (np.moveaxis(on_rim, -1, 0) - inside) / weights.sum(axis=-1)[..., None]
    return np.asarray(gradients + shift[..., None])


def products_over(
    cover: Cover, elements: Ints, n_functions: Ints, inside: Points, rim: Points
) -> Iterator[tuple[Ints, Products]]:
    """The products of `elements` (e,) with so many functions (e,) and these points.

    Elements with equally many functions and points come together: which of them, and theirs.
    """
    size = np.stack([n_functions, cover.patches.of_element.counts[elements]])
    start = starts_of(n_functions)
    on_rim = np.empty((start[-1], 2))
    for group, values, normals in _in_groups(partial(values_at, cover), size, rim):
        on_rim[start[group, None] + np.arange(values.shape[2])] = values[0] @ normals
    for group, basis, weights in _in_groups(partial(basis_at, cover), size, inside):
        own = on_rim[start[group, None] + np.arange(basis.shape[2])]
        yield group, products(consistent(basis[1:], weights, own), weights)


def _in_groups(
    basis_of: Callable[[Floats, Ints], Basis], size: Ints, points: Points
) -> Iterator[tuple[Ints, Floats, Floats]]:
    """Groups of elements alike in `size` (..., e) and number of points n: which (g,), basis and weights (g, n, ...).

    The basis is (components, g, k, n).
    """
    groups = alike_columns(np.vstack([points.counts, size]))
    mine = points.of_elements(np.concatenate(groups))
    alike = [(len(group), int(points.counts[group[0]])) for group in groups]
    begin = 0
    for group, basis in zip(groups, basis_of(mine.points, mine.element).of_alike(alike), strict=True):
        e, _, n = basis.shape[1:]
        yield group, basis, mine.weights[begin : begin + e * n].reshape(e, n, *mine.weights.shape[1:])
        begin += e * n
