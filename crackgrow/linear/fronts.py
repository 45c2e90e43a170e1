"""The fronts of the multifrontal method: which unknowns each eliminates, and which later ones they are coupled to.

A front belongs to a part of the dissection. A multiplier is eliminated in the lowest front above all that it acts on,
after the functions there, and functions on which a multiplier acts are eliminated no lower than where all that it acts
on come together. So what a multiplier acts on lies on one way up the tree, and the multiplier at its end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Bools, Ints
from crackgrow.compiled import kernel
from crackgrow.linear.dissection import dissected
from crackgrow.linear.matrix import SymmetricMatrix


@dataclass(frozen=True, slots=True, eq=False)
class Fronts:
    """The elimination tree of n unknowns and of m multipliers, which are numbered behind them, children first.

    Front k eliminates the unknowns at the places starts[k] to starts[k + 1], `n_placed[k]` of functions, then
    multipliers. Its own unknowns and then its border have numbers there, from 0 on: `local` to the front.
    """

    order: Ints  # (n + m,) unknown at each place
    starts: Ints  # (fronts + 1,)
    n_placed: Ints  # (fronts,)
    parent: Ints  # (fronts,), -1 for none
    border_start: Ints  # (fronts + 1,)
    border: Ints  # (b,) of each front, ascending places of later unknowns that its subtree is coupled to
    into: Ints  # (b,) what their numbers are in the parent
    row_start: Ints  # (fronts + 1,) of each front's functions among all in the order of elimination
    block_start: Ints  # (functions + 1,) of their blocks with later ones
    block: Ints  # (q,) which one of the matrix
    turned: Bools  # (q,) whether it is transposed there
    block_column: Ints  # (q,) number in the front of the later one's first unknown
    held_start: Ints  # (fronts + 1,) of the constraints that begin in each front
    held: Ints  # (m,) these constraints
    held_column: Ints  # (p,) number in its front of what each entry of the constraints, in their order, acts on
    multiplier_column: Ints  # (m,) and of each constraint's multiplier

    @property
    def n(self) -> int:
        """Number of fronts."""
        return len(self.parent)


def fronts_of(matrix: SymmetricMatrix, constraints: csr_array, low: Ints, high: Ints) -> Fronts:
    """Fronts of the unknowns of `matrix` (n, n), whose functions have boxes from `low` to `high` (n / 2, 2).

    Also of the multipliers of `constraints` (m, n). Raises ValueError where functions are coupled whose boxes do not
    overlap.
    """
    n, m = matrix.n_functions, constraints.shape[0]
    part, parent, along = dissected(low, high)
    indptr, indices = constraints.indptr.astype(np.int64), constraints.indices.astype(np.int64)
    front = np.append(part, np.full(m, len(parent) - 1))
    begins = _together(front, parent, indptr, indices // 2)
    order = np.append(along, np.arange(n, n + m))
    order = order[np.argsort(front[order], kind="stable")]
    width = np.where(order < n, 2, 1)
    offset = np.append(0, np.cumsum(width))
    first = np.searchsorted(front[order], np.arange(len(parent) + 1))
    held = np.argsort(begins, kind="stable")
    held_start = np.searchsorted(begins[held], np.arange(len(parent) + 1))
    position = np.empty(n + m, dtype=np.int64)
    position[order] = np.arange(n + m)
    blocks = _blocks_by_row(matrix.start, matrix.column, order, position)
    border_start, border = _borders(
        blocks[0], blocks[3], first, parent, held_start, held, indptr, indices // 2, position
    )
    if len(border) == 1 and border[0] < 0:
        raise ValueError("functions are coupled that are further apart than couplings reach")
    rest_start, rest, into, block_column, held_column, multiplier_column = _numbers(
        blocks[0], blocks[3], first, parent, (border_start, border), offset, held_start, held, indptr, indices, position
    )
    starts = offset[first]
    n_functions = np.diff(np.append(0, np.cumsum(order < n))[first])
    unknown = np.repeat(np.where(order < n, 2 * order, n + order), width)
    unknown[offset[:-1][order < n] + 1] += 1
    return Fronts(
        unknown, starts, 2 * n_functions, parent, rest_start, rest, into, first, blocks[0], blocks[1], blocks[2],
        block_column, held_start, held, held_column, multiplier_column,
    )  # fmt: skip


@kernel
def _together(front: Ints, parent: Ints, start: Ints, function: Ints) -> Ints:
    """Move functions and multipliers to the fronts that they are eliminated in; where (m,) each constraint begins.

    `front` (n + m,) are of functions and multipliers, `function` of the entries of constraints from `start` on.
    """
    m = len(start) - 1
    n, moved, begins = len(front) - m, front.copy(), np.empty(m, np.int64)
    for r in range(m):
        if start[r] < start[r + 1]:
            common = front[function[start[r]]]
            for q in range(start[r] + 1, start[r + 1]):
                other = front[function[q]]
                while other != common:  # parents come later
                    if other < common:
                        other = parent[other]
                    else:
                        common = parent[common]
            for q in range(start[r], start[r + 1]):
                moved[function[q]] = max(moved[function[q]], common)
    for r in range(m):
        last, begin = -1, len(parent) - 1
        for q in range(start[r], start[r + 1]):
            last = max(last, moved[function[q]])
            begin = min(begin, moved[function[q]])
        moved[n + r] = last if last >= 0 else begin
        begins[r] = begin
    front[:] = moved
    return begins


@kernel
def _blocks_by_row(start: Ints, column: Ints, order: Ints, position: Ints) -> tuple[Ints, Ints, Bools, Ints]:
    """Of each function or multiplier, in the order of elimination, the blocks with later ones and itself.

    Starts, which blocks of the matrix they are, whether transposed, and the position of the later one.
    """
    n, q = len(start) - 1, len(column)
    at = np.zeros(len(order) + 1, np.int64)
    for i in range(n):
        for s in range(start[i], start[i + 1]):
            at[min(position[i], position[column[s]]) + 1] += 1
    for k in range(len(order)):
        at[k + 1] += at[k]
    free, block, turned, later = at[:-1].copy(), np.empty(q, np.int64), np.empty(q, np.bool_), np.empty(q, np.int64)
    for i in range(n):
        for s in range(start[i], start[i + 1]):
            a, b = position[i], position[column[s]]
            row = min(a, b)
            place = free[row]
            free[row] += 1
            block[place], turned[place], later[place] = s, b < a, max(a, b)
    return at, block, turned, later


@kernel
def _borders(
    at: Ints, later: Ints, first: Ints, parent: Ints, held_start: Ints, held: Ints, indptr: Ints, function: Ints,
    position: Ints,
) -> tuple[Ints, Ints]:  # fmt: skip
    """Starts (fronts + 1,), and the ascending positions behind a front that its subtree meets; or one -1."""
    n_fronts, n = len(parent), len(position) - len(held)
    mark, start = np.full(len(position) + 1, -1), np.zeros(n_fronts + 1, np.int64)
    child, sibling = np.full(n_fronts, -1), np.full(n_fronts, -1)
    border, total = np.empty(4 * len(position), np.int64), 0
    for p in range(n_fronts):
        end = first[p + 1]
        if total + len(position) > len(border):
            border = np.append(border, np.empty(len(border) + len(position), np.int64))
        for q in range(at[first[p]], at[end]):
            j = later[q]
            if j >= end and mark[j] != p:
                mark[j] = p
                border[total] = j
                total += 1
        for s in range(held_start[p], held_start[p + 1]):
            r = held[s]
            for q in range(indptr[r], indptr[r + 1] + 1):
                j = position[function[q]] if q < indptr[r + 1] else position[n + r]
                if j >= end and mark[j] != p:
                    mark[j] = p
                    border[total] = j
                    total += 1
        c = child[p]
        while c >= 0:
            if start[c + 1] > start[c] and border[start[c]] < first[p]:
                return start, np.full(1, -1)
            for q in range(start[c], start[c + 1]):
                j = border[q]
                if j >= end and mark[j] != p:
                    mark[j] = p
                    border[total] = j
                    total += 1
            c = sibling[c]
        border[start[p] : total].sort()
        start[p + 1] = total
        if parent[p] >= 0:
            sibling[p] = child[parent[p]]
            child[parent[p]] = p
        elif total > start[p]:
            return start, np.full(1, -1)
    return start, border[:total].copy()


@kernel
def _numbers(
    at: Ints, later: Ints, first: Ints, parent: Ints, borders: tuple[Ints, Ints], offset: Ints, held_start: Ints,
    held: Ints, indptr: Ints, indices: Ints, position: Ints,
) -> tuple[Ints, Ints, Ints, Ints, Ints, Ints]:  # fmt: skip
    """The borders by unknowns, their numbers in parents, and numbers of blocks, entries of constraints, multipliers."""
    border_start, border = borders
    n_fronts, n = len(parent), len(position) - len(held)
    start = np.zeros(n_fronts + 1, np.int64)
    for p in range(n_fronts):
        start[p + 1] = start[p]
        for q in range(border_start[p], border_start[p + 1]):
            start[p + 1] += offset[border[q] + 1] - offset[border[q]]
    rest, into = np.empty(start[-1], np.int64), np.empty(start[-1], np.int64)
    column, local = np.empty(len(later), np.int64), np.empty(len(position), np.int64)
    held_column, multiplier_column = np.empty(len(indices), np.int64), np.empty(len(held), np.int64)
    child, sibling = np.full(n_fronts, -1), np.full(n_fronts, -1)
    for p in range(n_fronts):
        for k in range(first[p], first[p + 1]):
            local[k] = offset[k] - offset[first[p]]
        place, number = start[p], offset[first[p + 1]] - offset[first[p]]
        for q in range(border_start[p], border_start[p + 1]):
            k = border[q]
            local[k] = number
            for unknown in range(offset[k], offset[k + 1]):
                rest[place] = unknown
                place += 1
                number += 1
        for q in range(at[first[p]], at[first[p + 1]]):
            column[q] = local[later[q]]
        for s in range(held_start[p], held_start[p + 1]):
            r = held[s]
            for q in range(indptr[r], indptr[r + 1]):
                held_column[q] = local[position[indices[q] // 2]] + indices[q] % 2
            multiplier_column[r] = local[position[n + r]]
        c = child[p]
        while c >= 0:
            place = start[c]
            for q in range(border_start[c], border_start[c + 1]):
                k = border[q]
                for component in range(offset[k + 1] - offset[k]):
                    into[place] = local[k] + component
                    place += 1
            c = sibling[c]
        if parent[p] >= 0:
            sibling[p] = child[parent[p]]
            child[parent[p]] = p
    return start, rest, into, column, held_column, multiplier_column
