"""What must not change in any case, whatever it models: trials of it, and what came of each. No reference is known."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Final, Literal

import numpy as np

from crackgrow.case.model import Case, CriticalLoad, LoadHistory
from crackgrow.errors import CrackgrowError
from crackgrow.results.units import or_null
from crackgrow.study.invariance.condition import condition_estimate
from crackgrow.study.invariance.placed import Placement, mirrored, moved, placed, scaled, turned
from crackgrow.study.invariance.solved import Solved, against, balanced, everything, overall, solved, solved_placed

Status = Literal["solved", "warned", "refused", "crashed"]
Verdict = Literal["yes", "said", "NO"]

LATTICE_TOLERANCE = 1e-2

PLACED_TOLERANCE = 1e-3
"""In another direction polygons fall into other triangles: the noise of quadrature."""

OVERALL = "K, displacement, energies, forces"

TOLERANCE = 1e-8
"""Of the same scene in other units."""

COMPARED = "K, tractions, jumps, states, tip stress, criticality, energies over their units"

BALANCE = 1e-9
"""What may be missing of the equilibrium of forces and of the energy balance."""

UNITS: Final = {
    "young times 1e-10": scaled(young=1e-10),
    "young times 1e10": scaled(young=1e10),
    "size times 1e-5": scaled(size=1e-5),
    "size times 1e5": scaled(size=1e5),
    "load times 1e-10": scaled(stress=1e-10),
    "load times 1e10": scaled(stress=1e10),
}
"""Modulus, size and load far up and down; strengths go with the load."""

OFFSETS: Final = ((0.5, 0.5), (0.25, 0.1), (-0.37, 0.21))
"""Of the lattice under the scene, in spacings."""

PLACES: Final = {"turned by 90 degrees": turned(90.0), "mirrored": mirrored()}


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A row of the table before it is computed."""

    axis: str
    value: str
    compared: str  # what is held against what
    tolerance: float  # relative
    solve: Callable[[], Solved]
    deviation: Callable[[Solved], float]
    plain: Callable[[], Solved]  # the scene at its usual value: its warnings are no news
    refusable: bool = False  # whether the program may refuse it: it lies beyond what is promised


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table. `nan` where there is no number."""

    axis: str
    value: str
    compared: str
    deviation: float
    tolerance: float
    condition: float  # estimate, of the scaled stiffness
    iterations: int  # of the contact solver; -1 where nothing was solved
    residual: float  # relative equilibrium residual
    status: Status  # warned: the program told the user more than at the usual value
    refusable: bool
    reason: str  # why it was refused, what it warned of
    seconds: float

    @property
    def verdict(self) -> Verdict:
        """`said`: the result is no good or there is none, and the program says so. `NO`: it does not."""
        if self.deviation <= self.tolerance and self.status != "crashed":
            return "yes"
        told = self.status == "warned" or (self.status == "refused" and self.refusable)
        return "said" if told else "NO"


def evaluate(trial: Trial) -> Row:
    """Compute a row; whatever is raised on the way ends this row alone."""
    started = time.perf_counter()
    deviation, condition, iterations, residual = math.nan, math.nan, -1, math.nan
    status: Status
    try:
        solved = trial.solve()
        iterations, residual = solved.result.contact_iterations, solved.result.residual
        condition = condition_estimate(solved.solution.contact.system)
        usual = trial.plain().result.warnings
        news = [warning for warning in solved.result.warnings if warning not in usual]
        deviation = trial.deviation(solved)
        status, reason = ("warned" if news else "solved"), "; ".join(news)
    except CrackgrowError as error:
        status, reason = "refused", str(error)
    except Exception as error:
        status, reason = "crashed", f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - started
    return Row(
        trial.axis, trial.value, trial.compared, deviation, trial.tolerance, condition, iterations, residual, status,
        trial.refusable, " ".join(reason.split()), seconds,
    )  # fmt: skip


def line_of(row: Row) -> str:
    """A row on a line of the terminal."""
    return (
        f"{row.verdict:4}  {row.axis:20} {row.value:28} {row.status:8} deviation {number(row.deviation):8} "
        f"of {number(row.tolerance):8} condition {number(row.condition):8} {row.seconds:5.1f} s"
    ).rstrip()


def record_of(row: Row) -> dict[str, object]:
    """A row in what JSON can hold: null where there is no number."""
    return {key: or_null(value) for key, value in asdict(row).items()} | {"verdict": row.verdict}


def number(value: float) -> str:
    """Two digits; empty where there is no number."""
    return f"{value:.2g}" if math.isfinite(value) else ""


def invariance(case: Case) -> Iterator[Row]:
    """Rows of all trials of a case, each as soon as it is known; no row raises."""
    plain = functools.cache(lambda: solved(case))
    for trial in trials_of(case, plain):
        yield evaluate(trial)


def trials_of(case: Case, plain: Callable[[], Solved]) -> Iterator[Trial]:
    """The case as it is, in other units, on another lattice, in another place.

    A load that is found stays as found on another lattice and in another place: it follows the stress at a tip.
    """
    yield Trial("balance", "as it is", "forces, energy and residual in balance", BALANCE, plain, balanced, plain)
    same = against(plain, everything)
    for name, placement in UNITS.items():
        yield Trial("units", name, COMPARED, TOLERANCE, partial(solved_placed, case, placement), same, plain)
    alike = against(plain, overall)
    for offset in OFFSETS:
        solve = partial(_solved_anew, case, plain, None, offset)
        words = f"{offset[0]:g}, {offset[1]:g} spacings"
        yield Trial("lattice", words, OVERALL, LATTICE_TOLERANCE, solve, alike, plain)
    width = max(float(np.ptp(body.outline, axis=0).max()) for body in case.bodies)
    far = {"moved by a thousand sizes": moved(1e3 * width, -1e3 * width)}
    for name, placement in (PLACES | far).items():
        solve = partial(_solved_anew, case, plain, placement)
        yield Trial("scene", name, OVERALL, PLACED_TOLERANCE, solve, alike, plain)


def _solved_anew(
    case: Case, plain: Callable[[], Solved], placement: Placement | None, offset: tuple[float, float] = (0.0, 0.0)
) -> Solved:
    """A case in another place or on another lattice, under the load that was found for it, if one was.

    The criterion's stress, which tells that load, is an average over points.
    """
    if isinstance(case.loading, CriticalLoad):
        case = replace(case, loading=LoadHistory((plain().result.load_factor,)))
    return solved(case if placement is None else placed(case, placement), placement, offset)
