"""What must not change in any case, whatever it models. No reference is known."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from crackgrow.case.model import Case, CriticalLoad, LoadHistory
from crackgrow.study.invariance.measures import against, balanced, everything, overall
from crackgrow.study.invariance.placed import Placement, mirrored, moved, scaled, turned
from crackgrow.study.invariance.solved import Solved, solved, solved_placed
from crackgrow.study.invariance.trial import Row, Trial, evaluate

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
        solve = partial(_moved_lattice, case, plain, offset)
        words = f"{offset[0]:g}, {offset[1]:g} spacings"
        yield Trial("lattice", words, OVERALL, LATTICE_TOLERANCE, solve, alike, plain)
    width = max(float(np.ptp(body.outline, axis=0).max()) for body in case.bodies)
    far = {"moved by a thousand sizes": moved(1e3 * width, -1e3 * width)}
    for name, placement in (PLACES | far).items():
        solve = partial(_placed, case, plain, placement)
        yield Trial("scene", name, OVERALL, PLACED_TOLERANCE, solve, alike, plain)


def _moved_lattice(case: Case, plain: Callable[[], Solved], offset: tuple[float, float]) -> Solved:
    return solved(_at_its_load(case, plain), None, offset)


def _placed(case: Case, plain: Callable[[], Solved], placement: Placement) -> Solved:
    return solved_placed(_at_its_load(case, plain), placement)


def _at_its_load(case: Case, plain: Callable[[], Solved]) -> Case:
    """The case under the load that was found for it, if one was: the criterion's stress is an average over points."""
    if not isinstance(case.loading, CriticalLoad):
        return case
    return replace(case, loading=LoadHistory((plain().result.load_factor,)))
