"""A case of the user's own, whatever it models: what must not change. No reference is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from crackgrow.case.model import Case, CriticalLoad, LoadHistory
from crackgrow.study.stability.axes_place import LATTICE_TOLERANCE, OVERALL, PLACED_TOLERANCE
from crackgrow.study.stability.axes_units import COMPARED, TOLERANCE
from crackgrow.study.stability.measures import against, balanced, everything, overall
from crackgrow.study.stability.placed import Placement, mirrored, moved, scaled, turned
from crackgrow.study.stability.scenes import Scenes
from crackgrow.study.stability.solved import Solved, solved, solved_placed
from crackgrow.study.stability.trial import Trial

BALANCE = 1e-9
"""What may be missing of the equilibrium of forces and of the energy balance."""


def balance(scenes: Scenes, case: Case) -> Iterator[Trial]:
    """The case as it is."""
    usual = scenes.usual(case)
    yield Trial("balance", "as it is", "forces, energy and residual in balance", BALANCE, usual, balanced, usual)


def units(scenes: Scenes, case: Case) -> Iterator[Trial]:
    """Modulus, size and load far up and down; strengths go with the load."""
    plain = scenes.usual(case)
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


def lattice(scenes: Scenes, case: Case) -> Iterator[Trial]:
    """The lattice moved under the scene. A load that is found stays as found: it follows the stress at a tip."""
    plain = scenes.usual(case)
    for offset in scenes.few(((0.5, 0.5), (0.25, 0.1), (-0.37, 0.21)), ((-0.37, 0.21),)):
        yield Trial(
            "lattice",
            f"{offset[0]:g}, {offset[1]:g} spacings",
            OVERALL,
            LATTICE_TOLERANCE,
            partial(_moved_lattice, case, plain, offset),
            against(plain, overall),
            plain,
        )


def scene(scenes: Scenes, case: Case) -> Iterator[Trial]:
    """The whole scene turned, mirrored, moved by a thousand times its size; a load that is found stays as found."""
    width = max(float((body.outline.max(axis=0) - body.outline.min(axis=0)).max()) for body in case.bodies)
    placements = {
        "turned by 90 degrees": turned(90.0),
        "mirrored": mirrored(),
        "moved by a thousand sizes": moved(1e3 * width, -1e3 * width),
    }
    plain = scenes.usual(case)
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
