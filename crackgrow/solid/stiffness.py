"""The stiffness matrix: integrals of B' D B over all elements, summed.

The gradients are corrected so that those of every element satisfy the divergence theorem at its quadrature points: the
linear patch test then passes at round-off whatever the rules, and the matrix stays symmetric (after Chen et al. 2001,
who smooth the gradients over nodal cells; here their deviation from the mean over an element is kept).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crackgrow.approximation.basis import functions_at, gathered, workspace
from crackgrow.arrays import Floats, Ints
from crackgrow.compiled import kernel, syrk
from crackgrow.cover.cover import Cover
from crackgrow.linear import SymmetricMatrix
from crackgrow.quadrature.elements import element_points
from crackgrow.quadrature.rims import rim_points
from crackgrow.solid.elasticity import PlaneElasticity


def stiffness(cover: Cover, materials: Sequence[PlaneElasticity], n: int) -> SymmetricMatrix:
    """The stiffness (n_dofs, n_dofs) Pa, per metre of thickness, with `n` Gauss points per direction."""
    spacing, every = cover.lattice.spacing, np.arange(cover.elements.n + 1)
    inside, rim, on = element_points(cover, n), rim_points(cover), cover.functions
    moduli = np.array([m.matrix for m in materials])[cover.elements.body]
    within = (np.searchsorted(inside.element, every), inside.points, inside.weights * spacing**2)
    around = (np.searchsorted(rim.element, every), rim.points, rim.normals * spacing)
    start, column, place = _pattern(on.start, on.values, cover.n_functions)
    block = np.zeros((len(column), 2, 2))
    _integrate(cover.arrays, on.start, within, around, moduli, 1.0 / spacing, place, block)
    return SymmetricMatrix(start, column, block)


@kernel
def _pattern(at: Ints, function: Ints, n: int) -> tuple[Ints, Ints, NDArray[np.int32]]:
    """Give the lower triangle of a matrix of n functions: starts (n + 1,) of its rows, and columns, ascending in each.

    Functions are coupled that act on one element: element e has those of `function` from at[e] on, ascending. The third
    are the places of all couplings of an element, then of the next: row by row of its own lower triangle.
    """
    held_start, held = np.zeros(n + 2, np.int64), np.empty(len(function), np.int64)  # places of functions on elements
    for f in function:
        held_start[f + 2] += 1
    held_start = np.cumsum(held_start)
    element, first = np.empty(len(function), np.int64), np.zeros(len(at), np.int64)
    for e in range(len(at) - 1):
        first[e + 1] = first[e] + (at[e + 1] - at[e]) * (at[e + 1] - at[e] + 1) // 2
        for own in range(at[e], at[e + 1]):
            element[own], held[held_start[function[own] + 1]] = e, own
            held_start[function[own] + 1] += 1
    # room for some columns a row; more is made where it is short
    start, column, met = np.zeros(n + 1, np.int64), np.empty(32 * n, np.int64), np.full(n, -1)
    place = np.empty(first[-1], np.int32)
    for row in range(n):
        end = start[row]
        if end + row + 1 > len(column):
            column = np.append(column, np.empty(len(column) + n, np.int64))
        for own in held[held_start[row] : held_start[row + 1]]:
            for other in function[at[element[own]] : own + 1]:
                if met[other] < start[row]:
                    met[other], column[end] = start[row], other
                    end += 1
        column[start[row] : end].sort()
        for q in range(start[row], end):
            met[column[q]] = q
        for own in held[held_start[row] : held_start[row + 1]]:
            e, i = element[own], own - at[element[own]]
            for j in range(i + 1):
                place[first[e] + i * (i + 1) // 2 + j] = met[function[at[e] + j]]
        start[row + 1] = end
    return start, column[: start[n]].copy(), place


@kernel
def _integrate(
    arrays: Any,
    at: Ints,
    inside: tuple[Ints, Floats, Floats],
    rim: tuple[Ints, Floats, Floats],
    moduli: Floats,
    scale: float,
    place: NDArray[np.int32],
    block: Floats,
) -> None:
    """Add the integrals over elements to the blocks of a matrix.

    at: starts of the functions of elements; inside: starts, points, weights (m^2); rim: starts, points, outward normals
    times length (m); moduli: (elements, 3, 3) Pa; scale: lattice spacings in a metre; place: of couplings, see
    `_pattern`, among the blocks (q, 2, 2) of the lower triangle
    """
    (inside_at, points, weights), (rim_at, places, normals), coupling = inside, rim, 0
    work, most_points = workspace(arrays), int(np.max(np.diff(inside_at)))
    most = work[4].shape[1]
    shift, g, s = np.empty(2 * most), np.empty(most_points * 2 * most), np.empty(4 * most * most)
    (nodes, half, patch_at, patch), (by, per, _, _, f) = arrays[:4], work
    for e in range(len(at) - 1):
        k, m = gathered(e, by, per, nodes, half, patch_at, patch), at[e + 1] - at[e]
        n, area, shift[: 2 * m] = inside_at[e + 1] - inside_at[e], 0.0, 0.0
        for q in range(rim_at[e], rim_at[e + 1]):
            functions_at(places[q, 0], places[q, 1], e, False, k, arrays, work)
            for i in range(m):
                shift[i] += normals[q, 0] * f[0, i]
                shift[m + i] += normals[q, 1] * f[0, i]
        gradients = g[: n * 2 * m].reshape(n, 2 * m)
        for q in range(n):
            p = inside_at[e] + q
            functions_at(points[p, 0], points[p, 1], e, True, k, arrays, work)
            area += weights[p]
            for i in range(m):
                gradients[q, i], gradients[q, m + i] = scale * f[1, i], scale * f[2, i]
                shift[i] -= weights[p] * scale * f[1, i]
                shift[m + i] -= weights[p] * scale * f[2, i]
        for q in range(n):  # shifted by a constant per function: the integral is that of the rim
            root = math.sqrt(weights[inside_at[e] + q])
            for i in range(2 * m):
                gradients[q, i] = root * (gradients[q, i] + shift[i] / area)
        products = s[: 4 * m * m].reshape(2 * m, 2 * m)  # the lower triangle: of derivatives by x, then by y
        syrk(gradients, products)
        c = moduli[e]
        for i in range(m):
            for j in range(i + 1):
                row, coupling = place[coupling], coupling + 1
                xx, xy, yx, yy = products[i, j], products[m + j, i], products[m + i, j], products[m + i, m + j]
                block[row, 0, 0] += c[0, 0] * xx + c[0, 2] * (xy + yx) + c[2, 2] * yy
                block[row, 0, 1] += c[0, 1] * xy + c[0, 2] * xx + c[1, 2] * yy + c[2, 2] * yx
                block[row, 1, 0] += c[0, 1] * yx + c[0, 2] * xx + c[1, 2] * yy + c[2, 2] * xy
                block[row, 1, 1] += c[1, 1] * yy + c[1, 2] * (xy + yx) + c[2, 2] * xx
