"""The path of the contact points under a load that changes: straight pieces, from event to event.

Everything is linear in the loads as long as each point stays on its branch of the law (`coulomb.Branches`). A piece
sets out from a state on the branches that an increment to its end has, if these lead back to the state; else on those
of a much shorter increment. It ends at the first event: a closed point is not pressed any more, an open one closes, one
that only its bond holds opens, a sticking one comes to its limit, or slip that dilates comes back to where it began.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Bools, Floats
from crackgrow.contact.coulomb import SLIP, ContactMemory
from crackgrow.contact.solve import PointStates
from crackgrow.run.configuration import Configuration
from crackgrow.run.load_level import LoadLevel

SHARES = (1.0, 1e-3, 1e-6, 1e-8)
"""Of the rest of the way, the increments that are looked at for the branches of the next piece.

Where even the shortest does not lead back points jump at this load: bonds break, or several events are nearly one.
"""

MOST_JUMPS = 8
"""In turn, each ten times as long as the one before, after which the rest of the way is one. Where pieces of rock may
lie anywhere no branches lead back."""

ON_PATH = 1e-8
"""Branches lead back to a state if they miss its tractions and slips by less, relative to the largest ones: beside
small cells the round-off of the compliance is some 1e-8 of them."""

WEAR = 0.02
"""Of what points can lose by slip, that a piece of the way takes at most: between its ends strength falls linearly."""

PROBE = 1e-3
"""Of the rest of the way: how fast slip wears is seen from this part of it."""

BEYOND = 2.0
"""Times the gap up to which faces that cohere touch: there a point that only its bond holds has opened for certain."""

Piece = Literal["straight", "bent", "jump"]
"""Of the path: as linear in the load, with strength that falls with slip, or across a load at which points jump."""


@dataclass(frozen=True, slots=True, eq=False)
class Remembered:
    """What the next increment needs of a state, at the contact points of the configuration it is on."""

    memory: ContactMemory
    normal: Floats  # (n,) Pa
    tangential: Floats  # (n,) Pa
    dilation: Floats  # (n,) m

    @classmethod
    def of(cls, memory: ContactMemory, points: PointStates) -> Remembered:
        """What is needed of points with such a memory."""
        return cls(memory, points.normal, points.tangential, points.dilation)

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Remembered:
        """What was remembered, from its `arrays`; earlier versions had no `closed` among them."""
        lost = arrays["lost"]
        memory = ContactMemory(arrays["slip"], lost, arrays.get("closed", lost == 0.0))
        return cls(memory, arrays["normal"], arrays["tangential"], arrays["dilation"])

    @property
    def arrays(self) -> dict[str, NDArray[Any]]:
        """All that points remember (n,), by name."""
        of_memory = {"slip": self.memory.slip, "lost": self.memory.lost, "closed": self.memory.closed}
        return {**of_memory, "normal": self.normal, "tangential": self.tangential, "dilation": self.dilation}

    @property
    def tractions(self) -> Floats:
        """(2 n,) Pa, all normals, then all tangentials."""
        return np.concatenate([self.normal, self.tangential])


def next_piece(
    configuration: Configuration,
    was: Remembered,
    way: tuple[LoadLevel, LoadLevel],
    jumps: int,
    before: PointStates | None,
) -> tuple[PointStates, LoadLevel, Piece]:
    """States of the contact points at the end of the next piece of a way, the load there, and what the piece is.

    It sets out from what `was` at the first load; `jumps` are those in turn that have led there. After an event
    `before` are the states there: few points have other branches beyond, and where one event was the next is mostly
    near. Raises SolveError where there are no states.
    """
    (first, last), memory = way, was.memory

    def level(share: float) -> LoadLevel:
        return last if share == 1.0 else LoadLevel(*(a + share * (b - a) for a, b in zip(first, last, strict=True)))

    def on_branch(like: PointStates, share: float) -> PointStates:
        increment, free = configuration.increment(level(share), memory)
        return increment.on_branch(like, free)

    least = SHARES[-1] * 10.0**jumps if jumps < MOST_JUMPS else 1.0

    def at(share: float) -> PointStates:
        return configuration.states(level(share), memory, before)

    if configuration.contact.law.weakens.any() and _wear(configuration, memory, at(least)) > 0.0:
        probe = max(PROBE, least)
        fast = _wear(configuration, memory, at(probe)) / probe
        if fast > 0.0:  # else that was round-off of points which the load leaves
            share, states = _while_wearing(configuration, memory, at, (least, min(1.0, WEAR / fast)))
            return states, level(share), "jump" if share == least else "bent"
    shares = SHARES if before is None else SHARES[1:]
    for share in (*(share for share in shares if share > least), least):
        states = at(share)
        if _wear(configuration, memory, states) > 0.0:
            continue  # it begins on the way
        begin = on_branch(states, 0.0)
        if _leads_back(configuration, begin, states, was):
            break
    else:
        return states, level(share), "jump"
    if share == 1.0:
        return states, last, "straight"
    end = on_branch(states, 1.0)
    event = max(_first_event(configuration, begin, end), share)
    return (end if event == 1.0 else on_branch(states, event)), level(event), "straight"


def _while_wearing(
    configuration: Configuration, memory: ContactMemory, at: Callable[[float], PointStates], shares: tuple[float, float]
) -> tuple[float, PointStates]:
    """A share of the way on which slip takes at most `WEAR` of what points can lose, or the least, with its states.

    `shares` are the least and the first to be tried. Along such a piece strength falls with slip, so that tractions and
    slip are not linear in the load.
    """
    least, share = shares
    while True:
        share = max(share, least)
        states = at(share)
        wear = _wear(configuration, memory, states)
        if wear <= WEAR or share == least:
            return share, states
        share *= min(max(0.8 * WEAR / wear, 0.1), 0.5)


def _wear(configuration: Configuration, memory: ContactMemory, states: PointStates) -> float:
    """The largest share of what weakening points can lose, and have not lost yet, that their slip is of."""
    law = configuration.contact.law
    slips = (states.state == SLIP) & law.weakens & (memory.lost < 1.0) & states.trial.taken
    moved = states.slip - law.shear_compliance * states.tangential - memory.slip
    return float(np.max(law.worn(moved)[slips], initial=0.0))


def _leads_back(configuration: Configuration, begin: PointStates, states: PointStates, was: Remembered) -> bool:
    """Whether the branches of some `states` lead back to what `was` at first.

    `begin` are the states on these branches at the load there.
    """
    law, memory, tractions = configuration.contact.law, was.memory, was.tractions
    if bool(((states.trial.lost > memory.lost) & law.breakable).any()):
        return False
    size = max(float(np.abs(some).max(initial=0.0)) for some in (tractions, states.tractions, begin.tractions))
    length = size * float(configuration.contact.rock.diagonal().max()) if size > 0.0 else 0.0
    length = max(length, float(np.abs(memory.slip).max(initial=0.0)), float(np.abs(states.slip).max(initial=0.0)))
    moved = np.where(states.trial.taken, begin.slip - law.shear_compliance * begin.tangential - memory.slip, 0.0)
    off = float(np.abs(begin.tractions - tractions).max(initial=0.0))
    return off <= ON_PATH * size and float(np.abs(moved).max(initial=0.0)) <= ON_PATH * length


def _first_event(configuration: Configuration, begin: PointStates, end: PointStates) -> float:
    """The share of the way from one state to another on the same branches at which a point leaves its branch."""
    nearest = 1.0
    for which, first, last in _rooms(configuration, begin, end):
        leaving = which & (last < 0.0) & (last < first)
        share = np.maximum(first[leaving], 0.0) / (first - last)[leaving]
        nearest = min(nearest, float(np.min(share, initial=1.0)))
    return nearest


def _rooms(
    configuration: Configuration, begin: PointStates, end: PointStates
) -> Iterator[tuple[Bools, Floats, Floats]]:
    """What is left until points leave their branches: which it is asked of, and two times (n,), at begin and end."""
    law, trial, n = configuration.contact.law, begin.trial, len(begin.gap)
    friction, cohesion = law.bound_of(trial.lost)
    cohesion = np.where(trial.opened, 0.0, cohesion)
    closed, sticks, sense = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool), np.zeros(n)
    if begin.active is not None:
        closed[trial.taken], sticks[trial.taken] = begin.active.closed, begin.active.slip == 0
        sense[trial.taken] = begin.active.sense
    yield closed, -begin.normal, -end.normal
    yield ~closed, begin.gap, end.gap
    held = trial.taken & ~closed & (cohesion > 0.0)
    yield held, BEYOND * begin.touching - begin.gap, BEYOND * end.touching - end.gap
    for way in (-1.0, 1.0):
        left, there = (cohesion - friction * some.normal - way * some.tangential for some in (begin, end))
        yield sticks, left, there
    slips = [sense * (some.slip - law.shear_compliance * some.tangential) for some in (begin, end)]
    yield closed & ~sticks & (law.dilation > 0.0), slips[0], slips[1]
