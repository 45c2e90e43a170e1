"""The equations of one active set of the contact problem, solved for the tractions and motions that it leaves unknown.

Where contact alone holds pieces of rock the balance of the tractions and the loads on them, F p = pull, is among these.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import ActiveSet, Branches
from crackgrow.contact.problem import ContactProblem

SINGULAR: Final = 1e-14
"""Reciprocal condition from which equations with motions have no digits: nothing that is closed sees some of them."""

LEAST_SQUARES: Final = 1e-12
"""Part of the largest singular value below which the others count as zero then."""


def solve_active(problem: ContactProblem, active: ActiveSet) -> Floats:
    """Unknowns (2 n + l,) of the problem with the equations of one active set.

    A singular system (rigid contact, more points than the displacement can follow) gets its least-squares solution.
    """
    K, right, unknowns = _equations(problem, active)
    singular = 0.0 if problem.motions is None else SINGULAR
    x = _by_lu(K, right, singular)
    if x is None:
        x = np.asarray(np.linalg.lstsq(K, right, rcond=LEAST_SQUARES if singular else None)[0])
    return unknowns(x)


def towards(
    problem: ContactProblem, begin: ContactProblem, left: float, active: ActiveSet, x: Floats
) -> tuple[Floats, Floats, float]:
    """The tractions x (2 n,) of an active set to the last digit, the way that they go, and how `left` changes on it.

    Free jumps are those of the problem and a share `left` of what they lack of those at the `begin`. Where points share
    a traction in any way tractions change alone.
    """
    K, right, unknowns = _equations(problem, active)
    other = _equations(begin, active)[1] - right
    both = _by_lu(K, np.column_stack([right, other]), SINGULAR)
    if both is not None:
        end, x = unknowns(both[:, 0]), unknowns(both[:, 0] + left * both[:, 1])
        return x, end - x, -left
    size = float(np.abs(K).max(initial=0.0)) / (float(np.abs(other).max(initial=0.0)) or 1.0)
    way = np.linalg.svd(np.column_stack([K, -size * other]))[2][-1]
    return x, unknowns(way[:-1]) - unknowns(np.zeros(len(right))), size * float(way[-1])


def _equations(problem: ContactProblem, active: ActiveSet) -> tuple[Floats, Floats, Callable[[Floats], Floats]]:
    """Matrix (k + l, k + l) and right side (k + l,) of unknown tractions and motions, and all unknowns of them."""
    branches, motions = Branches(problem, active), problem.motions
    K, right = branches.matrix(), branches.right()
    if motions is None:
        return K, right, branches.tractions
    k, n_motions, given = len(right), len(motions.pull), branches.known()
    size, pull = float(problem.scale.mean()), float(np.abs(motions.force).max()) or 1.0
    balance = branches.per_unknown(motions.force) / pull
    K = np.block([[K / size, -branches.of_motions(motions.jump)], [balance, np.zeros((n_motions, n_motions))]])
    right = np.append(right, (motions.pull - motions.force @ given) * (size / pull))
    return K, right, lambda x: np.concatenate([branches.tractions(x[:k] / size), x[k:]])


def _by_lu(K: Floats, right: Floats, singular: float) -> Floats | None:
    """Solution (k,) of K x = `right`; None where K is singular, or worse conditioned than that."""
    if not right.size:
        return right
    lu, pivots, info = dgetrf(K.T)  # LAPACK wants columns: the rows of K are those of its transpose
    if info or (singular and dgecon(lu, np.abs(K).sum(axis=1).max(), norm="1")[0] <= singular):
        return None
    x = np.asarray(dgetrs(lu, pivots, right, trans=1)[0])
    if singular:  # supports carry what the balance of pieces misses: all digits count
        x += dgetrs(lu, pivots, right - K @ x, trans=1)[0]
    return x if np.isfinite(x).all() else None
