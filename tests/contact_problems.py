"""Contact problems that several tests solve, all of them made up."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.contact.coulomb import ActiveSet, ContactLaw, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.problem import CondensedPoints, ContactProblem
from crackgrow.contact.system import ContactSystem
from tests.symmetric_matrices import dense_system

Floats = NDArray[np.float64]


def contact_law(friction: Floats, cohesion: Floats, compliance: Floats, **more: Any) -> ContactLaw:
    """A law (n,) by point; what is left out, or None, does nothing: slip breaks cohesion, and no more."""
    zeros = np.zeros(len(friction))
    usual = {"shear_compliance": compliance, "residual_friction": friction, "kept": zeros, "dilation": zeros}
    usual |= {"weakening": zeros, "tension": zeros}
    usual |= {name: value for name, value in more.items() if value is not None}
    rows = (
        (zeros, np.ones(len(friction))),
        (friction, usual["residual_friction"]),
        (cohesion, np.where(usual["kept"], cohesion, 0.0)),
        (usual["tension"], zeros),
        (usual["dilation"],) * 2,
    )
    along, weakening = usual["shear_compliance"], usual["weakening"]
    linear = zeros + np.inf, zeros, zeros + 1.0
    return ContactLaw(compliance, along, weakening, zeros > 0.0, *(np.stack(row) for row in rows), *linear)


def crack_problem(n: int, friction: float, cohesion: float, ratio: float, coupling: float, seed: int) -> ContactProblem:
    """Straight crack on (-1, 1) in an infinite plane: exact opening kernel, constant pressure per cell.

    The normal and tangential rows are coupled by a random block that leaves the whole positive definite (coupling
    below one); the diagonal carries an elastic compliance `ratio` times smaller than that of the solid, none for
    infinity.
    """
    rng = np.random.default_rng(seed)
    x = (2.0 * np.arange(n) + 1.0) / n - 1.0
    distance = np.abs(x[:, None] - x)
    np.fill_diagonal(distance, np.exp(-1.0) / n)  # mean of the logarithm over one cell
    root = np.sqrt(np.outer(1.0 - x**2, 1.0 - x**2))
    K = 2.0 / n * np.log((1.0 - np.outer(x, x) + root) / distance)
    values, vectors = np.linalg.eigh(K)
    half = vectors * np.sqrt(values) @ vectors.T
    Q = rng.normal(size=(n, n))
    C = half @ (Q * (coupling / np.linalg.norm(Q, 2))) @ half
    A = np.block([[K, C], [C.T, K]]) + np.diag(np.tile(K.diagonal() / ratio, 2))
    waves = np.cos(np.pi * np.arange(1, 9)[:, None] * x + rng.uniform(0.0, 6.0, (8, 1)))
    free = np.concatenate([K @ (rng.normal(size=8) @ waves - 1.0), K @ (rng.normal(size=8) @ waves + 0.5)])
    return ContactProblem(CondensedPoints(A), free, np.full(n, friction), np.full(n, cohesion))


def random_problem(n: int, friction: float, seed: int) -> ContactProblem:
    """Random positive definite compliance with a column scaling, as quadrature weights make it: not symmetric."""
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(2 * n, 2 * n))
    coupling = np.block([[np.ones((n, n)), np.full((n, n), 0.2)], [np.full((n, n), 0.2), np.ones((n, n))]])
    weight = rng.uniform(0.5, 2.0, n)
    A = ((B @ B.T / (2 * n)) * coupling + np.eye(2 * n)) * np.tile(weight, 2)
    return ContactProblem(
        CondensedPoints(A), rng.normal(size=2 * n) - 0.3, np.full(n, friction), rng.uniform(0.0, 0.3, n)
    )


def dilating(problem: ContactProblem, seed: int) -> ContactProblem:
    """The problem with faces that dilate, some of which have slipped before, one way or the other."""
    rng, n = np.random.default_rng(seed), problem.n_points
    slipped = 0.4 * rng.normal(size=n) * (rng.random(n) < 0.7)
    return replace(problem, dilation=np.full(n, 0.3), slipped=slipped)


def every_solution(problem: ContactProblem) -> list[Floats]:
    """All solutions, by trying every branch of every point."""
    n, found = problem.n_points, []
    for branches in itertools.product(((False, 1), (True, 0), (True, 1), (True, -1)), repeat=n):
        closed, slip = zip(*branches, strict=True)
        p = solve_active(problem, ActiveSet(np.array(closed), np.array(slip), np.array(slip)))
        new = all(np.abs(p - q).max() > 1e-6 * np.abs(p).max() for q in found)
        if new and complementarity_residual(problem, p) < 1e-9:
            found.append(p)
    return found


def spread_problem(n: int, friction: Floats | float, seed: int, cohesion: Floats | float = 0.0) -> ContactProblem:
    """Gap and slip coupled at random, as strongly as no rock couples them."""
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(2 * n, 2 * n + 1))
    free = rng.normal(size=2 * n) - 0.5 * np.repeat([1.0, 0.0], n)
    return ContactProblem(
        CondensedPoints(B @ B.T / (2 * n)), free, np.broadcast_to(friction, n), np.broadcast_to(cohesion, n)
    )


def rock_of(stiffness: Floats, law: ContactLaw, solver: str = "newton", weights: Floats | None = None) -> ContactSystem:
    """Contact points whose gaps, then slips, are the displacements of rock of this stiffness (2 n, 2 n) Pa/m."""
    n = len(law.compliance)
    system = dense_system(stiffness, csr_array((0, 2 * n)))
    gap_of, slip_of = csr_array(np.eye(2 * n)[:n]), csr_array(np.eye(2 * n)[n:])
    return ContactSystem(system, gap_of, slip_of, np.ones(n) if weights is None else weights, law, solver)
