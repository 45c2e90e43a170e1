"""Whether friction leaves the contact of a case one solution: `crackgrow check --unique`.

The given cracks are loaded as in a run. At every load factor the bound of friction is compared, below which there is
exactly one solution (`uniqueness`); beyond it, other starts of the solvers may lead to a second one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Case, LoadHistory, Stages
from crackgrow.contact.coulomb import OPEN, SLIP, STICK, active_set
from crackgrow.contact.solve import OVERLAP, ContactOutcome
from crackgrow.contact.system import ContactSystem
from crackgrow.run.checkpoint import beginning
from crackgrow.run.judging import StepSolution
from crackgrow.run.loading import load, load_history
from crackgrow.run.scene import make_scene
from crackgrow.study.uniqueness import below_friction_limit, friction_limit, other_solutions

WORDS: Final = {OPEN: "is open", STICK: "sticks", SLIP: "slips"}


@dataclass(frozen=True, slots=True, eq=False)
class SecondSolution:
    """Another state that meets the contact law under the same loads and the same memory."""

    limit: float  # friction below which there is certainly none
    points: Ints  # (k,) contact points, those whose jump changes most first
    change: Floats  # (k,) m, how much farther or nearer the faces lie there, or how far along
    states: Ints  # (k,) OPEN, STICK or SLIP


def unique_text(case: Case) -> Iterator[str]:
    """What is known of the solutions of contact at every load factor of a case, in lines. Raises as a run does."""
    scene, cracks = make_scene(case), beginning(case).cracks
    history = isinstance(case.loading, LoadHistory | Stages)
    for solution in load_history(scene, cracks) if history else [load(scene, cracks)]:
        yield f"  at load factor {solution.state.factor:.6g}: {_found(solution)}"


def _found(solution: StepSolution) -> str:
    """What is known of the solutions of a loaded configuration."""
    contact, outcome = solution.contact, solution.outcome
    why = why_not_examined(contact, outcome)
    if why:
        return why
    limit = proven_limit(contact, outcome)
    if limit is None:
        touching = "no faces touch: " if (outcome.state == OPEN).all() else ""
        return f"{touching}there is exactly one solution"
    second = second_solution(contact, outcome)
    beyond = f"it is certain only where friction is below {limit:.2g}"
    if second is None:
        return f"no second solution was found, which is no proof that there is none: {beyond}"
    point = int(second.points[0])
    x, y = solution.cover.lattice.to_metres(solution.faces.nodes.points[[point]])[0]
    place = solution.cover.surfaces[solution.faces.surface[point]].name
    return (
        f"friction leaves more than one solution ({beyond}): in another one the point ({x:.4g}, {y:.4g}) m of "
        f"'{place}', which {WORDS[int(outcome.state[point])]}, {WORDS[int(second.states[0])]}, its faces moved by "
        f"{second.change[0]:.2g} m; apply the loads in steps (loading.history), or lower the friction there"
    )


def why_not_examined(contact: ContactSystem, outcome: ContactOutcome) -> str:
    """Why nothing is to be examined, or nothing can be; empty otherwise.

    The bound takes supports that hold all of the rock, and a symmetric compliance, which dilation has not.
    """
    if outcome.problem is None:
        return "no faces touch: there is exactly one solution"
    if outcome.problem.motions is not None:
        return "not known: contact alone holds a piece of rock, which is not examined"
    if contact.law.dilation is not None:
        return "not known: faces that dilate are not examined"
    return "" if outcome.problem.friction.any() else "there is no friction: there is exactly one solution"


def proven_limit(contact: ContactSystem, outcome: ContactOutcome) -> float | None:
    """The friction below which there is certainly one solution; None where all of it is below."""
    problem, weights = outcome.problem, contact.weights[outcome.rows]
    assert problem is not None
    largest = float(problem.friction.max())
    if below_friction_limit(largest, problem.compliance, weights):
        return None
    limit = friction_limit(problem.compliance, weights)
    return None if largest < limit else limit


def second_solution(contact: ContactSystem, outcome: ContactOutcome) -> SecondSolution | None:
    """A second solution, if there is one and some start leads to it; None below the limit at the cost of the bound."""
    if why_not_examined(contact, outcome):
        return None
    limit, problem, rows = proven_limit(contact, outcome), outcome.problem, outcome.rows
    if limit is None or problem is None:
        return None
    known = np.concatenate([outcome.normal_traction[rows], outcome.tangential_traction[rows]])
    for p in other_solutions(problem, known):
        states = active_set(problem, p, problem.jump(p)).states()
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
    rows, n = outcome.rows, len(contact.weights)
    gap = outcome.gap - outcome.dilation - contact.rock[:n, np.concatenate([rows, n + rows])] @ change
    gap[rows] = 0.0
    return bool(gap.min() < -OVERLAP * np.abs(gap).max())
