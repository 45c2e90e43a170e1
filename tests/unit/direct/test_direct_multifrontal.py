"""The multifrontal factorization: solutions, orders of elimination, quasi-definite and hopeless matrices."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from scipy.sparse import block_array, block_diag, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu, spsolve

from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.refinement import Focus, refined
from crackgrow.direct import fronts as codes
from crackgrow.direct import multifrontal as module
from crackgrow.direct.dissection import LEAF, Places, dissect
from crackgrow.direct.factorization import FEW_CONSTRAINTS, MANY
from crackgrow.direct.fronts import Fronts, fronts_of
from crackgrow.direct.matrix import SymmetricMatrix, symmetric
from crackgrow.direct.multifrontal import Multifrontal
from crackgrow.errors import SolveError
from crackgrow.solid.linear_solver import ConstrainedSystem
from crackgrow.solid.places import places_of_unknowns
from crackgrow.solid.stiffness import stiffness_after
from tests.conftest import Build

Floats = NDArray[np.float64]


REACH = 2


def places_at(nodes: Floats, reach: int = REACH) -> Places:
    """Boxes round nodes of a lattice, which overlap where nodes are at most `reach` apart along both axes."""
    low, high = 2 * nodes - reach, 2 * nodes + reach + 1
    cells = -(-(high.max(axis=0) - low.min(axis=0)) // 2)
    return Places(low, high, low.min(axis=0), low.min(axis=0) + 2 * cells, 2)


def free(matrix: csc_array) -> csr_array:
    """No constraints."""
    return csr_array((0, matrix.shape[0]))


def factorized(matrix: csc_array, nodes: Floats) -> Multifrontal:
    return Multifrontal(symmetric(matrix), fronts_of(places_at(nodes), free(matrix))[0])


def lattice(n: int, seed: int, reach: int = REACH) -> tuple[csc_array, Floats]:
    """A random positive definite matrix of two unknowns per node of an n x n lattice, and their nodes."""
    rng = np.random.default_rng(seed)
    nodes = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=2).reshape(-1, 2)
    places = np.repeat(nodes, 2, axis=0)
    near = np.abs(places[:, None] - places).max(axis=2) <= reach
    dense = np.where(np.triu(near, 1), rng.uniform(-1.0, 1.0, near.shape), 0.0)
    dense += dense.T
    np.fill_diagonal(dense, np.abs(dense).sum(axis=1) + rng.uniform(0.01, 1.0, len(dense)))
    scale = 10.0 ** rng.uniform(-2.0, 2.0, len(dense))
    return csc_array(scale[:, None] * dense * scale), places


@pytest.mark.parametrize("n", [1, 2, 5, 12, 30])
def test_solutions_are_those_of_scipy(n: int) -> None:
    matrix, places = lattice(n, n)
    right = np.random.default_rng(1).normal(size=(len(places), 7))
    factorization = factorized(matrix, places)
    expected = np.column_stack([spsolve(matrix, column) for column in right.T])
    np.testing.assert_allclose(factorization.solve(right), expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(factorization.solve(right[:, 0]), expected[:, 0], rtol=1e-9, atol=1e-9)


def test_one_unknown() -> None:
    factorization = factorized(csc_array([[4.0]]), np.zeros((1, 2), dtype=np.int64))
    np.testing.assert_allclose(factorization.solve(np.array([2.0])), [0.5], rtol=1e-15)


def test_entries_given_in_parts_are_summed() -> None:
    twice = csc_array((np.full(4, 2.0), [0, 0, 1, 1], [0, 2, 4]), shape=(2, 2))
    np.testing.assert_allclose(factorized(twice, np.zeros((2, 2), dtype=np.int64)).solve(np.ones(2)), 0.25, rtol=1e-15)


def test_unknowns_at_one_place_are_not_split() -> None:
    n = 2 * LEAF
    a = np.random.default_rng(2).normal(size=(n, n))
    matrix = csc_array(a @ a.T + np.eye(n))
    nodes = np.zeros((n, 2), dtype=np.int64)
    assert fronts_of(places_at(nodes), free(matrix))[0].n == 1
    x = np.random.default_rng(3).normal(size=n)
    np.testing.assert_allclose(factorized(matrix, nodes).solve(matrix @ x), x, rtol=1e-6, atol=1e-8)


def test_solution_does_not_depend_on_the_numbering() -> None:
    matrix, places = lattice(20, 4)
    x = np.random.default_rng(5).normal(size=len(places))
    right = matrix @ x
    order = np.random.default_rng(6).permutation(len(places))
    shuffled = factorized(csc_array(matrix[order][:, order]), places[order]).solve(right[order])
    straight = factorized(matrix, places).solve(right)
    np.testing.assert_allclose(shuffled, straight[order], rtol=1e-9, atol=1e-12)


def test_places_that_the_couplings_reach_beyond_are_refused() -> None:
    matrix, places = lattice(30, 7)
    wrong = np.random.default_rng(9).permutation(places)
    with pytest.raises(ValueError, match="further apart than couplings reach"):
        factorized(matrix, wrong)


def test_results_are_the_same_twice() -> None:
    matrix, places = lattice(16, 10)
    right = np.random.default_rng(11).normal(size=(len(places), 3))
    first = factorized(matrix, places).solve(right)
    np.testing.assert_array_equal(factorized(matrix, places).solve(right), first)


def test_separate_pieces() -> None:
    """Two lattices in one another, not coupled, and a third one far away."""
    places = lattice(12, 12)[1]
    matrix = csc_array(block_diag([lattice(12, seed)[0] for seed in (12, 13, 14)], format="csc"))
    everywhere = np.concatenate([places, places, places + 40])
    x = np.random.default_rng(15).normal(size=len(everywhere))
    factorization = factorized(matrix, everywhere)
    np.testing.assert_allclose(factorization.solve(matrix @ x), x, rtol=1e-8)


def test_fronts_cover_all_couplings() -> None:
    """Every unknown is eliminated once; a column's later entries lie in its front or in the boundary of that."""
    matrix, places = lattice(42, 16)
    fronts = fronts_of(places_at(places), free(matrix))[0]
    assert fronts.n > 10
    np.testing.assert_array_equal(np.sort(fronts.order), np.arange(len(places)))
    position = np.argsort(fronts.order)
    for k, boundary in enumerate(fronts.boundary):
        start, end = fronts.starts[k : k + 2]
        mine = matrix[:, fronts.order[start:end]]
        later = np.unique(position[mine.indices])
        assert np.isin(later[later >= end], boundary).all()
        if fronts.parent[k] < 0:
            assert not len(boundary)
        else:
            parent = fronts.parent[k]
            inside = np.append(np.arange(*fronts.starts[parent : parent + 2]), fronts.boundary[parent])
            assert parent > k
            assert np.isin(boundary, inside).all()


