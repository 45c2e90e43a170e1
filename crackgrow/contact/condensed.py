"""The contact problem condensed onto some of the contact points, and its solution by one solver or the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import ContactProblem, ContactSolution, complementarity_residual
from crackgrow.contact.newton import solve_by_newton
from crackgrow.contact.system import ContactSystem
from crackgrow.contact.uniqueness import friction_limit
from crackgrow.errors import SolveError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

UNSYMMETRIC = 1e-2
"""A compliance of contact that is unsymmetric by more than this fraction of its largest entry is refused."""


def condensed(
    contact: ContactSystem,
    rock: Floats,
    free: Floats,
    friction: Floats,
    cohesion: Floats,
    rows: Ints,
    sliding: Ints,
    rise: Floats,
) -> ContactProblem:
    """The problem of the contact points `rows` (k,), with tangential rows of the points `sliding` (k,) or (0,).

    `rock` is the compliance of the rock between these rows, per unit traction. With dilation the gap's rows are those
    of the gap less `rise` (n,) times the slip. Raises SolveError where that leaves a point without resistance, and
    where round-off has spoilt the compliance of the rock.
    """
    law = contact.law
    _check_reciprocal(rock, np.concatenate([contact.weights[rows], contact.weights[sliding]]))
    compliance = rock.copy()
    compliance[np.diag_indices_from(compliance)] += np.concatenate([law.compliance[rows], law.compliance[sliding]])
    n = len(rows)
    if rise[rows].any():  # where there is dilation there is friction: the points that slide are `rows`
        compliance[:n] -= rise[rows, None] * compliance[n:]
        n_steep = int(np.sum(compliance.diagonal()[:n] <= 0.0))
        if n_steep:
            raise SolveError(
                f"pressing {n_steep} contact points makes them slip and open by dilation more than it closes them: "
                "use a smaller dilation angle, or supports that hold the rock without contact"
            )
    scale = None
    if contact.loose:  # the few rigid motions are the largest eigenvalues
        values = np.linalg.eigvalsh(0.5 * (compliance + compliance.T))
        scale = np.full(len(free), np.median(np.abs(values)))
    if not len(sliding):
        return ContactProblem(compliance, free, scale=scale)
    return ContactProblem(compliance, free, friction[rows], cohesion[rows], scale)


def _check_reciprocal(compliance: Floats, weights: Floats) -> None:
    """Raise SolveError unless the compliance S W (k, k) of the rock comes from a symmetric S that resists (Betti)."""
    symmetric = compliance / weights
    least, largest = float(symmetric.diagonal().min()), float(np.abs(symmetric).max())
    off = float(np.abs(symmetric - symmetric.T).max())
    if least <= 0.0 or off > UNSYMMETRIC * largest:
        raise spoilt("not positive" if least <= 0.0 else f"unsymmetric by {off / largest:.1g} of its largest entry")


def spoilt(what: str) -> SolveError:
    """The error where the compliance of the rock is `what`."""
    return SolveError(
        f"the system is ill conditioned: the compliance of the rock between contact points is {what}; a sliver of rock "
        "or a crack's tip may lie too close to a lattice line: change numerics.spacing or the crack a little"
    )


def solved(
    problem: ContactProblem,
    weights: Floats | None,
    solver: Literal["newton", "lemke"],
    start: Floats | None = None,
) -> tuple[ContactSolution, str]:
    """Solution of a contact problem by `solver`, or by the other one, and then a note that says why.

    Where Lemke's method ends without one, by round-off, Newton's goes on from there. `weights` (n,) m are the points'
    lengths, None where dilation makes the compliance asymmetric; `start` (m,) Pa are tractions that may be close.
    Raises SolveError where neither finds one.
    """
    failures: list[str] = []
    starts: list[Floats | None] = [None] if start is None else [start, None]  # of Newton's; None: its own first guess
    for name in ("newton", "lemke", "newton") if solver == "newton" else ("lemke", "newton"):
        if name == "newton" and not starts:
            continue
        try:
            solution = _by_newton(problem, starts) if name == "newton" else solve_by_lemke(problem)
        except SolveError as error:
            failures.append(f"{name}: {error}")
            continue
        if solution.status == "solved":
            note = f"the contact problem was solved by {name} after {failures[-1]}" if failures else ""
            return solution, note
        residual = complementarity_residual(problem, solution.traction)
        failures.append(
            f"{name}: status '{solution.status}' after {solution.iterations} iterations, residual {residual:.2g}"
        )
        starts = [] if name == "newton" else [solution.traction, *starts]
    raise SolveError(
        f"the contact problem of {problem.n_points} points was not solved: {'; '.join(failures)}; "
        f"try a coarser contact spacing or a softer contact stiffness{_less_friction(problem, weights)}"
    )


def _by_newton(problem: ContactProblem, starts: Sequence[Floats | None]) -> ContactSolution:
    """Newton's solution from the first of the starts that leads to one."""
    for start in starts:
        solution = solve_by_newton(problem, start)
        if solution.status == "solved":
            break
    return solution


def _less_friction(problem: ContactProblem, weights: Floats | None) -> str:
    """Advice where friction is large enough to be what the solvers fail at."""
    if problem.friction is None or weights is None:
        return ""
    largest, limit = float(problem.friction.max()), friction_limit(problem.compliance, weights)
    if largest == 0.0 or largest < limit:
        return ""
    return f", or less friction: of {largest:.3g} it may leave several solutions, below {limit:.2g} exactly one"
