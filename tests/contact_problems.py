"""Contact problems that several tests solve, all of them made up, and such as are made at random.

Of those each is solved, or is a limit state that linear programming confirms. Faces between two half planes have points
that lie evenly or graded, alone or as the joints between loose blocks in a row; other problems have a compliance at
random. Friction is 0 to 5, some points are bonded, some dilate, some have slipped before.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import ActiveSet, ContactLaw, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.hold import UNBALANCED, least_unbalanced
from crackgrow.contact.points import CondensedPoints
from crackgrow.contact.problem import ContactProblem
from crackgrow.contact.solve import solve_contact_problem
from crackgrow.contact.system import ContactSystem
from crackgrow.errors import NotSolvedError
from tests.conftest import dense_system


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


EXACT = 1e-9
"""Complementarity residual of a solution."""


@dataclass(frozen=True)
class Drawn:
    """A problem, what it is called, and the lengths (n,) m of its points."""

    kind: str
    problem: ContactProblem
    weights: Floats


def drawn(seed: int) -> Drawn:
    """The problem of a seed."""
    rng = np.random.default_rng(seed)
    n, graded, kind = int(rng.integers(1, 61)), bool(rng.random() < 0.5), str(rng.choice(["faces", "blocks", "random"]))
    n_blocks = int(rng.integers(1, 5))
    if kind == "blocks":
        n = max(n, 3 * n_blocks)
    weights = rng.permutation(np.geomspace(1e-3, 1.0, n)) if graded else np.ones(n)
    if graded and rng.random() < 0.5:
        weights = np.sort(weights)
    weights = 2.0 * weights / weights.sum()
    S = _spread(rng, n) if kind == "random" else _half_planes(weights)
    A = _coupled(rng, S, rng.uniform(0.0, 0.9)) * np.tile(weights, 2)
    if rng.random() < 0.5:  # joints are elastic
        A += np.diag(np.tile(A.diagonal()[:n].mean() * 10.0 ** rng.uniform(-6.0, 0.5), 2 * n))
    tractions = np.concatenate([_waves(rng, n) - rng.uniform(0.0, 2.0), _waves(rng, n) + rng.normal()])
    friction, cohesion, dilation = np.full(n, rng.choice([0.0, 1.0]) * rng.uniform(0.0, 5.0)), np.zeros(n), np.zeros(n)
    if rng.random() < 0.3:
        friction = rng.uniform(0.0, 5.0, n)
    if rng.random() < 0.4:
        cohesion = np.where(rng.random(n) < rng.random(), rng.uniform(0.0, 2.0, n), 0.0)
    slipped = rng.normal(size=n) * (A @ tractions).std() if rng.random() < 0.3 else np.zeros(n)
    if rng.random() < 0.3:
        dilation = np.minimum(friction, rng.uniform(0.0, 0.3, n))
    motions, pull = (np.zeros((0, 0)), np.zeros((0, 0))), np.zeros(0)
    if kind == "blocks":
        jump = _block_motions(weights, n_blocks)
        carried = np.concatenate([np.minimum(tractions[:n], 0.0) - 0.1, np.zeros(n)])
        share = rng.uniform(0.0, 1.3) * (friction * -carried[:n] + cohesion)
        carried[n:] = np.clip(tractions[n:], -share, share)
        pull = (jump * np.tile(weights, 2)[:, None]).T @ carried
        seen_along = (friction > 0.0) | (cohesion > 0.0) | (dilation > 0.0)  # else nothing depends on the slip
        seen = np.where(np.append(np.ones(n, dtype=bool), seen_along)[:, None], jump, 0.0)
        motions = seen, (seen * np.tile(weights, 2)[:, None]).T
        if rng.random() < 0.5:  # supports let them turn far
            A = A + 10.0 ** rng.uniform(0.0, 3.0) * jump @ motions[1]
        if rng.random() < 0.3:  # nothing presses them, or pulls at them
            pull = np.zeros(len(pull))
    problem = ContactProblem(CondensedPoints(A, *motions), A @ tractions, friction, cohesion, dilation, slipped, pull)
    name = f"{kind}{', graded' if graded else ''}"
    return Drawn(name, problem, weights)


def _half_planes(weights: Floats) -> Floats:
    """Normal jumps (n, n) per force between half planes: the logarithm, of cells of constant traction."""
    x = np.cumsum(weights) - 0.5 * weights
    distance = np.abs(x[:, None] - x)
    np.fill_diagonal(distance, 0.5 * np.exp(-1.0) * weights)
    values, vectors = np.linalg.eigh(np.log(8.0 / distance))
    return np.asarray((vectors * np.maximum(values, 1e-4 * values.max())) @ vectors.T)


def _spread(rng: np.random.Generator, n: int) -> Floats:
    half = rng.normal(size=(n, n))
    return np.asarray(half @ half.T / n + 10.0 ** rng.uniform(-3.0, 0.0) * np.eye(n))


def _coupled(rng: np.random.Generator, S: Floats, coupling: float) -> Floats:
    """Gap and slip (2 n, 2 n) per force, positive definite: the normal part of one on the tangential part of others."""
    values, vectors = np.linalg.eigh(S)
    half = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    Q = rng.normal(size=S.shape)
    C = half @ (Q * (coupling / np.linalg.norm(Q, 2))) @ half
    return np.block([[S, C], [C.T, S]])


def _waves(rng: np.random.Generator, n: int) -> Floats:
    x = np.linspace(0.0, 1.0, n)
    return (
        np.asarray(rng.normal(size=6) @ np.cos(np.pi * np.arange(6)[:, None] * x + rng.uniform(0.0, 6.0, (6, 1)))) / 2.0
    )


def _block_motions(weights: Floats, n_blocks: int) -> Floats:
    """Gaps and slips (2 n, 3 k) as blocks in a row on the face move up and along it, and turn."""
    n, x = len(weights), np.cumsum(weights) - 0.5 * weights
    jump = np.zeros((2 * n, 3 * n_blocks))
    for block, some in enumerate(np.array_split(np.arange(n), n_blocks)):
        jump[some, 3 * block] = jump[n + some, 3 * block + 1] = 1.0
        jump[some, 3 * block + 2] = x[some] - x[some].mean()
    return jump


def held(drawn: Drawn) -> bool:
    """Whether limit analysis finds tractions that hold all pieces."""
    problem = drawn.problem
    if not problem.n_motions:
        return True
    size, length = float(np.abs(problem.pull).sum()), float(drawn.weights.sum())
    strength = problem.friction, problem.cohesion, np.zeros(problem.n_points)
    return least_unbalanced((problem.points.force, problem.pull), size, length, *strength)[0] <= UNBALANCED


def ended(drawn: Drawn) -> tuple[str, int]:
    """How it ended: solved, no state and none possible, not solved; and the iterations."""
    try:
        found = solve_contact_problem(drawn.problem, "newton")
    except NotSolvedError:
        return ("not solved" if held(drawn) else "limit state"), 0
    if complementarity_residual(drawn.problem, found.unknowns) > EXACT:
        return "wrong", found.iterations
    return "solved", found.iterations
