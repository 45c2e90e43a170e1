"""The basis at points of elements, and what is made of it: sparse rows, derivatives by function, and fields.

    u(x) = sum_i phi_i(x) u_i + sum_tk F_tk(x) sum_c X_c(x) a_ctk,    paper eqs. (2), (3),

over the physical patches i, and over the tips t that act on the element with their four functions F_tk. What carries
these, X_c = sum_i chi_i phi_i, is the function of a singular patch, as in the paper, or a sum over the patches round
the tip.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from crackgrow.approximation.mls import mls
from crackgrow.approximation.tip_functions import tip_functions
from crackgrow.arrays import Floats, Ints
from crackgrow.compiled import kernel
from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS
from crackgrow.ragged import numbered

assert N_TIP_FUNCTIONS == 4  # the kernels count by it


@dataclass(frozen=True, slots=True, eq=False)
class Basis:
    """All functions at n points: those at point i are the places start[i] to start[i + 1], patches first."""

    n_functions: int
    start: Ints  # (n + 1,)
    functions: Ints  # (q,)
    values: Floats  # (1, q), or (3, q) with the derivatives by x and by y, per metre

    @property
    def rows(self) -> csr_array:
        """The values (n, n_functions)."""
        return csr_array((self.values[0], self.functions, self.start), shape=(len(self.start) - 1, self.n_functions))

    def fields(self, u: Floats) -> Floats:
        """The displacement, and its derivatives by x and by y if they are there (1 or 3, n, 2), of `u` (n_dofs,) m."""
        found = np.zeros((len(self.values), len(self.start) - 1, 2))
        _add_fields(self.start, self.functions, self.values, u, found)
        return found

    @property
    def columns(self) -> tuple[Ints, Ints]:
        """The functions (k,) that there are, ascending, and which of them each value (q,) is of."""
        return numbered(self.functions, self.n_functions)

    def summed(self, weights: Floats) -> tuple[Ints, Floats]:
        """These functions (k,), and sums (k, c) over points and both derivatives of these times `weights` (2, n, c)."""
        functions, column = self.columns
        total = np.zeros((len(functions), weights.shape[2]))
        _add_sums(self.start, column, self.values, np.ascontiguousarray(weights), total)
        return functions, total


def basis_at(cover: Cover, points: Floats, elements: Ints, *, derivatives: bool = True) -> Basis:
    """Values and derivatives at points (n, 2), lattice coordinates, each inside or on the rim of its element (n,)."""
    on = cover.functions.taken(elements)
    values = np.empty((3 if derivatives else 1, len(on.values)))
    _values(cover.arrays, cover.lattice.spacing, points, elements, on.start, values)
    return Basis(cover.n_functions, on.start, on.values, values)


def values_at(cover: Cover, points: Floats, elements: Ints) -> Basis:
    """The values of `basis_at` alone."""
    return basis_at(cover, points, elements, derivatives=False)


def of_component(rows: csr_array, component: int) -> csr_array:
    """Rows (m, n_dofs) that give of one displacement component what `rows` (m, n_functions) give of a scalar field."""
    m, n = rows.shape
    return csr_array((rows.data, 2 * rows.indices + component, rows.indptr), shape=(m, 2 * n))


@kernel
def _add_fields(start: Ints, function: Ints, values: Floats, u: Floats, total: Floats) -> None:
    """Add the fields (., n, 2) of `u` (n_dofs,) at points whose functions begin at `start` (n + 1,)."""
    for k in range(len(values)):
        for i in range(len(start) - 1):
            for q in range(start[i], start[i + 1]):
                total[k, i, 0] += values[k, q] * u[2 * function[q]]
                total[k, i, 1] += values[k, q] * u[2 * function[q] + 1]


@kernel
def _add_sums(start: Ints, row: Ints, values: Floats, weights: Floats, total: Floats) -> None:
    """Add the sums of `Basis.summed` to the rows of `total` (k, c) that are those of the functions."""
    for i in range(len(start) - 1):
        for q in range(start[i], start[i + 1]):
            for c in range(total.shape[1]):
                total[row[q], c] += values[1, q] * weights[0, i, c] + values[2, q] * weights[1, i, c]


@kernel
def most_functions(patch_at: Ints, pair_at: Ints, carrier_at: Ints) -> int:
    """The largest number of functions on an element."""
    most = 0
    for e in range(len(patch_at) - 1):
        carriers = carrier_at[pair_at[e + 1]] - carrier_at[pair_at[e]]
        most = max(most, patch_at[e + 1] - patch_at[e] + 4 * carriers)
    return most


@kernel
def workspace(most: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """What `gathered` and `functions_at` work in, where at most so many functions are on an element."""
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
def _values(arrays: Any, spacing: float, points: Floats, elements: Ints, start: Ints, found: Floats) -> None:
    """Put all functions at points into `found` (components, q), those of a point from its start (n + 1,) on."""
    nodes, half, patch_at, patch, pair_at, _, _, carrier_at = arrays[:8]
    work, derivatives, k = workspace(most_functions(patch_at, pair_at, carrier_at)), len(found) == 3, 0
    at, per, _, _, f = work
    scale = 1.0 / spacing
    for i in range(len(points)):
        e = elements[i]
        if i == 0 or e != elements[i - 1]:
            k = gathered(e, at, per, nodes, half, patch_at, patch)
        functions_at(points[i, 0], points[i, 1], e, derivatives, k, arrays, work)
        for n in range(start[i + 1] - start[i]):
            found[0, start[i] + n] = f[0, n]
            if derivatives:
                found[1, start[i] + n] = scale * f[1, n]
                found[2, start[i] + n] = scale * f[2, n]
