"""The path of the contact points under a load that changes: straight pieces, from event to event.

Everything is linear in the loads as long as each point stays on its branch of the law (`contact.equations`). A piece
sets out from a state on the branches that an increment to its end has, if these lead back to the state; else on those
of a much shorter increment. It ends at the first event: a closed point is not pressed any more, or at its tensile
strength, an open one closes, one that only its bond holds opens, a sticking one comes to its limit, or slip that
dilates comes back to where it began.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crackgrow.arrays import Bools, Floats
from crackgrow.contact.coulomb import SLIP, ContactMemory
from crackgrow.contact.solve import PointStates
from crackgrow.errors import FreePieceError, NotSolvedError
from crackgrow.run.configuration import Configuration, LoadLevel

SHARES = (1.0, 1e-3, 1e-6, 1e-8)
"""Of the rest of the way, the increments that are looked at for the branches of the next piece.

Where even the shortest does not lead back points jump at this load: bonds break, or several events are nearly one.
"""

RESOLVED = 1e-10
"""Of the largest load: events are sought no nearer; a critical load is found to ten times as much. Where a load goes
faces that have lost their bonds stick, part and slide in turn, at a hundredth of the load each time."""

AT_EVENT = 1e-10
"""Of the share of the way to an event: what its place is good to where strength falls on the way."""

MOST_LOOKS = 30
"""For such an event; three are enough but where strength falls nearly as fast as the rock unloads."""

UNEVEN = 0.05
"""A piece may take so much more than `WEAR`: slip is not quite linear in the load."""

MOST_JUMPS = 8
"""In turn, each ten times as long as the one before, after which the rest of the way is one. Where pieces of rock may
lie anywhere no branches lead back."""

ON_PATH = 1e-8
"""Branches lead back to a state if they miss its tractions and slips by less, relative to the largest ones: beside
small cells the round-off of the compliance is some 1e-8 of them."""

WEAR = 0.02
"""Of what points can lose by slip, that a piece of the way takes."""

PROBE = 1e-3
"""Of the rest of the way: how fast slip wears is seen from this part of it."""

BEYOND = 2.0
"""Times the gap up to which faces that cohere touch: there a point that only its bond holds has opened for certain."""


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A piece of the path."""

    states: PointStates  # at its end
    share: float  # of the way that it takes
    kind: Literal["straight", "bent", "jump"]  # linear in the load; as strength falls; across a load where points jump
    middle: PointStates | None = None  # halfway between the loads, of a bent one


@dataclass(frozen=True, slots=True, eq=False)
class _LoadPath:
    """From what points remember at a load to another load."""

    configuration: Configuration
    was: ContactMemory
    first: LoadLevel
    last: LoadLevel
    near: PointStates | None  # states that may be close

    def at(self, share: float) -> PointStates:
        """The states after one increment to there."""
        return self.configuration.states(self.first.towards(self.last, share), self.was, self.near)

    def if_borne(self, share: float) -> PointStates | None:
        """The same; None where there are none."""
        try:
            return self.at(share)
        except (FreePieceError, NotSolvedError):
            return None

    def on_branch(self, like: PointStates, share: float) -> PointStates:
        """The states there on branches of others, with what slip on these takes."""
        return self.configuration.increment(self.first.towards(self.last, share), self.was).on_branch(like)

    def moved(self, states: PointStates) -> Floats:
        """How far (n,) m points have slipped on the way, less the elastic part."""
        law = self.configuration.contact.law
        return np.asarray(states.slip - law.shear_compliance * states.tangential - self.was.slip)

    def wear(self, states: PointStates) -> float:
        """The largest share of what weakening points can lose, and had not lost yet, or of what points can close by."""
        law = self.configuration.contact.law
        was, normal = self.was.normal, states.normal
        bent = float(np.max(np.abs(law.closure(normal) - law.closure(was)) / law.most, initial=0.0))
        slips = (states.state == SLIP) & law.weakens & (self.was.lost < 1.0) & states.trial.taken
        return max(bent, float(np.max(law.worn(self.was.lost, self.moved(states))[slips], initial=0.0)))


