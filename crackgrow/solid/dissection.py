"""Nested dissection: an order of elimination for unknowns that have places in the plane.

Unknowns at one place stay together. A line along x or y splits the places in two; those on one side that are coupled to
the other side separate the two, and are eliminated last (George 1973). Which line, is found from the couplings: the
separator of every possible line is weighed at once. Every part is a front of the multifrontal method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from crackgrow.cover.cover import Cover
from crackgrow.cover.tips import N_TIP_FUNCTIONS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAF = 200
"""Parts with at most so many unknowns are split no further."""

SMALLER_PART = 0.15
"""A line leaves at least this fraction of the unknowns on each side, if it can."""


@dataclass(frozen=True, slots=True, eq=False)
class Fronts:
    """The elimination tree: front k eliminates the unknowns order[starts[k]:starts[k + 1]], children before parents.

    Within a front, the unknowns with places come before those without.
    """

    order: Ints  # (n,)
    starts: Ints  # (fronts + 1,)
    n_placed: Ints  # (fronts,) unknowns with places
    parent: Ints  # (fronts,), -1 for none
    boundary: tuple[Ints, ...]  # front by front, sorted positions in `order` of later unknowns coupled to the subtree

    @property
    def n(self) -> int:
        """Number of fronts."""
        return len(self.parent)


def places_of_unknowns(cover: Cover) -> Floats:
    """Places (n_dofs, 2) of the displacement unknowns in lattice coordinates: the nodes of their patches."""
    places = np.empty((cover.n_functions, 2))
    places[: len(cover.patch_nodes)] = cover.patch_nodes
    for first in cover.tip_function_ids:
        singular = first >= 0
        for k in range(N_TIP_FUNCTIONS):
            places[first[singular] + k] = cover.patch_nodes[singular]
    return np.repeat(places, 2, axis=0)


def dissect(matrix: csc_array, places: Floats) -> Fronts:
    """Fronts of a symmetric matrix (n, n); `places` (k, 2) of its first k unknowns.

    The others (multipliers) are eliminated as late as the last unknown that they are coupled to.
    """
    n, n_placed = matrix.shape[0], len(places)
    group, place = grouped(places)
    group = np.append(group, len(place) + np.arange(n - n_placed))
    graph = coupled_groups(matrix, group)
    weight = np.bincount(group)
    parts = _parts(csr_array(graph[: len(place)][:, : len(place)]), place, weight[: len(place)])
    front = np.empty(len(weight), dtype=np.int64)
    for index, part in enumerate(parts):
        front[part] = index
    late = csr_array(graph[len(place) :][:, : len(place)])
    for row in range(n - n_placed):  # multipliers, which are few
        front[len(place) + row] = front[late.indices[late.indptr[row] : late.indptr[row + 1]]].max(initial=0)
    # parts keep their inner order: along the separator, so that fronts meet in few runs
    inner = np.empty(len(weight), dtype=np.int64)
    if parts:
        inner[np.concatenate(parts)] = np.arange(len(place))
    inner[len(place) :] = np.arange(len(place), len(weight))
    sequence = np.lexsort((inner, front))
    return _symbolic(graph, group, sequence, front[sequence], len(place))


def grouped(places: Floats) -> tuple[Ints, Floats]:
    """Number (n,) of the group that each of the `places` (n, 2) belongs to, and the groups' places (groups, 2)."""
    place, group = np.unique(places, axis=0, return_inverse=True)
    return group.ravel(), place


def coupled_groups(matrix: csc_array, group: Ints) -> csr_array:
    """Which groups of unknowns are coupled: a symmetric pattern (groups, groups) with its diagonal."""
    n, n_groups = len(group), int(group.max(initial=-1)) + 1
    pattern = csc_array((np.ones(matrix.nnz, dtype=np.int8), matrix.indices, matrix.indptr), shape=matrix.shape)
    member = csc_array((np.ones(n, dtype=np.int8), (np.arange(n), group)), shape=(n, n_groups))
    first = csc_array(pattern @ member)
    first.data[:] = 1
    return csr_array(member.T @ first)


