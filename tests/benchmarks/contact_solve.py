"""The contact problem of many points, phase by phase: prints a table, CPU milliseconds beside errors.

Strips of rock whose faces open, stick and slip (`rock_problem`), and straight cracks with the exact kernel of the
infinite plane (`crack_problem`), rigid contact. Medians of five, Lemke and the search for other solutions once. Numbers
on the command line are numbers of points.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).parents[2]))  # run as a file

from crackgrow.contact.contact_lcp import solve_by_lemke
from crackgrow.contact.coulomb import active_set, complementarity_residual
from crackgrow.contact.equations import solve_active
from crackgrow.contact.newton import first_guess, solve_by_newton
from crackgrow.contact.problem import ContactProblem
from crackgrow.study.uniqueness import friction_limit
from tests.contact_problems import crack_problem, rock_problem, with_law

Floats = NDArray[np.float64]

REPETITIONS = 5
LEMKE_POINTS = 1100
"""Most points of which Lemke ends within a minute."""

HEAD = (
    "scene",
    "N",
    "friction",
    "cohesion",
    "open, stuck, slipping",
    "start",
    "Newton",
    "of it one factorization",
    "law checked",
    "all",
    "iterations",
    "bound of friction",
    "Lemke",
    "difference",
    "violation",
)


def problems(n_points: int) -> Iterator[tuple[str, ContactProblem, Floats]]:
    """The scenes, with the lengths (n,) of their points."""
    for kind in ("interface", "crack"):
        rock, weights = rock_problem(kind, n_points)
        for friction in (0.4, 1.0):
            for cohesion in (0.0, 1e6):
                yield f"{kind} strip", with_law(rock, friction, cohesion), weights
    for friction in (0.4, 1.0):
        for cohesion in (0.0, 0.1):
            problem = crack_problem(n_points, friction, cohesion, np.inf, 0.3, 3)
            yield "crack in a plane", problem, np.ones(n_points)


def timed(work: Callable[[], Any], repetitions: int = REPETITIONS) -> tuple[float, Any]:
    """Median CPU milliseconds, and what came of it."""
    spent = []
    for _ in range(repetitions):
        start = time.process_time()
        result = work()
        spent.append(1e3 * (time.process_time() - start))
    return float(np.median(spent)), result


def measure(name: str, problem: ContactProblem, weights: Floats) -> None:
    """One row of the table."""
    assert problem.friction is not None
    assert problem.cohesion is not None
    friction = float(problem.friction.max())
    guessing, start = timed(lambda: first_guess(problem))
    newton, solution = timed(lambda: solve_by_newton(problem, start))
    active = active_set(problem, solution.traction, problem.jump(solution.traction))
    factorization, _ = timed(lambda: solve_active(problem, active))
    checking, violation = timed(lambda: complementarity_residual(problem, solution.traction))
    exactly, limit = timed(lambda: friction_limit(problem.compliance, weights), 1)
    lemke, difference = "-", "-"
    if problem.n_points <= LEMKE_POINTS:
        spent, other = timed(lambda: solve_by_lemke(problem), 1)
        lemke = f"{spent:.0f}" if other.status == "solved" else f"{other.status} {spent:.0f}"
        difference = f"{np.abs(other.traction - solution.traction).max() / np.abs(solution.traction).max():.0e}"
    cells = [name, problem.n_points, f"{friction:g}", f"{problem.cohesion.max():g}"]
    cells += [", ".join(str(k) for k in np.bincount(solution.state, minlength=3))]
    cells += [f"{ms:.1f}" for ms in (guessing, newton, factorization, checking)]
    cells += [f"**{guessing + newton + checking:.0f}**", solution.iterations]
    cells += [f"{limit:.2g} ({exactly:.0f})", lemke, difference, f"{violation:.0e}"]
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def main() -> None:
    """Print the table."""
    print("| " + " | ".join(HEAD) + " |")
    print("|---" * len(HEAD) + "|")
    for n_points in map(int, sys.argv[1:] or ("300", "1000")):
        for name, problem, weights in problems(n_points):
            measure(name, problem, weights)


if __name__ == "__main__":
    main()