def next_piece(
    configuration: Configuration,
    was: ContactMemory,
    ends: tuple[LoadLevel, LoadLevel],
    largest: float,
    jumps: int,
    before: Piece | None,
    open_ended: bool,
) -> Piece:
    """The next piece of a way between two loads, after some jumps in turn, where the `largest` load factor has acted.

    It sets out from what `was` at the first load. A straight piece `before` ended at an event there: few points have
    other branches beyond, and where one event was the next is mostly near. Raises SolveError where there are no states
    at the last load; of a way that is gone in part, where no branch goes on: nothing may bear up to its end.
    """
    path = _LoadPath(configuration, was, *ends, None if before is None else before.states)
    law, length = configuration.contact.law, abs(ends[1].factor - ends[0].factor)
    resolved = RESOLVED * largest / length if length > 0.0 else 0.0
    least = min(1.0, max(SHARES[-1] * 10.0**jumps, resolved)) if jumps < MOST_JUMPS else 1.0  # share of the way
    if starts_in_proportion(configuration, was, path.first):
        return Piece(path.at(1.0), 1.0, "straight")
    if law.weakens.any() or law.bends.any():
        start = path.at(least)
        probe = max(PROBE, least)
        # wear of less than both is round-off of points left by the load
        if law.bends.any() or (
            path.wear(start) > 0.0 and ((there := path.if_borne(probe)) is None or path.wear(there) > 0.0)
        ):
            return _bent_piece(path, start, least) or Piece(start, least, "jump")
    for share in (*(share for share in _shares(before, open_ended or jumps > 0) if share > least), least):
        states = path.at(share) if share in (1.0, least) else path.if_borne(share)
        if states is None or path.wear(states) > 0.0 or ((states.trial.lost > was.lost) & law.breakable).any():
            continue  # on the way
        begin = path.on_branch(states, 0.0)
        if _leads_back(path, begin, states):
            break
    else:
        assert states is not None  # of the least share
        return _parted_piece(path, states) or Piece(states, share, "jump")
    if share == 1.0:
        return Piece(states, 1.0, "straight")
    end = path.on_branch(states, 1.0)
    event = max(_first_event(path, begin, end), share)
    return Piece(end if event == 1.0 else path.on_branch(begin, event), event, "straight")


def _shares(before: Piece | None, in_part: bool) -> tuple[float, ...]:
    """The increments that are looked at for the branches of the next piece, in turn.

    After a piece that ended early the next event is mostly near, too. Where it ended as soon as it had been looked at
    that is the round-off of points which hardly change, and a longer look passes them.
    """
    if before is None:
        return SHARES[1:] if in_part else SHARES
    return SHARES[2:] if 2.0 * SHARES[2] < before.share < SHARES[1] else SHARES[1:]


def starts_in_proportion(configuration: Configuration, was: ContactMemory, level: LoadLevel) -> bool:
    """Whether nothing has happened yet, and states will be in proportion to the loads from here on."""
    return was.at_rest and not (configuration.sized or configuration.shares(level).any())


def _parted_piece(path: _LoadPath, states: PointStates) -> Piece | None:
    """The piece up to the load at which faces touch again that carry nothing at its beginning; None where they do.

    Rock between them may lie anywhere, and no branches lead back; the energies of all its places are the same. `states`
    are some on the way. Tractions are round-off that give way by little beside the jumps of these.
    """
    length = max(float(np.abs(states.gap).max(initial=0.0)), float(np.abs(states.slip).max(initial=0.0)))
    small = ON_PATH * length / float(path.configuration.contact.scale.max())
    if np.abs(path.was.tractions).max(initial=0.0) > small:
        return None
    low, high, parted = 0.0, 2.0, None  # so that the end of the way is looked at first
    while high - low > AT_EVENT:
        share = 0.5 * (low + high)
        there = path.if_borne(share)
        if there is not None and np.abs(there.tractions).max(initial=0.0) <= small:
            low, parted = share, there
            if share == 1.0:
                break
        else:
            high = share
    return None if parted is None else Piece(parted, low, "straight")


def _bent_piece(path: _LoadPath, start: PointStates, least: float) -> Piece | None:
    """The piece along which slip takes at most `WEAR` of what points can lose; None where points jump.

    `start` are the states after the `least` share. Strength falls with slip there, so that tractions and slip are
    nearly linear in the load, and smooth up to the next event.
    """
    begin = path.on_branch(start, 0.0)
    if not _leads_back(path, begin, start):
        return None
    share = max(PROBE, least)
    end = path.on_branch(begin, share)
    share = min(1.0, share * WEAR / max(path.wear(end), share * WEAR))
    while path.wear(end := path.on_branch(begin, share)) > WEAR * (1.0 + UNEVEN):
        if share <= least:
            return None
        share = max(share * min(max(0.8 * WEAR / path.wear(end), 0.1), 0.5), least)
    event, end = _until_event(path, begin, (share, end))
    if event < least:
        event, end = least, path.on_branch(end, least)
    return Piece(end, event, "bent", path.on_branch(end, 0.5 * event))


