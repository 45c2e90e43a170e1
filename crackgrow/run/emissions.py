"""What a laboratory would hear: faces that slip, open and break on the way of the loads, and tips that grow.

Each kind is told once of a surface in a step, with the load and the place at which it begins, and with all the energy
that goes into it until the end of the step: by friction where it slips, by bonds that let go where it breaks. So the
events of a step add up to its energies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.run.result import Event, EventKind

Course = Mapping[tuple[str, EventKind], Event]
"""The events of surfaces since the step began, by surface and kind, in the order of their beginning; without a step."""

NO_STEP = -1


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """What contact points do on a piece of the way of the loads."""

    names: Sequence[str]  # of the surfaces
    surface: Ints  # (n,) number of the surface of each
    points: Floats  # (n, 2) m
    load_factor: float  # at which the piece begins
    slip: Floats  # (n,) m, how far they slip on it
    slides: Bools  # (n,) which of them do by the law
    parts: Bools  # (n,) which come apart, that were pressed or bonded before
    breaks: Bools  # (n,) which begin to lose what they can lose; in a jump, which lose of it


def told(course: Course, moves: Moves, dissipated: Floats) -> Course:
    """The course after a piece of the way, on which friction takes some energy at each point (n,) J/m."""
    found = dict(course)
    kinds: tuple[tuple[EventKind, Bools], ...] = (
        ("break", moves.breaks), ("slip", moves.slides), ("opening", moves.parts)
    )  # fmt: skip
    for kind, which in kinds:
        for number in np.unique(moves.surface[which]).tolist():
            mine = np.flatnonzero(which & (moves.surface == number))
            first = moves.points[mine[np.argmax(moves.slip[mine])]]
            event = Event(NO_STEP, kind, moves.names[number], "", first, "", moves.load_factor, 0.0)
            found.setdefault((event.crack, kind), event)
    return _with_energy(found, "slip", moves, dissipated)


def released_by(course: Course, moves: Moves, weights: Floats, energy: float) -> Course:
    """The course after a jump of points that releases energy (J/m): it goes to what breaks, by the length (n,) of it.

    Where nothing breaks it goes to what slips.
    """
    kind: EventKind = "break" if moves.breaks.any() else "slip"
    shares = weights * (moves.breaks if kind == "break" else moves.slip)
    return _with_energy(course, kind, moves, energy * shares / shares.sum()) if shares.any() else course


def _with_energy(course: Course, kind: EventKind, moves: Moves, energy: Floats) -> Course:
    """The course with more energy (n,) J/m of points in the events of one kind, of surfaces that have one."""
    found, of_surface = dict(course), np.bincount(moves.surface, energy, len(moves.names))
    for number in np.flatnonzero(of_surface).tolist():
        if (event := found.get((moves.names[number], kind))) is not None:
            found[event.crack, kind] = replace(event, energy=event.energy + float(of_surface[number]))
    return found
