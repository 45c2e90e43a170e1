"""Integrals over elements of products of gradients, from which their stiffness is made.

The gradients are corrected so that those of every element satisfy the divergence theorem at its quadrature points: the
linear patch test then passes at round-off whatever the rules, and the matrix stays symmetric (after Chen et al. 2001,
who smooth the gradients over nodal cells; here their deviation from the mean over an element is kept).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crackgrow.approximation.basis import basis_at, values_at
from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
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


def consistent(gradients: Floats, weights: Floats, rim_values: Floats, normals: Floats) -> Floats:
    """Gradients (2, ..., k, n) of k functions at points with weights (..., n), shifted by a constant per function.

    Their integral then equals that of phi n along the rim, given by values (..., k, m) and normals times lengths
    (..., m, 2).
    """
    on_rim = np.moveaxis(rim_values @ normals, -1, 0)
    inside = (gradients @ weights[..., None])[..., 0]
    return np.asarray(gradients + ((on_rim - inside) / weights.sum(axis=-1)[..., None])[..., None])


def products_over(cover: Cover, elements: Ints, n_functions: Ints, inside: Points, rim: Points) -> list[Products]:
    """The products of each of `elements` (e,) with so many functions (e,) and these points.

    Elements with equally many functions and points are taken together.
    """
    n_patches = cover.patches.of_element.counts[elements]
    size = np.column_stack([inside.counts, rim.counts, n_functions, n_patches])
    order = np.lexsort(size.T)
    ends = np.flatnonzero(np.any(np.diff(size[order], axis=0) != 0, axis=1)) + 1
    first = np.append(0, ends) if len(order) else ends
    groups = list(zip(np.diff(np.append(first, len(order))).tolist(), *size[order[first], :2].T.tolist(), strict=True))
    inside, rim = inside.of_elements(order), rim.of_elements(order)
    at_points = basis_at(cover, inside.points, inside.element).of_alike([(e, n) for e, n, _ in groups])
    on_rims = values_at(cover, rim.points, rim.element).of_alike([(e, m) for e, _, m in groups])
    found: list[Products] = []
    point = edge = 0
    for (e, n, m), basis, (values,) in zip(groups, at_points, on_rims, strict=True):
        weights = inside.weights[point : point + e * n].reshape(e, n)
        normals = rim.weights[edge : edge + e * m].reshape(e, m, 2)
        found += map(Products, *products(consistent(basis[1:], weights, values, normals), weights))
        point, edge = point + e * n, edge + e * m
    return [found[place] for place in np.argsort(order).tolist()]