def boxes_of_many_sizes(seed: int, n: int) -> tuple[Floats, Floats]:
    """Corners of n squares of 1 to 16 units, different ones in different places."""
    rng = np.random.default_rng(seed)
    half, middle = 2 ** rng.integers(0, 4, n), rng.integers(-90, 110, (n, 2))
    return middle - half[:, None], middle + half[:, None]


@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("n", [1, 7, 300, 3000])
def test_parts_of_a_dissection_are_coupled_to_those_above_them_alone(n: int, even: bool) -> None:
    """Boxes overlap boxes of their own part, of parts below it and of parts that it is below."""
    low, high = boxes_of_many_sizes(n, n)
    places = Places(low, high, low.min(axis=0), high.max(axis=0), 4, even)
    tree = dissect(places, low, high, np.full(n, 5))
    np.testing.assert_array_equal(np.sort(tree.order), np.arange(n))
    assert (np.diff(tree.part[tree.order]) >= 0).all()
    assert tree.n > n // 200
    overlap = ((low[:, None] < high) & (low < high[:, None])).all(axis=2)
    first, second = np.nonzero(overlap)
    upper, lower = np.maximum(tree.part[first], tree.part[second]), np.minimum(tree.part[first], tree.part[second])
    assert (tree.begin[upper] <= lower).all()


