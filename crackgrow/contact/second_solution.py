"""A second solution of a step's contact, where friction is beyond the range in which there is only one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.condensation import Rock
from crackgrow.contact.coulomb import STICK, active_set, jump
from crackgrow.contact.solve import OVERLAP, ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.contact.uniqueness import below_friction_limit, friction_limit, other_solutions


@dataclass(frozen=True, slots=True, eq=False)
class SecondSolution:
    """Another state that meets the contact law under the same loads and the same memory."""

    limit: float  # friction below which there is certainly none
    points: Ints  # (k,) contact points, those whose jump changes most first
    change: Floats  # (k,) m, how much farther or nearer the faces lie there, or how far along
    states: Ints  # (k,) OPEN, STICK or SLIP


def second_solution(contact: ContactSystem, outcome: ContactOutcome) -> SecondSolution | None:
    """A second solution, if there is one and some start leads to it; None below the limit at the cost of the bound.

    Pieces that contact alone holds are not examined: the bound takes supports that hold all of the rock. Nor is
    dilation, with which the compliance is not symmetric.
    """
    problem, rows = outcome.problem, outcome.rows
    if problem is None or problem.friction is None or not problem.friction.any():
        return None
    if problem.motions is not None or contact.law.dilation is not None:
        return None
    largest, weights = float(problem.friction.max()), contact.weights[rows]
    if below_friction_limit(largest, problem.compliance, weights):
        return None
    limit = friction_limit(problem.compliance, weights)
    if largest < limit:
        return None
    known = np.concatenate([outcome.normal_traction[rows], outcome.tangential_traction[rows]])
    for p in other_solutions(problem, known):
        states = active_set(problem, p, jump(problem, p)).states()
        whole = contact.law.breakable[rows] & ~outcome.memory.broken[rows]
        breaks = bool((whole & (states != STICK)).any())  # then it is one of another law, with lost cohesion
        if not breaks and not _closes_others(contact, outcome, p - known):
            moved = problem.compliance @ (p - known)
            change = np.hypot(*moved.reshape(2, -1))
            order = np.argsort(-change, kind="stable")
            return SecondSolution(limit, rows[order], change[order], states[order])
    return None


def _closes_others(contact: ContactSystem, outcome: ContactOutcome, change: Floats) -> bool:
    """Whether a change (2 k,) Pa of the tractions lets points overlap that the solver did not have to deal with."""
    rows = outcome.rows
    known = Rock(outcome.u, outcome.multipliers, outcome.gap, outcome.slip)
    gap = contact.onto(rows, rows).jumps(known, change)[0] - outcome.dilation
    gap[rows] = 0.0
    return bool(gap.min() < -OVERLAP * np.abs(gap).max())
