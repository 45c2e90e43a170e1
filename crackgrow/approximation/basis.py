"""The basis at points of elements, and what is made of it: sparse rows of values, and fields.

    u(x) = sum_i phi_i(x) u_i + sum_tk F_tk(x) sum_c X_c(x) a_ctk,    paper eqs. (2), (3),

over the physical patches i, and over the tips t that act on the element with their four functions F_tk. What carries
these, X_c = sum_i chi_i phi_i, is the function of a singular patch, as in the paper, or a sum over the patches round
the tip.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions
from crackgrow.arrays import Floats, Ints
from crackgrow.compiled import kernel
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS

assert N_TIP_FUNCTIONS == 4  # the kernels count by it


def values_at(cover: Cover, points: Floats, elements: Ints) -> csr_array:
    """Values (n, n_functions) at points (n, 2), lattice coordinates, each inside or on the rim of its element (n,)."""
    on = cover.functions.taken(elements)
    values = np.empty(len(on.values))
    _put_values(cover.arrays, points, elements, on.start, values)
    return csr_array((values, on.values, on.start), shape=(on.n, cover.n_functions))


def fields_at(cover: Cover, points: Floats, elements: Ints, u: Floats, *, derivatives: bool = True) -> Floats:
    """The displacement, then its derivatives by x and by y (3, n, 2) of `u` (n_dofs,) m, at points as of `values_at`.

    Without derivatives it is (1, n, 2).
    """
    on, found = cover.functions, np.empty((3 if derivatives else 1, len(points), 2))
    _put_fields(cover.arrays, cover.lattice.spacing, points, elements, on.start, on.values, u, found)
    return found


def of_component(rows: csr_array, component: int) -> csr_array:
    """Rows (m, n_dofs) that give of one displacement component what `rows` (m, n_functions) give of a scalar field."""
    m, n = rows.shape
    return csr_array((rows.data, 2 * rows.indices + component, rows.indptr), shape=(m, 2 * n))


@kernel
def workspace(arrays: Any) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """What `gathered` and `functions_at` work in: room for the largest number of functions on an element."""
    patch_at, pair_at, carrier_at, most = arrays[2], arrays[4], arrays[7], 1
    for e in range(len(patch_at) - 1):
        carriers = carrier_at[pair_at[e + 1]] - carrier_at[pair_at[e]]
        most = max(most, patch_at[e + 1] - patch_at[e] + 4 * carriers)
    return np.empty((2, most)), np.empty(most), np.empty((5, most)), np.empty((3, 4)), np.empty((3, most))


@kernel
def gathered(
    element: int, at: Floats, per: Floats, nodes: Floats, per_half: Floats, patch_at: Ints, patch: Ints
) -> int:
    """Put the k nodes of the patches of an element into `at` (2, k), their inverse half widths into `per`; give k."""
    k = 0
    for place in range(patch_at[element], patch_at[element + 1]):
        p = patch[place]
        at[0, k], at[1, k], per[k] = nodes[p, 0], nodes[p, 1], per_half[p]
        k += 1
    return k


@kernel
def functions_at(x: float, y: float, element: int, derivatives: bool, k: int, arrays: Any, work: Any) -> None:
    """Put the functions of an element with k gathered patches at a point into the last (3, ...) of `work`."""
    pair_at, tip_of, side, carrier_at, share_at, place, share, tips = arrays[4:]
    at, per, of_nodes, of_tip, f = work
    mls(x, y, at, per, k, derivatives, f, of_nodes)
    n = k
    for pair in range(pair_at[element], pair_at[element + 1]):
        tip_functions(x, y, tips[tip_of[pair]], side[pair], of_tip)
        for carrier in range(carrier_at[pair], carrier_at[pair + 1]):
            value = by_x = by_y = 0.0
            for part in range(share_at[carrier], share_at[carrier + 1]):
                value += share[part] * f[0, place[part]]
                if derivatives:
                    by_x += share[part] * f[1, place[part]]
                    by_y += share[part] * f[2, place[part]]
            for j in range(4):
                f[0, n] = value * of_tip[0, j]
                if derivatives:
                    f[1, n] = value * of_tip[1, j] + by_x * of_tip[0, j]
                    f[2, n] = value * of_tip[2, j] + by_y * of_tip[0, j]
                n += 1


@kernel
def at_point(i: int, points: Floats, elements: Ints, derivatives: bool, k: int, arrays: Any, work: Any) -> int:
    """As `functions_at`, at the i-th of some points: of an element that the one before has, too, k patches are there.

    Returns the number of patches.
    """
    e = elements[i]
    if i == 0 or e != elements[i - 1]:
        k = gathered(e, work[0], work[1], arrays[0], arrays[1], arrays[2], arrays[3])
    functions_at(points[i, 0], points[i, 1], e, derivatives, k, arrays, work)
    return k


@kernel
def _put_values(arrays: Any, points: Floats, elements: Ints, start: Ints, found: Floats) -> None:
    """Put the values of all functions at points into `found` (q,), those of a point from its start (n + 1,) on."""
    work, k = workspace(arrays), 0
    for i in range(len(points)):
        k = at_point(i, points, elements, False, k, arrays, work)
        for n in range(start[i + 1] - start[i]):
            found[start[i] + n] = work[4][0, n]


@kernel
def _put_fields(
    arrays: Any, spacing: float, points: Floats, elements: Ints, start: Ints, function: Ints, u: Floats, found: Floats
) -> None:
    """Put the fields of `fields_at` into `found`; the functions (q,) of elements begin at `start`."""
    work, k = workspace(arrays), 0
    f = work[4]
    for i in range(len(points)):
        k = at_point(i, points, elements, len(found) == 3, k, arrays, work)
        first, last = start[elements[i]], start[elements[i] + 1]
        x = y = x_x = y_x = x_y = y_y = 0.0
        for n in range(first, last):
            of_x, of_y = u[2 * function[n]], u[2 * function[n] + 1]
            x += f[0, n - first] * of_x
            y += f[0, n - first] * of_y
            if len(found) == 3:
                x_x += f[1, n - first] * of_x
                y_x += f[1, n - first] * of_y
                x_y += f[2, n - first] * of_x
                y_y += f[2, n - first] * of_y
        found[0, i, 0], found[0, i, 1] = x, y
        if len(found) == 3:
            found[1, i, 0], found[1, i, 1] = x_x / spacing, y_x / spacing
            found[2, i, 0], found[2, i, 1] = x_y / spacing, y_y / spacing
