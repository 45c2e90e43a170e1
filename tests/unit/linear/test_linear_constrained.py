"""The constrained solve: exact constraints, repeated and contradicting ones, singular systems."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array, diags_array

from crackgrow.case.model import PointSupport
from crackgrow.errors import SolveError
from crackgrow.linear import ConstrainedSystem, symmetric
from crackgrow.linear.factorization import Factorization

N = 30


def chain() -> csc_array:
    """Springs in a row, free at both ends: singular."""
    matrix = diags_array([-np.ones(N - 1), 2 * np.ones(N), -np.ones(N - 1)], offsets=[-1, 0, 1]).tolil()
    matrix[0, 0] = matrix[N - 1, N - 1] = 1.0
    return csc_array(matrix)


def rows(*entries: dict[int, float]) -> csr_array:
    matrix = np.zeros((len(entries), N))
    for row, entry in zip(matrix, entries, strict=True):
        row[list(entry)] = list(entry.values())
    return csr_array(matrix)


def definite(seed: int) -> csc_array:
    a = np.random.default_rng(seed).normal(size=(N, N))
    return csc_array(a @ a.T + np.eye(N))


def test_factorization_solves_badly_scaled_matrices() -> None:
    scale = np.logspace(-6, 6, N)
    matrix = csc_array(scale[:, None] * definite(40).toarray() * scale)
    x = np.random.default_rng(41).normal(size=(N, 3)) / scale[:, None]
    u, _ = Factorization(symmetric(matrix), csr_array((0, N))).solve(matrix @ x, np.zeros((0, 3)))
    np.testing.assert_allclose(u, x, rtol=1e-8)


def test_constrained_solution_satisfies_both_equations() -> None:
    stiffness, constraints = definite(42), rows({0: 1.0}, {4: 0.5, 5: 0.5}, {N - 1: 1.0, 0: 2.0})
    rng = np.random.default_rng(43)
    loads, given = rng.normal(size=N), rng.normal(size=3)
    u, m = ConstrainedSystem(stiffness, constraints).solve(loads, given)
    np.testing.assert_allclose(constraints @ u, given, atol=1e-12)
    np.testing.assert_allclose(stiffness @ u + constraints.T @ m, loads, atol=1e-11)


def test_answer_does_not_depend_on_the_scale_of_a_constraint() -> None:
    """The penalty that holds a singular matrix changes by a factor of 1e6: u does not, the multiplier scales back."""
    stiffness, constraints = definite(44), rows({0: 1.0}, {7: 1.0})
    loads = np.ones(N)
    given = np.array([0.3, -0.2])
    scale = np.array([1.0, 1e3])
    u, m = ConstrainedSystem(stiffness, constraints).solve(loads, given)
    scaled_u, scaled_m = ConstrainedSystem(stiffness, csr_array(diags_array(scale) @ constraints)).solve(
        loads, scale * given
    )
    np.testing.assert_allclose(scaled_u, u, atol=1e-11)
    np.testing.assert_allclose(scale * scaled_m, m, atol=1e-9)


def test_singular_stiffness_is_held_by_constraints() -> None:
    """A chain pulled at its end: displacement grows by one per spring; the support carries the pull."""
    loads = np.zeros(N)
    loads[-1] = 1.0
    u, m = ConstrainedSystem(chain(), rows({0: 1.0})).solve(loads, np.array([5.0]))
    np.testing.assert_allclose(u, 5.0 + np.arange(N), rtol=1e-12)
    np.testing.assert_allclose(m, [1.0], rtol=1e-11)


@pytest.mark.parametrize("n_constraints", [3, 20])
def test_bits_of_a_solution_do_not_depend_on_what_was_solved_for_before(n_constraints: int) -> None:
    """Few constraints and many: responses to all of them pay where they are few, or fewer than the loads."""
    constraints = rows(*({k: 1.0, k + 1: 0.3} for k in range(n_constraints)))
    rng = np.random.default_rng(47)
    loads, many = rng.normal(size=N), rng.normal(size=(N, N))
    system = ConstrainedSystem(definite(48), constraints)
    alone = system.solve(loads)
    system.solve(many)
    for after, before in zip(system.solve(loads), alone, strict=True):
        np.testing.assert_array_equal(after, before)


def test_repeated_constraints_that_agree_are_fine() -> None:
    constraints = rows({0: 1.0}, {0: 1.0}, {0: 2.0, 3: 1.0}, {3: 1.0})
    loads = np.zeros(N)
    loads[-1] = 1.0
    given = np.array([0.5, 0.5, 1.0 + 3.0, 3.0])
    u, m = ConstrainedSystem(chain(), constraints).solve(loads, given)
    np.testing.assert_allclose(constraints @ u, given, atol=1e-10)
    np.testing.assert_allclose(chain() @ u + constraints.T @ m, loads, atol=1e-10)


def dependent(seed: int) -> csr_array:
    """Three constraints, and a fourth that is the sum of two."""
    own = np.random.default_rng(seed).normal(size=(3, N))
    return csr_array(np.vstack([own, own[0] + own[1]]))


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e9])
@pytest.mark.parametrize("load", [0.0, 1.0, 1e12])
def test_constraints_that_contradict_are_refused_whatever_acts_besides(load: float, scale: float) -> None:
    """The size of loads, and what they displace, does not hide it."""
    system = ConstrainedSystem(definite(45), dependent(7))
    with pytest.raises(SolveError, match="contradict each other"):
        system.solve(np.full(N, load * scale), scale * np.array([1.0, 2.0, 0.0, 3.0 + 1e-5]))
    u, _ = system.solve(np.full(N, load * scale), scale * np.array([1.0, 2.0, 0.0, 3.0]))
    assert np.isfinite(u).all()


def test_a_contradiction_is_not_hidden_by_what_other_constraints_prescribe() -> None:
    """One unknown is given two values, and another one a far larger value."""
    constraints = csr_array(np.eye(N)[[0, 0, 3]])
    with pytest.raises(SolveError, match="contradict each other"):
        ConstrainedSystem(definite(45), constraints).solve(np.zeros(N), np.array([1.0, 2.0, 1e7]))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("given", [0.0, 1e-12])
def test_constraints_that_take_all_loads_do_not_contradict(given: float, seed: int) -> None:
    """Rock at rest on rollers: what is left of displacements is round-off of the loads, not of itself."""
    constraints = dependent(seed)
    loads = constraints.T @ (1e7 * np.random.default_rng(seed).normal(size=4))
    u, _ = ConstrainedSystem(definite(45), constraints).solve(loads, given * np.array([1.0, 2.0, 0.0, 3.0]))
    assert np.abs(u).max() < 1e-7


@pytest.mark.parametrize("size", [0.0, 5e-324, 1e-310, 1e-290])
def test_loads_may_be_as_small_as_numbers_are(size: float) -> None:
    """Springs that give way leave such loads behind where nothing acts on the rock."""
    u, m = ConstrainedSystem(definite(42), rows({0: 1.0})).solve(np.full(N, size))
    assert np.abs(u).max() <= 100.0 * size
    assert np.isfinite(m).all()


def test_several_loads_at_once_are_solved_column_by_column() -> None:
    system = ConstrainedSystem(definite(45), rows({0: 1.0}, {9: 1.0}))
    loads = np.random.default_rng(46).normal(size=(N, 4))
    together, multipliers = system.solve(loads)
    for k in range(4):
        u, m = system.solve(loads[:, k])
        np.testing.assert_allclose(together[:, k], u, atol=1e-13)
        np.testing.assert_allclose(multipliers[:, k], m, atol=1e-12)


@pytest.mark.parametrize("own", [False, True])
def test_several_loads_at_once_take_prescribed_values(own: bool) -> None:
    """The same for all of them, or their own."""
    system = ConstrainedSystem(definite(45), rows({0: 1.0}, {9: 1.0}))
    loads, given = np.random.default_rng(46).normal(size=(N, 4)), np.random.default_rng(47).normal(size=(2, 4))
    together, multipliers = system.solve(loads, given if own else given[:, 0])
    for k in range(4):
        u, m = system.solve(loads[:, k], given[:, k if own else 0])
        np.testing.assert_allclose(together[:, k], u, atol=1e-13)
        np.testing.assert_allclose(multipliers[:, k], m, atol=1e-12)
    contradicting = ConstrainedSystem(definite(45), rows({0: 1.0}, {0: 1.0}))
    with pytest.raises(SolveError, match="contradict each other by"):
        contradicting.solve(loads, np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 2.0]]))


def test_refinement_that_is_not_needed_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The residual of a well-conditioned matrix is round-off at once; that of a rough factorization is not."""
    exact, error, n_solves = Factorization.solve, 0.0, 0

    def counted(self: Factorization, *right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        nonlocal n_solves
        n_solves += 1
        u, multipliers = exact(self, *right)
        return (1.0 + error) * u, multipliers

    monkeypatch.setattr(Factorization, "solve", counted)
    loads = np.random.default_rng(49).normal(size=N)
    system = ConstrainedSystem(definite(47), csr_array((0, N)))
    u, _ = system.solve(loads)
    assert n_solves == 1
    error = 1e-5
    rough, _ = system.solve(loads)
    assert n_solves > 3
    np.testing.assert_allclose(rough, u, atol=1e-12 * np.abs(u).max())


def test_solving_does_not_change_the_system() -> None:
    system = ConstrainedSystem(definite(47), rows({0: 1.0}))
    a, b = np.random.default_rng(48).normal(size=(2, N))
    first = system.solve(a, np.ones(1))[0]
    system.solve(b)
    np.testing.assert_array_equal(system.solve(a, np.ones(1))[0], first)


def test_a_free_body_stays_where_it_is_if_nothing_pushes_it() -> None:
    """Springs between pairs of unknowns: what stretches them is found, where they lie is not arbitrary."""
    disconnected = csc_array(np.kron(np.eye(N // 2), [[1.0, -1.0], [-1.0, 1.0]]))
    loads = np.tile([1.0, -1.0], N // 2)
    u, _ = ConstrainedSystem(disconnected, csr_array((0, N))).solve(loads)
    np.testing.assert_allclose(disconnected @ u, loads, atol=1e-9)
    assert np.abs(u).max() < 2.0


def test_unknown_without_stiffness_is_refused() -> None:
    matrix = np.eye(N)
    matrix[3, 3] = 0.0
    with pytest.raises(SolveError, match="1 of 30 unknowns have no stiffness"):
        Factorization(symmetric(csc_array(matrix)), csr_array((0, N)))


def test_entries_that_are_not_finite_are_refused() -> None:
    matrix = np.eye(N)
    matrix[3, 3] = np.nan
    with pytest.raises(SolveError, match="not finite"):
        Factorization(symmetric(csc_array(matrix)), csr_array((0, N)))


HALVES = [(0.5, 2.3), (6.5, 3.6)]


@pytest.mark.parametrize(
    ("cracks", "held"),
    [
        ([], []),
        ([], [((0.5, 0.5), (0.0, 0.0))]),
        ([], [((0.5, 0.5), (None, 0.0)), ((6.5, 0.5), (None, 0.0))]),
        ([(HALVES, (False, False))], [((0.5, 0.5), (0.0, 0.0)), ((6.5, 0.5), (None, 0.0))]),
    ],
    ids=["free", "free to turn", "free to slide", "upper half free"],
)
def test_body_that_is_free_to_move_is_refused(build, cracks: list, held: list) -> None:
    sample = build.block((6, 5), [build.crack(points, tips) for points, tips in cracks])
    supports = [PointSupport("rock", np.array(point), displacement) for point, displacement in held]
    with pytest.raises(SolveError, match="free to move"):
        sample.solve(supports, {"top": (0.1, 1.0), "right": (0.3, 0.0)})