@pytest.mark.parametrize("seed", range(3))
def test_cells_small_in_some_places_take_less_work_where_lines_cross_few(seed: int) -> None:
    """The work is about n (n + b)^2 for a front that eliminates n unknowns and is coupled to b later ones."""
    tips = np.random.default_rng(seed).uniform(2.0, 14.0, (6, 2))
    lattice = place_lattice(np.zeros(2), np.full(2, 12.0), 1.0, 1.5)
    nodes = refined(lattice, Focus(np.array([shapely.Point(tip) for tip in tips]), np.full(6, 0.125), 2.0)).nodes
    unit = int(nodes.half.min()) // 3
    low, high = ((nodes.places + side * nodes.half[:, None]).repeat(2, axis=0) // unit for side in (-1, 1))
    work = []
    for even in (True, False):
        places = Places(low, high, low.min(axis=0), high.max(axis=0), 2, even)
        fronts, _ = fronts_of(places, csr_array((0, len(low))))
        own, later = np.diff(fronts.starts), np.array([len(boundary) for boundary in fronts.boundary])
        work.append(int(np.sum(own * (own + later) ** 2)))
    assert work[1] < 0.85 * work[0]


@pytest.mark.parametrize("n", [400, 3000])
def test_lines_stay_where_they_are_while_boxes_come_and_go(n: int) -> None:
    """More boxes cut more parts, and leave the others as they are."""
    low, high = boxes_of_many_sizes(n, n)
    first, last = np.array([-110, -110]), np.array([130, 130])
    fewer, all_of_them = (
        dissect(Places(low[some], high[some], first, last, 4), low[some], high[some], np.full(some.sum(), 5))
        for some in ((low < 60).any(axis=1), np.full(n, True))
    )
    corners, more = ({tuple(corner) for corner in tree.low.tolist()} for tree in (fewer, all_of_them))
    assert 5 < len(corners) < len(more)
    assert corners <= more


def test_boxes_of_one_middle_and_two_sizes_are_refused() -> None:
    low, high = np.array([[0, 0], [1, 1]]), np.array([[4, 4], [3, 3]])
    with pytest.raises(ValueError, match="of one size"):
        fronts_of(Places(low, high, low[0], high[0], 1), csr_array((0, 2)))


def test_separators_of_a_lattice_are_as_wide_as_the_couplings_reach() -> None:
    """40 x 40 nodes with two unknowns that reach 2 nodes far: two columns of nodes separate, 160 unknowns."""
    matrix, places = lattice(40, 17)
    fronts = fronts_of(places_at(places), free(matrix))[0]
    assert fronts.starts[-1] - fronts.starts[-2] == 160
    entries = sum(p * (p + len(b)) for p, b in zip(np.diff(fronts.starts).tolist(), fronts.boundary, strict=True))
    assert entries < 0.15 * len(places) ** 2


def constrained(n: int, seed: int) -> tuple[ConstrainedSystem, csc_array, csr_array]:
    """A system held by single unknowns, averages across the lattice and repetitions of both, solved by fronts."""
    matrix, places = lattice(n, seed)
    rng = np.random.default_rng(seed + 1)
    rows = np.zeros((12, len(places)))
    for row in rows[:5]:
        row[rng.integers(len(places))] = 1.0
    for row in rows[5:9]:
        row[rng.integers(len(places), size=10)] = rng.uniform(0.0, 0.1, 10)
    rows[9:] = rows[[0, 5, 5]]
    constraints = csr_array(rows)
    return ConstrainedSystem(matrix, constraints, places_at(places)), matrix, constraints


@pytest.mark.parametrize("k", [1, 3, 30])
def test_constraints_hold_also_where_they_repeat_each_other(k: int) -> None:
    """As many loads as need a solve each for the constraints, and more; agrees with SciPy's SuperLU."""
    system, matrix, constraints = constrained(20, 18)
    scale = np.sqrt(matrix.diagonal())
    loads = scale[:, None] * np.random.default_rng(20).normal(size=(len(scale), k))
    u, m = system.solve(loads)
    some = constraints[:9] + 0.0  # the others repeat these
    bordered = csc_array(block_array([[matrix, some.T], [some, None]]))
    by_lu = splu(bordered).solve(np.concatenate([loads, np.zeros((9, k))]))[: len(loads)]
    size = np.abs(u).max()
    np.testing.assert_allclose(u, by_lu, atol=1e-10 * size)
    np.testing.assert_allclose(constraints @ u, 0.0, atol=1e-13 * size)
    np.testing.assert_allclose(matrix @ u + constraints.T @ m - loads, 0.0, atol=1e-11 * np.abs(loads).max())


@pytest.mark.parametrize("n", [1, 5, 12, 30])
def test_products_of_solutions_need_elimination_alone(n: int) -> None:
    """R' A^-1 R by solutions; columns near each other, far apart, equal and empty; entries given in parts."""
    matrix, places = lattice(n, n)
    rng = np.random.default_rng(40)
    scale = np.sqrt(matrix.diagonal())
    row, column = rng.integers(len(scale), size=90), rng.integers(1, 25, size=90)
    right = csr_array((scale[row] * rng.normal(size=90), (row, column)), shape=(len(scale), 30))
    right = csr_array(np.hstack([right.toarray(), right.toarray()[:, 3:5]]))
    multifrontal = Multifrontal(symmetric(matrix), fronts_of(places_at(places), free(matrix))[0])
    products = multifrontal.products(right)
    expected = right.T @ multifrontal.solve(right.toarray())
    np.testing.assert_array_equal(products, products.T)
    np.testing.assert_allclose(products, expected, atol=1e-13 * np.abs(expected).max())
    parts = csr_array((np.full(2, 0.5), [0, 0], [0, 2, *[2] * (len(scale) - 1)]), shape=(len(scale), 1))
    whole = csr_array(([1.0], ([0], [0])), shape=(len(scale), 1))
    np.testing.assert_array_equal(multifrontal.products(parts), multifrontal.products(whole))


def test_products_never_hold_all_right_hand_sides_at_once(build: type[Build]) -> None:
    """300 loads on one line of a plate: a quarter of the numbers that their solutions are is enough."""
    matrix, fronts = plate(build, 100)
    places = places_of_unknowns(build.block((100, 100), support=2.0).cover)
    middle = places.low + places.high
    loaded = np.flatnonzero(np.abs(middle[:, 1] - middle[:, 1].mean()) <= 2 * places.cell)[:300]
    right = csr_array((np.ones(300), (loaded, np.arange(300))), shape=(len(middle), 300))
    multifrontal = Multifrontal(matrix, fronts)
    tracemalloc.start()
    products = multifrontal.products(right)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * right.shape[0] * right.shape[1] / 4
    some = right[:, [0, 150, 299]]
    np.testing.assert_allclose(products[:, [0, 150, 299]], right.T @ multifrontal.solve(some.toarray()), rtol=1e-9)


@pytest.mark.parametrize("n", [5, 20, 31])
def test_compliance_is_that_of_held_constraints(n: int) -> None:
    """G u under the loads G', where constraints reach far, repeat each other and give way by `YIELDING` at first."""
    system, matrix, _ = constrained(n, 18)
    rng = np.random.default_rng(41)
    rows = np.zeros((20, matrix.shape[0]))
    for row in rows:
        row[rng.integers(len(row), size=6)] = rng.normal(size=6)
    rows *= np.sqrt(matrix.diagonal())
    found = system.compliance(csr_array(rows))
    assert found is not None
    expected = rows @ system.solve(rows.T.copy())[0]
    np.testing.assert_array_equal(found, found.T)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())


