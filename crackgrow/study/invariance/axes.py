"""What must not change in any case, whatever it models. No reference is known."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

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


def invariance(case: Case) -> Iterator[Row]:
    """Rows of all trials of a case, each as soon as it is known; no row raises."""
    plain = functools.cache(lambda: solved(case))
    for trial in trials_of(case, plain):
        yield evaluate(trial)


def trials_of(case: Case, plain: Callable[[], Solved]) -> Iterator[Trial]:
    """The case as it is, in other units, on another lattice, in another place."""
    yield Trial("balance", "as it is", "forces, energy and residual in balance", BALANCE, plain, balanced, plain)
    yield from _units(case, plain)
    yield from _lattices(case, plain)
    yield from _places(case, plain)


def _units(case: Case, plain: Callable[[], Solved]) -> Iterator[Trial]:
    """Modulus, size and load far up and down; strengths go with the load."""
    placements = {
        "young times 1e-10": scaled(young=1e-10),
        "young times 1e10": scaled(young=1e10),
        "size times 1e-5": scaled(size=1e-5),
        "size times 1e5": scaled(size=1e5),
        "load times 1e-10": scaled(stress=1e-10),
        "load times 1e10": scaled(stress=1e10),
    }
    for name, placement in placements.items():
        yield Trial(
            "units",
            name,
            COMPARED,
            TOLERANCE,
            partial(solved_placed, case, placement),
            against(plain, everything),
            plain,
        )


def _lattices(case: Case, plain: Callable[[], Solved]) -> Iterator[Trial]:
    """The lattice moved under the scene. A load that is found stays as found: it follows the stress at a tip."""
    for offset in ((0.5, 0.5), (0.25, 0.1), (-0.37, 0.21)):
        yield Trial(
            "lattice",
            f"{offset[0]:g}, {offset[1]:g} spacings",
            OVERALL,
            LATTICE_TOLERANCE,
            partial(_moved_lattice, case, plain, offset),
            against(plain, overall),
            plain,
        )


def _places(case: Case, plain: Callable[[], Solved]) -> Iterator[Trial]:
    """The whole scene turned, mirrored, moved by a thousand times its size; a load that is found stays as found."""
    width = max(float((body.outline.max(axis=0) - body.outline.min(axis=0)).max()) for body in case.bodies)
    placements = {
        "turned by 90 degrees": turned(90.0),
        "mirrored": mirrored(),
        "moved by a thousand sizes": moved(1e3 * width, -1e3 * width),
    }
    for name, placement in placements.items():
        yield Trial(
            "scene",
            name,
            OVERALL,
            PLACED_TOLERANCE,
            partial(_placed, case, plain, placement),
            against(plain, overall),
            plain,
        )


def _moved_lattice(case: Case, plain: Callable[[], Solved], offset: tuple[float, float]) -> Solved:
    return solved(_at_its_load(case, plain), None, offset)


def _placed(case: Case, plain: Callable[[], Solved], placement: Placement) -> Solved:
    return solved_placed(_at_its_load(case, plain), placement)


def _at_its_load(case: Case, plain: Callable[[], Solved]) -> Case:
    """The case under the load that was found for it, if one was: the criterion's stress is an average over points."""
    if not isinstance(case.loading, CriticalLoad):
        return case
    return replace(case, loading=LoadHistory((plain().result.load_factor,)))
