"""The fronts of the multifrontal method: which unknowns each eliminates, and which later ones they are coupled to.

A front belongs to a part of the dissection. A multiplier is eliminated in the lowest front above all that it acts on,
after the functions there. Where constraints hold what the matrix leaves free, functions that one acts on are eliminated
no lower than where all of them come together: they lie on one way up the tree, and the multiplier at its end. Ties act
on what is held without them; their functions stay where they are, and the multiplier is in the borders of their fronts.
So cracks divide rock that is tied across them, too: two multipliers at a point are fewer than the functions there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from crackgrow.arrays import Bools, Ints
from crackgrow.compiled import kernel
from crackgrow.linear.dissection import dissected
from crackgrow.linear.matrix import SymmetricMatrix
from crackgrow.ragged import Ragged, by_row, spans, starts_of


@dataclass(frozen=True, slots=True, eq=False)
class Fronts:
    """The elimination tree of n unknowns and of m multipliers and t of ties, numbered behind them, children first.

    Front k eliminates the unknowns at the places starts[k] to starts[k + 1], `n_placed[k]` of functions, then
    multipliers. Its own unknowns and then its border have numbers there, from 0 on: `local` to the front.
    """

    order: Ints  # (n + m + t,) unknown at each place
    starts: Ints  # (fronts + 1,)
    n_placed: Ints  # (fronts,)
    children: Ragged  # fronts -> those whose borders they take, ascending
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
    tie_start: Ints  # (functions + 1,) of the entries of ties with each function, in the order of elimination
    tie: Ints  # (s,) which entry
    tie_column: Ints  # (s,) number in the function's front of the tie's multiplier

    @property
    def n(self) -> int:
        """Number of fronts."""
        return self.children.n


def fronts_of(
    matrix: SymmetricMatrix, constraints: csr_array, ties: tuple[Ints, Ints], boxes: tuple[Ints, Ints]
) -> Fronts:
    """Fronts of the unknowns of `matrix` (n, n), whose functions have `boxes`, lowest and highest corners (n / 2, 2).

    Also of the multipliers of `constraints` (m, n) and of ties, whose functions (s,) begin at the first array (t + 1,)
    of `ties`. Raises ValueError where functions are coupled whose boxes do not overlap.
    """
    n, m = matrix.n_functions, constraints.shape[0]
    indptr, indices = constraints.indptr.astype(np.int64), constraints.indices.astype(np.int64)
    of_tie, tie = np.repeat(np.arange(len(ties[0]) - 1), np.diff(ties[0])), np.argsort(ties[1], kind="stable")
    by_function = by_row(ties[1][tie], of_tie[tie], n)
    part, parent, along = dissected(
        *boxes, _joined(matrix, indptr, indices // 2), (by_function.start, by_function.values)
    )
    front = np.append(part, np.full(m, len(parent) - 1))
    begins = _together(front, parent, indptr, indices // 2)
    front = np.append(front, _tied(front, parent, *ties))
    order = np.append(along, np.arange(n, len(front)))
    order = order[np.argsort(front[order], kind="stable")]
    width = np.where(order < n, 2, 1)
    offset = np.append(0, np.cumsum(width))
    first = np.searchsorted(front[order], np.arange(len(parent) + 1))
    held = np.argsort(begins, kind="stable")
    held_start = np.searchsorted(begins[held], np.arange(len(parent) + 1))
    position = np.empty(len(order), dtype=np.int64)
    position[order] = np.arange(len(order))
    at, block, turned, later = _blocks_by_row(matrix, position)
    tie = np.argsort(position[ties[1]], kind="stable")
    tie_start = np.searchsorted(position[ties[1]][tie], np.arange(len(order) + 1))
    tie_later = position[n + m + of_tie[tie]]
    child = np.argsort(parent[:-1], kind="stable")
    children = by_row(parent[child], child, len(parent))
    n_functions = np.diff(np.append(0, np.cumsum(order < n))[first])
    border_start, border, into, block_column, held_column, multiplier_column, tie_column = _local_numbers(
        (at, later),
        first,
        (children.start, children.values),
        offset,
        (held_start, held),
        (indptr, indices),
        position,
        (tie_start, tie_later),
        n,
    )
    if border_start[-1] < 0:
        raise ValueError("functions are coupled that are further apart than couplings reach")
    unknown = np.repeat(np.where(order < n, 2 * order, n + order), width)
    unknown[offset[:-1][order < n] + 1] += 1
    counts = width[border]
    return Fronts(
        unknown, offset[first], 2 * n_functions, children, starts_of(counts)[border_start],
        spans(offset[border], counts), spans(into, counts), first, at, block, turned,
        block_column, held_start, held, held_column, multiplier_column, tie_start, tie, tie_column,
    )  # fmt: skip


def _joined(matrix: SymmetricMatrix, start: Ints, function: Ints) -> tuple[Ints, Ints]:
    """What joins functions: starts (n + 1,), and those (q,) that each is joined to, before it and itself.

    They are the blocks of the matrix, and what each constraint acts on, one by one: bonded bodies are one piece. Its
    functions, from `start` on, are in `function`.
    """
    in_a_row = np.flatnonzero(np.diff(np.repeat(np.arange(len(start) - 1), np.diff(start))) == 0)
    one, other = function[in_a_row], function[in_a_row + 1]
    later, more = np.maximum(one, other), np.zeros(matrix.n_functions + 1, dtype=np.int64)
    np.add.at(more, later + 1, 1)
    column = np.insert(matrix.column, matrix.start[later], np.minimum(one, other))  # a row's last one stays itself
    return matrix.start + np.cumsum(more), column


@kernel
def _together(front: Ints, parent: Ints, start: Ints, function: Ints) -> Ints:
    """Move functions and multipliers to the fronts that they are eliminated in; where (m,) each constraint begins.

    `front` (n + m,) are of functions and multipliers, `function` of the entries of constraints from `start` on.
    """
    m = len(start) - 1
    n, moved, begins = len(front) - m, front.copy(), np.empty(m, np.int64)
    for r in range(m):
        if start[r] < start[r + 1]:
            common = _common(front, parent, function[start[r] : start[r + 1]])
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
def _tied(front: Ints, parent: Ints, start: Ints, function: Ints) -> Ints:
    """The fronts (t,) that multipliers of ties are eliminated in: each acts on functions from start[r] on."""
    found = np.empty(len(start) - 1, np.int64)
    for r in range(len(found)):
        found[r] = _common(front, parent, function[start[r] : start[r + 1]])
    return found


@kernel
def _common(front: Ints, parent: Ints, functions: Ints) -> int:
    """The lowest front above those of some functions."""
    common: int = front[functions[0]]
    for function in functions[1:]:
        other = front[function]
        while other != common:  # parents come later
            if other < common:
                other = parent[other]
            else:
                common = parent[common]
    return common


def _blocks_by_row(matrix: SymmetricMatrix, position: Ints) -> tuple[Ints, Ints, Bools, Ints]:
    """Of each function or multiplier, in the order of elimination, the blocks with later ones and itself.

    Starts, which blocks of the matrix they are, whether transposed, and the position of the later one.
    """
    one, other, number = position[matrix.row], position[matrix.column], np.arange(len(matrix.column))
    shape = (len(position), len(number))
    rows = coo_array((number, (np.minimum(one, other), number)), shape=shape).tocsr()  # sorts them by row, in a count
    start, block = rows.indptr.astype(np.int64), rows.data
    return start, block, (other < one)[block], np.maximum(one, other)[block]


@kernel
def _local_numbers(
    blocks: tuple[Ints, Ints],
    first: Ints,
    below: tuple[Ints, Ints],
    offset: Ints,
    holding: tuple[Ints, Ints],
    entries: tuple[Ints, Ints],
    position: Ints,
    tied: tuple[Ints, Ints],
    n: int,
) -> tuple[Ints, Ints, Ints, Ints, Ints, Ints, Ints]:
    """The borders of fronts: starts, ascending positions behind a front that its subtree meets, numbers in the parent.

    Also the numbers, in their fronts, of blocks, of entries of constraints and of multipliers. Numbers are those of
    first unknowns. The last start is -1 where a subtree meets what its parents don't hold.
    """
    (at, later), (child_start, children), (held_start, held), (indptr, indices) = blocks, below, holding, entries
    n_fronts = len(first) - 1
    tie_start, tie_later = tied
    tie_column = np.empty(len(tie_later), np.int64)
    mark, local, start = np.full(len(position), -1), np.empty(len(position), np.int64), np.zeros(n_fronts + 1, np.int64)
    border, into = np.empty(4 * len(position), np.int64), np.empty(4 * len(position), np.int64)
    column, held_column = np.empty(len(later), np.int64), np.empty(len(indices), np.int64)
    multiplier_column = np.empty(len(held), np.int64)
    for p in range(n_fronts):
        end, total = first[p + 1], start[p]
        if total + len(position) > len(border):
            border = np.append(border, np.empty(len(border) + len(position), np.int64))
            into = np.append(into, np.empty(len(into) + len(position), np.int64))
        for q in range(at[first[p]], at[end]):
            total = _met(later[q], p, end, mark, border, total)
        for q in range(tie_start[first[p]], tie_start[end]):
            total = _met(tie_later[q], p, end, mark, border, total)
        for r in held[held_start[p] : held_start[p + 1]]:
            total = _met(position[n + r], p, end, mark, border, total)
            for q in range(indptr[r], indptr[r + 1]):
                total = _met(position[indices[q] // 2], p, end, mark, border, total)
        for c in children[child_start[p] : child_start[p + 1]]:
            if start[c + 1] > start[c] and border[start[c]] < first[p]:
                start[-1] = -1
                return start, border, into, column, held_column, multiplier_column, tie_column
            for q in range(start[c], start[c + 1]):
                total = _met(border[q], p, end, mark, border, total)
        border[start[p] : total].sort()
        start[p + 1], number = total, 0
        for k in range(first[p], end):
            local[k] = number
            number += offset[k + 1] - offset[k]
        for k in border[start[p] : total]:
            local[k] = number
            number += offset[k + 1] - offset[k]
        for q in range(at[first[p]], at[end]):
            column[q] = local[later[q]]
        for q in range(tie_start[first[p]], tie_start[end]):
            tie_column[q] = local[tie_later[q]]
        for r in held[held_start[p] : held_start[p + 1]]:
            multiplier_column[r] = local[position[n + r]]
            for q in range(indptr[r], indptr[r + 1]):
                held_column[q] = local[position[indices[q] // 2]] + indices[q] % 2
        for c in children[child_start[p] : child_start[p + 1]]:
            for q in range(start[c], start[c + 1]):
                into[q] = local[border[q]]
    if start[-1] > start[-2]:  # the last front has no parent
        start[-1] = -1
    return (
        start,
        border[: start[-1]].copy(),
        into[: start[-1]].copy(),
        column,
        held_column,
        multiplier_column,
        tie_column,
    )


@kernel
def _met(j: int, p: int, end: int, mark: Ints, border: Ints, total: int) -> int:
    """Add position j to the border of front p, unless it is before its `end` or there already; the border's end."""
    if j >= end and mark[j] != p:
        mark[j] = p
        border[total] = j
        total += 1
    return total