def test_compliance_is_left_to_solutions_where_it_is_not_cheap() -> None:
    """With many constraints for few rows."""
    system, matrix, _ = constrained(12, 42)
    rows = csr_array(np.eye(3, matrix.shape[0]))
    assert system.compliance(rows) is not None
    most = MANY * rows.shape[0]
    assert most > FEW_CONSTRAINTS
    many = csr_array(np.eye(most + 1, matrix.shape[0]))
    places = places_at(lattice(12, 42)[1])
    assert ConstrainedSystem(matrix, many, places).compliance(rows) is None
    assert ConstrainedSystem(matrix, many[:most], places).compliance(rows) is not None


def test_prescribed_displacements() -> None:
    system, matrix, constraints = constrained(20, 21)
    u0 = np.random.default_rng(22).normal(size=matrix.shape[0])
    given = constraints @ u0
    u, m = system.solve(np.zeros(len(u0)), given)
    np.testing.assert_allclose(constraints @ u, given, atol=1e-12)
    np.testing.assert_allclose(matrix @ u + constraints.T @ m, 0.0, atol=1e-9 * matrix.diagonal().max())


def test_singular_stiffness_is_held_by_constraints() -> None:
    """A net of springs without ground; what pulls it goes into the one support."""
    n = 30
    matrix, places = lattice(n, 23)
    net = csc_array(-abs(matrix))
    net.setdiag(0.0)
    net.setdiag(-net.sum(axis=1))
    held = csr_array(([1.0], ([0], [0])), shape=(1, len(places)))
    loads = np.random.default_rng(24).normal(size=len(places))
    system = ConstrainedSystem(net, held, places_at(places))
    u, m = system.solve(loads, np.array([3.0]))
    assert u[0] == pytest.approx(3.0, rel=1e-13)
    assert m[0] == pytest.approx(loads.sum(), abs=1e-8 * np.abs(net.data * u[net.indices]).max())


