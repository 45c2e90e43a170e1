"""Which axes there are, and their rows one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from crackgrow.case.model import Case
from crackgrow.errors import CaseError, Fault
from crackgrow.study.stability import axes_case, axes_contact, axes_material, axes_place, axes_units
from crackgrow.study.stability.scenes import FLAW, FOUNDATION, RIGID, Scenes
from crackgrow.study.stability.trial import Row, Trial, evaluate

Axis = Callable[[Scenes], Iterator[Trial]]

AXES: dict[str, Axis] = {
    "stiffness": axes_contact.stiffness,
    "friction": axes_contact.friction,
    "cohesion": axes_contact.cohesion,
    "young": axes_units.young,
    "size": axes_units.size,
    "load": axes_units.load,
    "poisson": axes_material.poisson,
    "contrast": axes_material.contrast,
    "lattice": axes_place.lattice,
    "tip": axes_place.tip_next_to,
    "angle": axes_place.angle,
    "length": axes_place.length,
    "scene": axes_place.scene,
    "stiffness-friction": axes_contact.stiffness_and_friction,
    "size-young": axes_units.size_and_young,
    "poisson-stiffness": axes_material.poisson_and_stiffness,
}
"""Axes of the built-in scenes, pairs at the end."""

CASE_AXES: dict[str, Callable[[Scenes, Case], Iterator[Trial]]] = {
    "balance": axes_case.balance,
    "units": axes_case.units,
    "lattice": axes_case.lattice,
    "scene": axes_case.scene,
}
"""Axes of a case of the user's own."""


def stability(case: Case | None = None, axes: Sequence[str] = (), *, short: bool = False) -> Iterator[Row]:
    """Rows of the axes asked for (default: all), of `case` or of the built-in scenes, each as soon as it is known.

    Raises CaseError for an axis that there is not, or where the built-in scenes' files are not; no row raises.
    """
    known: dict[str, Axis] = AXES
    if case is not None:
        known = {name: partial(_of_case, axis, case) for name, axis in CASE_AXES.items()}
    faults = [
        Fault("--axis", None, name, f"no such axis here; there are {', '.join(known)}")
        for name in axes
        if name not in known
    ]
    if case is None:
        here = "no such file: run in the folder that holds `cases`, or give a case of your own"
        faults += [Fault(str(path), None, "", here) for path in (FLAW, FOUNDATION, RIGID) if not path.is_file()]
    if faults:
        raise CaseError(faults)
    return _rows(Scenes(short), [known[name] for name in axes or known])


def _of_case(axis: Callable[[Scenes, Case], Iterator[Trial]], case: Case, scenes: Scenes) -> Iterator[Trial]:
    return axis(scenes, case)


def _rows(scenes: Scenes, axes: Sequence[Axis]) -> Iterator[Row]:
    for axis in axes:
        for trial in axis(scenes):
            yield evaluate(trial)
