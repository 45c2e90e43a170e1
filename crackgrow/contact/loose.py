"""Pieces of rock that contact alone holds, as a contact problem has them: where they lie, and what points see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.problem import ContactProblem, Motions

UNSEEN: Final = 1e-12  # motions that contact points see by less, relative to what they see best, are not seen


def deflated(problem: ContactProblem) -> tuple[ContactProblem, Callable[[Floats], Floats]]:
    """The same problem without what supports do that hold loose pieces to be solved for, and all unknowns of its own.

    Single tractions, and loads, turn such pieces far: of A and of the free jumps all is taken off that is a motion, or
    works on one, and springs as soft as the rock are put in its place. Digits would be lost in what they turn.
    """
    if problem.motions is None:
        return problem, np.array
    B, F, A, m = problem.motions.jump, problem.motions.force, problem.compliance, problem.free.size
    balance = balancing(problem.motions)  # with W the projection is one of symmetric A W^-1
    moving, pushed = balance @ (F @ A), (A @ B) @ balance
    pushed -= B @ (moving @ B @ balance)
    softness = float(np.median(A.diagonal() - (B * moving.T).sum(axis=1) - (pushed * F.T).sum(axis=1)))
    moving -= softness * balance @ F
    free = problem.free - pushed @ problem.motions.pull
    moved = balance @ (F @ free)
    other = replace(problem, compliance=A - np.hstack([B, pushed]) @ np.vstack([moving, F]), free=free - B @ moved)
    return other, lambda x: np.append(x[:m], x[m:] + moving @ x[:m] - moved)


def balancing(motions: Motions) -> Floats:
    """Amplitudes (l, l) of motions whose jumps, as tractions, are a unit of force on each of them; pseudoinverse."""
    return np.asarray(np.linalg.pinv(motions.force @ motions.jump, rcond=UNSEEN, hermitian=True))
