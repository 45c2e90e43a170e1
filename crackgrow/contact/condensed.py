"""The contact problem condensed onto some of the contact points, and its solution by one solver or the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import ContactProblem, ContactSolution, complementarity_residual
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.system import ContactSystem
from crackgrow.contact.uniqueness import friction_limit
from crackgrow.errors import NotSolvedError

UNSYMMETRIC = 1e-2
"""A compliance of contact that is unsymmetric by more than this fraction of its largest entry is refused."""


def condensed(contact: ContactSystem, rock: Floats, rows: Ints, sliding: Ints) -> Floats:
    """The compliance A (k + l, k + l) of the points `rows` (k,), with tangential rows of the points `sliding` (l,).

    `rock` is that of the rock between these rows, per unit traction; elastic contact adds its own. Raises
    NotSolvedError where round-off has spoilt that of the rock.
    """
    law = contact.law
    _check_reciprocal(rock, np.concatenate([contact.weights[rows], contact.weights[sliding]]))
    compliance = rock.copy()
    compliance[np.diag_indices_from(compliance)] += np.concatenate([law.compliance[rows], law.compliance[sliding]])
    return compliance


def _check_reciprocal(compliance: Floats, weights: Floats) -> None:
    """Raise NotSolvedError unless the compliance S W (k, k) of rock comes from a symmetric S that resists (Betti)."""
    symmetric = compliance / weights
    least, largest = float(symmetric.diagonal().min()), float(np.abs(symmetric).max())
    off = float(np.abs(symmetric - symmetric.T).max())
    if least <= 0.0 or off > UNSYMMETRIC * largest:
        raise spoilt("not positive" if least <= 0.0 else f"unsymmetric by {off / largest:.1g} of its largest entry")


def spoilt(what: str) -> NotSolvedError:
    """The error where the compliance of the rock is `what`."""
    return NotSolvedError(
        f"the system is ill conditioned: the compliance of the rock between contact points is {what}; a sliver of rock "
        "or a crack's tip may lie too close to a lattice line: change numerics.spacing or the crack a little"
    )


def solved(
    problem: ContactProblem,
    weights: Floats,
    solver: Literal["newton", "lemke"],
    start: Floats | None = None,
) -> tuple[ContactSolution, str]:
    """Solution of a contact problem by `solver`, or by the other one, and then a note that says why.

    Where Lemke's method ends without one, by round-off, Newton's goes on from there. `weights` (n,) m are the points'
    lengths, `start` (m + l,) are unknowns that may be close.
    Raises NotSolvedError where neither finds one.
    """
    failures: list[str] = []
    starts: list[Floats | None] = [None] if start is None else [start, None]  # of Newton's; None: its own first guess
    for name in ("newton", "lemke", "newton") if solver == "newton" else ("lemke", "newton"):
        if name == "newton" and not starts:
            continue
        try:
            solution = _by_newton(problem, starts) if name == "newton" else solve_by_lemke(problem)
        except NotSolvedError as error:
            failures.append(f"{name}: {error}")
            continue
        if solution.status == "solved":
            note = f"the contact problem was solved by {name} after {failures[-1]}" if failures else ""
            return solution, note
        residual = complementarity_residual(problem, solution.unknowns)
        failures.append(
            f"{name}: status '{solution.status}' after {solution.iterations} iterations, residual {residual:.2g}"
        )
        starts = [] if name == "newton" else [solution.unknowns, *starts]
    raise NotSolvedError(
        f"the contact problem of {problem.n_points} points was not solved: {'; '.join(failures)}; "
        f"try a coarser contact spacing or a softer contact stiffness{_advice(problem, weights)}"
    )


def _by_newton(problem: ContactProblem, starts: Sequence[Floats | None]) -> ContactSolution:
    """Newton's solution from the first of the starts that leads to one."""
    for start in starts:
        solution = solve_by_newton(problem, start)
        if solution.status == "solved":
            break
    return solution


def _advice(problem: ContactProblem, weights: Floats) -> str:
    """Advice where friction or dilation is large enough to be what the solvers fail at."""
    if problem.friction is None or problem.dilation is None:
        return ""
    n, A = problem.n_points, problem.compliance
    steep = problem.dilation * np.abs(A[n:, :n].diagonal()) >= A[:n, :n].diagonal()
    if steep.any():
        return (
            f", or a smaller dilation angle: pressing {steep.sum()} of the points makes them slip and open by dilation "
            "more than it closes them"
        )
    largest, limit = float(problem.friction.max()), friction_limit(A, weights)
    if largest == 0.0 or largest < limit:
        return ""
    return f", or less friction: of {largest:.3g} it may leave several solutions, below {limit:.2g} exactly one"