def _until_event(path: _LoadPath, begin: PointStates, end: tuple[float, PointStates]) -> tuple[float, PointStates]:
    """The first share of the way at which a point leaves its branch of a bent piece up to an `end`, with the states."""
    low, high = (0.0, begin), end
    for look in range(MOST_LOOKS):
        part = _first_event(path, low[1], high[1])
        if part == 1.0:
            return high
        part = part if look % 2 == 0 else 0.5  # alone the first creeps where friction bends near no pressure
        share = low[0] + part * (high[0] - low[0])
        there = (share, path.on_branch(high[1], share))
        if min(share - low[0], high[0] - share) <= AT_EVENT * share:
            return there
        if _first_event(path, begin, there[1]) < 1.0:
            high = there
        else:
            low = there
    return low if low[0] > 0.0 else high


def _leads_back(path: _LoadPath, begin: PointStates, states: PointStates) -> bool:
    """Whether the branches of `states` lead back to what was; `begin` are on these branches at the first load."""
    tractions = path.was.tractions
    size = max(float(np.abs(some).max(initial=0.0)) for some in (tractions, states.tractions, begin.tractions))
    length = size * float(path.configuration.contact.scale.max()) if size > 0.0 else 0.0
    length = max(length, float(np.abs(path.was.slip).max(initial=0.0)), float(np.abs(states.slip).max(initial=0.0)))
    moved = np.where(states.trial.taken, path.moved(begin), 0.0)
    off = float(np.abs(begin.tractions - tractions).max(initial=0.0))
    return off <= ON_PATH * size and float(np.abs(moved).max(initial=0.0)) <= ON_PATH * length


def _first_event(path: _LoadPath, begin: PointStates, end: PointStates) -> float:
    """The share of the way from one state to another on the same branches at which a point leaves its branch."""
    nearest = 1.0
    for which, first, last in _rooms(path, begin, end):
        leaving = which & (last < 0.0) & (last < first)
        share = np.maximum(first[leaving], 0.0) / (first - last)[leaving]
        nearest = min(nearest, float(np.min(share, initial=1.0)))
    return nearest


def _rooms(path: _LoadPath, begin: PointStates, end: PointStates) -> Iterator[tuple[Bools, Floats, Floats]]:
    """What is left until points leave their branches: which it is asked of, and two times (n,), at begin and end."""
    law, trial, n = path.configuration.contact.law, begin.trial, len(begin.gap)
    cohesion = np.where(trial.opened, 0.0, law.bound_of(trial.lost)[1])
    shear = [cohesion - law.bound_of(trial.lost, some.normal)[0] * some.normal for some in (begin, end)]
    closed, sticks, sense, slip = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool), np.zeros(n), np.zeros(n)
    if begin.active is not None:
        closed[trial.taken], sticks[trial.taken] = begin.active.closed, begin.active.slip == 0
        sense[trial.taken], slip[trial.taken] = begin.active.sense, begin.active.slip
    yield closed, law.tension_of(trial.lost) - begin.normal, law.tension_of(end.trial.lost) - end.normal
    yield ~closed, begin.gap, end.gap
    held = trial.taken & ~closed & (cohesion > 0.0)
    yield held, BEYOND * begin.touching - begin.gap, BEYOND * end.touching - end.gap
    for side in (-1.0, 1.0):
        left, there = (b - side * some.tangential for b, some in zip(shear, (begin, end), strict=True))
        yield sticks, left, there
    moved = [path.moved(some) for some in (begin, end)]
    yield (
        closed & ~sticks & (law.dilation[0] > 0.0),
        sense * (path.was.slip + moved[0]),
        sense * (path.was.slip + moved[1]),
    )
    wears = closed & ~sticks & law.weakens & (path.was.lost < 1.0)
    yield wears, slip * moved[0], slip * moved[1]
    lost = path.was.lost
    left, there = (law.following(lost) - lost - law.worn(lost, some) for some in moved)
    yield wears, left, there