def _parts(graph: csr_array, place: Floats, weight: Ints) -> list[Ints]:
    """Leaves and separators, children before parents: groups of each."""
    found: list[Ints] = []
    waiting = [(np.arange(len(place)), graph)]
    while waiting:
        part, couplings = waiting.pop()
        split = _split(couplings, place[part], weight[part]) if weight[part].sum() > LEAF else None
        if split is None:
            if len(part):
                found.append(part)
            continue
        separator, sides = split
        if len(separator):
            found.append(part[separator])
        waiting.extend((part[side], csr_array(couplings[side][:, side])) for side in sides)
    return found[::-1]


def _split(graph: csr_array, place: Floats, weight: Ints) -> tuple[Ints, tuple[Ints, Ints]] | None:
    """The best separator, and the two sides without it; None where no line splits."""
    best: tuple[float, int, int, bool] | None = None
    total = int(weight.sum())
    spans = []
    for axis in (0, 1):
        line = np.unique(place[:, axis], return_inverse=True)[1]
        n_lines = int(line.max()) + 1
        neighbours = line[graph.indices]
        low = np.minimum.reduceat(neighbours, graph.indptr[:-1])
        high = np.maximum.reduceat(neighbours, graph.indptr[:-1])
        spans.append((line, low, high))
        # a line t lies between the columns t - 1 and t; a group is on its left if its column is below t
        left = np.cumsum(np.bincount(line, weight, n_lines))[:-1]
        for from_left, (begin, end) in ((True, (line, high)), (False, (low, line))):
            change = np.bincount(begin, weight, n_lines + 1) - np.bincount(end, weight, n_lines + 1)
            separating = np.cumsum(change)[: n_lines - 1]
            a = left - separating if from_left else left
            b = total - left if from_left else total - left - separating
            smaller = np.minimum(a, b)
            cost = np.where(smaller > 0, separating / np.sqrt(np.maximum(smaller, 1) / total), np.inf)
            cost = np.where(smaller < SMALLER_PART * total, 10.0 * cost, cost)
            if len(cost) and np.isfinite(cost).any() and (best is None or cost.min() < best[0]):
                best = (float(cost.min()), axis, int(np.argmin(cost)) + 1, from_left)
    if best is None:
        return None
    _, axis, cut, from_left = best
    line, low, high = spans[axis]
    on_left = line < cut
    separates = on_left & (high >= cut) if from_left else ~on_left & (low < cut)
    separator = np.flatnonzero(separates)
    separator = separator[np.lexsort((place[separator, axis], place[separator, 1 - axis]))]
    return separator, (np.flatnonzero(on_left & ~separates), np.flatnonzero(~on_left & ~separates))


def _symbolic(graph: csr_array, group: Ints, sequence: Ints, front: Ints, n_placed_groups: int) -> Fronts:
    """The tree of fronts, from the `sequence` (groups,) in which groups are eliminated, in their `front` (groups,)."""
    size = np.bincount(group)[sequence]
    first = np.append(0, np.cumsum(size))  # position in the order of the unknowns
    place_of = np.empty(len(sequence), dtype=np.int64)
    place_of[sequence] = np.arange(len(sequence))
    order = np.argsort(place_of[group], kind="stable")
    n_fronts = int(front.max(initial=-1)) + 1
    ends = np.searchsorted(front, np.arange(n_fronts + 1))
    graph = csr_array(graph[sequence])
    later = place_of[graph.indices]
    parent = np.full(n_fronts, -1)
    borders: list[Ints] = []
    inherited: list[list[Ints]] = [[] for _ in range(n_fronts)]
    for k in range(n_fronts):
        coupled = later[graph.indptr[ends[k]] : graph.indptr[ends[k + 1]]]
        border = np.unique(np.concatenate([coupled, *inherited[k]]))
        border = border[np.searchsorted(border, ends[k + 1]) :]
        borders.append(border)
        if len(border):
            parent[k] = front[border[0]]
            inherited[parent[k]].append(border)
    placed = np.add.reduceat(np.where(sequence < n_placed_groups, size, 0), ends[:-1]) if n_fronts else size
    return Fronts(order, first[ends], placed, parent, tuple(_ranges(first[b], size[b]) for b in borders))


def _ranges(start: Ints, length: Ints) -> Ints:
    """The numbers start, start + 1, ... of each of several ranges, one after another."""
    end = np.cumsum(length)
    return np.asarray(np.repeat(start - end + length, length) + np.arange(end[-1] if len(end) else 0))