@pytest.mark.parametrize("n", [6, 31])
def test_singular_stiffness_is_held_by_averages_that_reach_across_many_fronts(n: int) -> None:
    """A net of springs without ground, held by its average along two sides, which no front has all unknowns of."""
    matrix, places = lattice(n, 33)
    net = csc_array(-abs(matrix))
    net.setdiag(0.0)
    net.setdiag(-net.sum(axis=1))
    held = csr_array(np.stack([(places[:, axis] == 0) / np.sum(places[:, axis] == 0) for axis in (0, 1)]))
    loads = np.sqrt(net.diagonal()) * np.random.default_rng(34).normal(size=len(places))
    system = ConstrainedSystem(net, held, places_at(places))
    u, m = system.solve(loads, np.array([3.0, 3.5]))
    np.testing.assert_allclose(held @ u, [3.0, 3.5], rtol=1e-12)
    terms = abs(net) @ np.abs(u) + abs(held).T @ np.abs(m) + np.abs(loads)
    assert np.abs(net @ u + held.T @ m - loads).max() <= 1e-12 * terms.max()


@pytest.mark.parametrize("small", [1e-6, 1e-10, 1e-13])
def test_nearly_singular_matrix_leaves_a_small_residual(small: float) -> None:
    """Springs, tied to the ground by a small part of their stiffness."""
    matrix, places = lattice(20, 25)
    net = csc_array(-abs(matrix))
    net.setdiag(0.0)
    net.setdiag(-net.sum(axis=1) * (1.0 + small))
    none = csr_array((0, len(places)))
    x = np.random.default_rng(26).normal(size=len(places))
    loads = net @ x
    u, _ = ConstrainedSystem(net, none, places_at(places)).solve(loads)
    np.testing.assert_allclose(net @ u, loads, atol=1e-12 * (abs(net) @ np.abs(u)).max())


