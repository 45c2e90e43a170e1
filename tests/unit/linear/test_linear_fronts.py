"""The order of elimination: parts that are not coupled, fronts that cover all couplings, places of multipliers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from crackgrow.linear.dissection import LEAF, dissected
from crackgrow.linear.fronts import Fronts, fronts_of
from tests.symmetric_matrices import symmetric
from tests.unit.linear.lattices import Ints, boxes_at, lattice


def boxes_of_many_sizes(seed: int, n: int) -> tuple[Ints, Ints]:
    """Corners of n squares of 1 to 16 units, different ones in different places."""
    rng = np.random.default_rng(seed)
    half, middle = 2 ** rng.integers(0, 4, n), rng.integers(-90, 110, (n, 2))
    return middle - half[:, None], middle + half[:, None]


def ancestors(parent: Ints, part: int) -> list[int]:
    above = [part]
    while parent[above[-1]] >= 0:
        above.append(int(parent[above[-1]]))
    return above


@pytest.mark.parametrize("n", [1, 7, 300, 2000])
@pytest.mark.parametrize("n_sides", [1, 3])
def test_parts_of_a_dissection_are_coupled_to_those_above_them_alone(n: int, n_sides: int) -> None:
    """Boxes of one side that overlap are in one part, or in one below the other; the sides lie over each other."""
    low, high = boxes_of_many_sizes(n, n)
    overlap = ((low[:, None] < high) & (low < high[:, None])).all(axis=2)
    sides = np.random.default_rng(n).integers(n_sides, size=n)
    couplings = csr_array(np.tril(overlap & (sides[:, None] == sides)))
    part, parent, along = dissected(low, high, couplings.indptr, couplings.indices)
    np.testing.assert_array_equal(np.sort(along), np.arange(n))
    assert len(parent) > n // (4 * LEAF)
    assert (parent[:-1] > np.arange(len(parent) - 1)).all()
    pairs = np.unique(np.sort(part[np.argwhere(couplings.toarray())], axis=1), axis=0)
    assert all(upper in ancestors(parent, lower) for lower, upper in pairs.tolist())
    for piece in range(len(parent)):
        assert len(set(sides[part == piece].tolist())) == 1 or np.sum(part == piece) <= LEAF


def test_separators_of_a_lattice_are_as_wide_as_the_couplings_reach() -> None:
    """40 x 40 nodes that reach 2 nodes far: two columns of nodes separate, 160 unknowns; L has few entries."""
    matrix, nodes = lattice(40, 17)
    fronts = fronts_of(symmetric(matrix), csr_array((0, 3200)), *boxes_at(nodes))
    own, border = np.diff(fronts.starts), np.diff(fronts.border_start)
    assert own[-2:].tolist() == [160, 0]  # the last one is for what is in several pieces from the beginning
    assert np.sum(own * (own + border)) < 0.15 * matrix.shape[0] ** 2


def test_bodies_that_constraints_alone_join_are_cut_as_one() -> None:
    """Ten strips of 40 x 4 nodes, bonded to each other: no front holds more than some of the nine bonds."""
    one, nodes = lattice(40, 5)
    strip = np.repeat(nodes[:, 1] // 4, 2)
    matrix = csc_array(one.multiply(strip[:, None] == strip))
    below = np.flatnonzero((nodes[:, 1] % 4 == 3) & (nodes[:, 1] < 39))
    rows = np.zeros((len(below), len(strip)))
    rows[np.arange(len(below)), 2 * below], rows[np.arange(len(below)), 2 * below + 2] = 1.0, -1.0
    fronts = fronts_of(symmetric(matrix), csr_array(rows), *boxes_at(nodes))
    assert np.diff(fronts.starts).max() < 400  # of 3560, of which the bonds are 1080


def held_lattice(n: int) -> tuple[csc_array, csr_array, Fronts]:
    """A lattice with constraints on one unknown, on neighbours, and on many across it."""
    matrix, nodes = lattice(n, 16)
    rng = np.random.default_rng(3)
    rows = np.zeros((9, matrix.shape[0]))
    for count, row in zip((1, 1, 2, 2, 5, 5, 9, 0, 30), rows, strict=True):
        at = rng.integers(len(row)) if count < 5 else rng.integers(len(row), size=count)
        row[(at + np.arange(count)) % len(row) if count < 5 else at] = 1.0
    constraints = csr_array(rows)
    return matrix, constraints, fronts_of(symmetric(matrix), constraints, *boxes_at(nodes))


@pytest.mark.parametrize("n", [5, 24])
def test_fronts_cover_all_couplings(n: int) -> None:
    """Each unknown is eliminated once; later ones that it is coupled to lie in its front or border, also those of C."""
    matrix, constraints, fronts = held_lattice(n)
    n_unknowns, total = matrix.shape[0], len(fronts.order)
    np.testing.assert_array_equal(np.sort(fronts.order), np.arange(total))
    whole = np.block([[abs(matrix).toarray() + abs(constraints.T @ constraints).toarray(), constraints.T.toarray()],
                      [constraints.toarray(), np.eye(9)]])[np.ix_(fronts.order, fronts.order)]  # fmt: skip
    for k in range(fronts.n):
        start, end = fronts.starts[k : k + 2]
        border = fronts.border[fronts.border_start[k] : fronts.border_start[k + 1]]
        own = fronts.order[start:end]
        assert ((own < n_unknowns) == (np.arange(end - start) < fronts.n_placed[k])).all()
        later = np.flatnonzero(whole[start:end].any(axis=0))
        assert np.isin(later[later >= end], border).all()
        parents = fronts.children.row[fronts.children.values == k]
        assert len(parents) == (k < fronts.n - 1)
        if not len(parents):
            assert not len(border)
        else:
            up = int(parents[0])
            there = np.append(
                np.arange(*fronts.starts[up : up + 2]), fronts.border[slice(*fronts.border_start[up : up + 2])]
            )
            into = fronts.into[fronts.border_start[k] : fronts.border_start[k + 1]]
            np.testing.assert_array_equal(there[into], border)


@pytest.mark.parametrize("n", [5, 24])
def test_multipliers_come_after_all_that_they_act_on(n: int) -> None:
    _, constraints, fronts = held_lattice(n)
    place = np.argsort(fronts.order)
    for row in range(9):
        acts_on = constraints.indices[constraints.indptr[row] : constraints.indptr[row + 1]]
        assert place[constraints.shape[1] + row] > place[acts_on].max(initial=-1)


def test_couplings_beyond_the_boxes_are_refused() -> None:
    matrix, nodes = lattice(30, 7)
    wrong = np.random.default_rng(9).permutation(nodes)
    with pytest.raises(ValueError, match="further apart than couplings reach"):
        fronts_of(symmetric(matrix), csr_array((0, 1800)), *boxes_at(wrong))
