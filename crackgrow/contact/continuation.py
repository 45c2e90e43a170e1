"""Piecewise linear continuation: solves the contact problem where the active sets of Newton's method cycle.

At the start all points are pressed without shear, so that all of them stick for any coefficient of friction. The free
jumps then change linearly from those of that state to those of the problem: the parameter `left` falls from 1 to 0. On
one active set the solution is linear in `left`; where the first point changes its contact status the next active set
takes over (Katzenelson 1965). At a limit point the path turns back, and `left` grows for a while (Eaves 1976). If
supports hold the rock and faces do not dilate, the state at the start is the only one there: the path can't return to
it, and ends at a solution, since the rock resists.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.contact.coulomb import ActiveSet
from crackgrow.contact.equations import SINGULAR, ActiveEquations, solve_active
from crackgrow.contact.problem import ContactProblem

MOST_EVENTS: Final = 200
"""Changes of branch after which the way is given up: of 984 problems at random it takes 131 at most."""

UNLIKE: Final = 0.5
"""Of the pressure at the beginning, by which it differs at most: or points of symmetric scenes would change at once."""

GOLDEN: Final = 0.6180339887498949
"""Multiples of it leave rests that lie evenly, and are never the same."""


def solve_by_continuation(problem: ContactProblem) -> tuple[Floats, ActiveSet, int] | None:
    """Tractions (2 n,) with their active set and the number of linear solves; None where no way leads there.

    Supports hold all of the rock.
    """
    n, m = problem.n_points, problem.free.size
    begin, x, active = _pressed(problem)
    lacks, left, entered = begin.free - problem.free, 1.0, -1
    for event in range(1, MOST_EVENTS + 1):
        x, way, less = ActiveEquations(problem, active, SINGULAR).towards(begin, left, x)
        du, more = problem.jump(x) + left * lacks, problem.jump(way) - problem.free + less * lacks
        room, rate = _room(problem, active, x, du), _room(problem, active, way, more, 0.0)
        if (less > 0.0) if entered < 0 else (rate[entered] < 0.0):
            way, less, rate, more = -way, -less, -rate, -more
        falls = np.isfinite(rate) & (rate < 0.0) & (np.arange(4 * n) != entered)
        share = np.divide(np.maximum(room, 0.0), -rate, out=np.full(4 * n, np.inf), where=falls)
        first = int(np.argmin(share)) if n else 0
        if less < 0.0 and (n == 0 or -left / less <= share[first]):
            return x - left / less * way, active, event
        if share[first] == np.inf:
            break
        x, left = x + share[first] * way, left + share[first] * less
        active, entered = _next(problem, active, first, (du + share[first] * more)[n:m])
    return None


def _pressed(problem: ContactProblem) -> tuple[ContactProblem, Floats, ActiveSet]:
    """The problem whose points all stick under a pressure, its tractions and active set.

    The pressure is of the size of the tractions that there were if all points stuck under the loads.
    """
    n = problem.n_points
    x = np.zeros(2 * n)
    none = np.zeros(n, dtype=np.int64)
    stuck = np.abs(solve_active(problem, ActiveSet(np.ones(n, dtype=bool), none, none)))
    pressure = float(stuck.mean()) if stuck.any() else 1.0
    x[:n] = -pressure * (1.0 + UNLIKE * (GOLDEN * np.arange(n) % 1.0))
    free = problem.compliance @ x
    free[:n] += problem.dilation * np.abs(problem.slipped)
    sense = np.where(problem.slipped < 0.0, -1, 1)
    active = ActiveSet(np.ones(n, dtype=bool), np.where(_bare(problem), 1, 0), sense)
    return replace(problem, free=free), x, active


def _bare(problem: ContactProblem) -> Bools:
    """Points (n,) that never carry shear."""
    return np.asarray((problem.friction == 0.0) & (problem.cohesion == 0.0))


def _room(problem: ContactProblem, active: ActiveSet, x: Floats, du: Floats, given: float = 1.0) -> Floats:
    """What is left (4 n,) until points open, or close; slip one way, or stick; slip the other way; turn their sense.

    Infinite where none of it can be. `given` is 0 for how it changes with unknowns and jumps.
    """
    n, m, open_ = problem.n_points, problem.free.size, ~active.closed
    slipped, bound = given * problem.slipped + du[n:], given * problem.cohesion - problem.friction * x[:n]
    dilates, sticks = (problem.dilation > 0.0) & (active.slip != 0), active.slip == 0
    room = np.full((4, n), np.inf)
    room[0] = np.where(open_, du[:n] - problem.dilation * active.sense * slipped, -x[:n])
    room[1] = np.where(sticks, bound - x[n:m], active.slip * du[n:])
    room[2, sticks] = (bound + x[n:m])[sticks]
    room[1:3, _bare(problem) | (open_ & (problem.cohesion == 0.0))] = np.inf
    room[3, dilates] = (active.sense * slipped)[dilates]
    return room.ravel()


def _next(problem: ContactProblem, active: ActiveSet, first: int, du: Floats) -> tuple[ActiveSet, int]:
    """The active set beyond where a room `first` is nothing and slips are du (n,), and which room is nothing there."""
    n = problem.n_points
    kind, i = divmod(first, n)
    closed, slip, sense = active.closed.copy(), active.slip.copy(), active.sense.copy()
    stuck, entered = slip[i] == 0, first
    if kind == 0:
        closed[i] = not closed[i]
        if problem.cohesion[i] == 0.0 and problem.friction[i] > 0.0:  # what it slips by when it opens, or closes
            slip[i] = 1 if du[i] >= 0.0 else -1
    elif kind == 3:
        sense[i] = -sense[i]
    elif stuck:
        slip[i], entered = 3 - 2 * kind, n + i
    else:
        slip[i], entered = 0, (n if slip[i] > 0 else 2 * n) + i
    if kind != 3 and (stuck or slip[i] == 0):
        sense[i] = np.sign(problem.slipped[i]) or slip[i] or 1
    return ActiveSet(closed, slip, sense), entered