@pytest.mark.parametrize("seed", [0, 1])
def test_unknowns_that_depend_on_each_other_stay_small(seed: int) -> None:
    """As functions on a sliver of rock do: the matrix is semidefinite, and by round-off indefinite."""
    matrix, places = lattice(12, 31)
    n, rng = len(places), np.random.default_rng(seed)
    twins = rng.choice(n, 60, replace=False)
    spread = csc_array(np.hstack([np.eye(n), np.eye(n)[:, twins] * rng.uniform(0.5, 2.0, 60)]))
    semidefinite = csc_array(spread.T @ matrix @ spread)
    x = rng.normal(size=n + 60)
    loads = semidefinite @ x
    system = ConstrainedSystem(semidefinite, free(semidefinite), places_at(np.vstack([places, places[twins]])))
    u, _ = system.solve(loads)
    assert np.abs(u).max() < 2.0 * np.abs(x).max()
    np.testing.assert_allclose(spread @ u, spread @ x, rtol=0.0, atol=1e-8 * np.abs(x).max())
    assert u @ (semidefinite @ u) == pytest.approx(x @ loads, rel=1e-12)


@pytest.mark.parametrize("nodes", [3, 12])
def test_a_pivot_that_is_round_off_is_replaced(nodes: int) -> None:
    """A spring that is 1e-17 of its neighbours, in one front and across many: it gives way no further than they do."""
    matrix, places = lattice(nodes, 50)
    n = len(places)
    twin = csc_array(np.hstack([np.eye(n), np.eye(n)[:, n // 2 :][:, :1]]))
    weak = csc_array(twin.T @ matrix @ twin) + diags_array(np.append(np.zeros(n), 1e-17 * matrix.diagonal()[n // 2]))
    fronts = fronts_of(places_at(np.vstack([places, places[n // 2]])), csr_array((0, n + 1)))[0]
    right = twin.T @ np.ones(n)
    u = Multifrontal(symmetric(csc_array(weak)), fronts).solve(right)
    np.testing.assert_allclose(weak @ u, right, atol=1e-8 * (abs(weak) @ np.abs(u)).max())
    assert np.abs(u).max() < 10.0 * np.abs(spsolve(matrix, np.ones(n))).max()


def test_refinement_takes_away_an_error_of_the_factorization(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solutions that are wrong by 1e-5 end up as good as others, in all blocks of right-hand sides."""
    matrix, places = lattice(12, 29)
    exact = module.Multifrontal.solve
    monkeypatch.setattr(module.Multifrontal, "solve", lambda self, right: exact(self, right) * (1.0 + 1e-5))
    x = np.random.default_rng(30).normal(size=(len(places), 300))
    u, _ = ConstrainedSystem(matrix, csr_array((0, len(places))), places_at(places)).solve(matrix @ x)
    np.testing.assert_allclose(u, x, rtol=1e-8)


def test_body_with_tips_is_solved_by_fronts(build) -> None:
    sample = build.field_of_cracks(3)
    places = places_of_unknowns(sample.cover)
    assert len(places.low) == sample.cover.n_dofs
    matrix = sample.stiffness()
    held = csr_array((np.ones(6), (np.arange(6), [0, 1, 20, 21, 40, 41])), shape=(6, len(places.low)))
    system = ConstrainedSystem(matrix, held, places)
    loads = matrix @ np.random.default_rng(31).normal(size=len(places.low))
    u, m = system.solve(loads)
    np.testing.assert_allclose(matrix @ u + held.T @ m - loads, 0.0, atol=1e-12 * (abs(matrix) @ np.abs(u)).max())
    near = ((places.low < places.high[0]) & (places.high > places.low[0])).all(axis=1)
    together = np.isin(matrix[:, :2].indices, np.flatnonzero(near))
    assert together.all()  # coupled unknowns are near each other: places are where they are said to be


def plate(build: type[Build], n: int) -> tuple[SymmetricMatrix, Fronts]:
    """The stiffness of an n x n block, held to the ground by weak springs, and its fronts."""
    sample = build.block((n, n), support=2.0)
    matrix = stiffness_after(sample.cover, [sample.material], 4).matrix
    grounded = matrix.with_diagonal(np.arange(matrix.shape[0]), np.full(matrix.shape[0], 1e-3))
    return grounded, fronts_of(places_of_unknowns(sample.cover), csr_array((0, matrix.shape[0])))[0]


def test_boxes_that_are_alike_share_their_factors(build: type[Build]) -> None:
    """Of those in a plate of 100 x 100 spacings, most see the rim; the others are of a few kinds."""
    matrix, fronts = plate(build, 100)
    factorization = Multifrontal(matrix, fronts)
    assert factorization.n_fronts == fronts.n > 120
    assert factorization.n_factorized == len(factorization.factors) < 0.65 * fronts.n
    x = np.random.default_rng(35).normal(size=matrix.shape[0])
    np.testing.assert_allclose(factorization.solve(matrix @ x), x, atol=1e-9)


def test_a_local_change_is_factorized_along_one_path_of_fronts(build: type[Build]) -> None:
    """What depends on the changed unknown is its front and those above; all else is taken over, to the last bit."""
    matrix, fronts = plate(build, 60)
    before = Multifrontal(matrix, fronts)
    assert Multifrontal(matrix, fronts, before.kept).n_factorized == 0
    dof = matrix.shape[0] // 3
    front = int(np.searchsorted(fronts.starts, fronts.position[dof], side="right") - 1)
    path = 0
    while front >= 0:
        front, path = int(fronts.parent[front]), path + 1
    changed = matrix.with_diagonal(np.array([dof]), np.array([0.5]))
    after = Multifrontal(changed, fronts, before.kept)
    assert after.n_factorized == path < 0.3 * fronts.n
    x = np.random.default_rng(36).normal(size=matrix.shape[0])
    np.testing.assert_array_equal(after.solve(x), Multifrontal(changed, fronts).solve(x))


def test_all_that_a_front_holds_is_in_its_key(build: type[Build]) -> None:
    """With other elements, entries or constraints a solution is that of a factorization without what was known."""
    matrix = plate(build, 20)[0]
    places, n = places_of_unknowns(build.block((20, 20), support=2.0).cover), matrix.shape[0]
    middle = int(np.argmin(np.abs(places.low + places.high - 24 * places.cell).sum(axis=1)))
    row = csr_array(([1.0], ([0], [middle])), shape=(1, n))
    known = ConstrainedSystem(matrix, row, places).kept
    stiffer = replace(matrix.elements[0], matrix=2.0 * matrix.elements[0].matrix, key=b"stiffer")
    others = (
        (replace(matrix, elements=(stiffer, *matrix.elements[1:])), row, places),
        (replace(matrix, rest=matrix.rest * 1.0000001), row, places),
        (matrix, 2.0 * row, places),
        (matrix, csr_array(([1.0], ([0], [middle + 1])), shape=(1, n)), places),
    )
    loads = matrix @ np.random.default_rng(37).normal(size=n)
    for other in others:
        taken_over, fresh = ConstrainedSystem(*other, known), ConstrainedSystem(*other)
        assert taken_over.kept.factors.keys() == fresh.kept.factors.keys() != known.factors.keys()
        for ours, alone in zip(taken_over.solve(loads), fresh.solve(loads), strict=True):
            np.testing.assert_array_equal(ours, alone)


def test_unknowns_that_codes_do_not_tell_apart_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Factors are known by the codes of their unknowns: those of one must not be those of another."""
    matrix, nodes = lattice(6, 1)
    monkeypatch.setattr(codes, "WITHIN", 2)
    factorized(matrix, nodes)
    monkeypatch.setattr(codes, "WITHIN", 1)
    with pytest.raises(SolveError, match="2 unknowns at one place, at most 1 can be told apart"):
        factorized(matrix, nodes)
    monkeypatch.undo()
    monkeypatch.setattr(codes, "ACROSS", 5)
    with pytest.raises(SolveError, match="21 places along an axis, at most 5"):
        factorized(matrix, nodes)
