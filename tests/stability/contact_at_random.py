"""Contact problems made at random: whether each is solved, or is a limit state that linear programming confirms.

Faces between two half planes have points that lie evenly or graded, alone or as the joints between loose blocks in a
row; other problems have a compliance at random. Friction is 0 to 5, some points are bonded, some dilate, some have
slipped before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools
from crackgrow.contact.coulomb import complementarity_residual
from crackgrow.contact.hold import UNBALANCED, least_unbalanced
from crackgrow.contact.problem import CondensedPoints, ContactProblem
from crackgrow.contact.solve import solve_contact_problem
from crackgrow.errors import NotSolvedError
from tests.contact_problems import Floats

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
        seen = np.where(_seen(friction, cohesion, dilation)[:, None], jump, 0.0)
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


def _seen(friction: Floats, cohesion: Floats, dilation: Floats) -> Bools:
    """Of which gaps and slips (2 n,) something depends on."""
    return np.append(np.ones(len(friction), dtype=bool), (friction > 0.0) | (cohesion > 0.0) | (dilation > 0.0))


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
