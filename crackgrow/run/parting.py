"""What K is off by where faces part between two contact points: that they part there is all that these tell.

Pressure. Between a contact point that is open and the next one that is closed, at y from the tip, the pressure begins
somewhere, and rises from there as a root. The points say little of where it acts within l, half of the way between the
neighbours of the closed one. That half of the pressure p over l acts where that point is, at most, was measured for
flaws that a fluid opens. By the weight function of a half-infinite crack (Tada, Paris, Irwin 2000), sqrt(2 / (pi y)),

    K_misplaced = p |sqrt(8 / pi) (sqrt(y) - sqrt(y - l)) - l sqrt(2 / (pi y))| / 2

or y + l, where it is open farther from the tip. p is that at the closed point if faces part at the open one, and that
at the point beyond over sqrt(2) if they part at the closed one: the larger of both. K_II is off by the friction times
K_misplaced. Cells at the tip change nothing of it.

Cohesion. Shear c that faces carry beyond friction is gone at once where they part. Between the open point, y1 from the
tip, and the closed one, y2 from it, that may be anywhere. It is taken to be in the middle, so that the shear of half of
the stretch is missed at most:

    K_parting = c sqrt(8 / pi) |sqrt(y2) - sqrt(y1)| / 2

A tip that K_I opens, K_I > 0, may be open over a stretch a that no contact point lies on. The pressure p at the first
one, at y from the tip, tells how long that is, K_I = p sqrt(8 a / pi), and all of its shear is missed:

    K_unseen = c min(K_I / p, sqrt(8 y / pi))
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.contact.coulomb import OPEN
from crackgrow.cover.tips import Tip
from crackgrow.run.advancing import End
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import TipState

HALF_INFINITE = 8.0 / np.pi

MOST_GROWN = 1.5
"""l over the stretch between both points: cells grow to twice the size. At kinks two points can be in one place."""


@dataclass(frozen=True, slots=True, eq=False)
class Partings:
    """Where the faces of a crack part, seen from one of its tips, and what its K misses by that at most."""

    places: Floats  # (n, 4) m: from one contact point, x and y, to the next, as the crack runs
    cells: Floats  # (n,) m, the side of the smaller ones at both
    of_shear: Floats  # (n,) Pa sqrt(m), of K_II: cohesion
    of_pressure: Floats  # (n,) Pa sqrt(m), of K_I
    friction: float = 0.0  # by which that is of K_II, too
    unseen: float = 0.0  # Pa sqrt(m): where the tip is open more closely to itself than any contact point lies
    touches: bool = False  # whether the faces do at the contact point next to the tip, rigidly

    @property
    def K(self) -> Floats:
        """Of K_I and K_II together, place by place (n,), Pa sqrt(m)."""
        return np.hypot(self.of_pressure, self.of_shear + self.friction * self.of_pressure)

    @property
    def K_I(self) -> float:
        """Pa sqrt(m)."""
        return float(self.of_pressure.sum())

    @property
    def K_II(self) -> float:
        """Pa sqrt(m)."""
        return self.lost + self.friction * self.K_I

    @property
    def lost(self) -> float:
        """Of K_II, by cohesion, Pa sqrt(m)."""
        return float(self.of_shear.sum()) + self.unseen

    @property
    def at_most(self) -> float:
        """Of both together, Pa sqrt(m)."""
        return math.hypot(self.K_I, self.K_II)


NONE = Partings(np.zeros((0, 4)), *np.zeros((3, 0)))


def partings(state: LoadState, tips: Sequence[TipState]) -> dict[End, Partings]:
    """Where the faces of the cracks of all tips part."""
    cover = state.cover
    each = zip(cover.tip_ends, cover.tips, tips, strict=True)
    return {end: _seen_from(state, tip, known.intensity.K_I) for end, tip, known in each}


def _seen_from(state: LoadState, tip: Tip, K_I: float) -> Partings:
    """Where the faces of the crack of a tip with `K_I` part."""
    law, lattice, faces = state.scene.laws[tip.crack], state.scene.lattice, state.configuration.faces
    points = np.flatnonzero(faces.surface == tip.crack)
    if law.contact is None or not len(points):
        return NONE
    away = np.maximum(tip.from_start(faces.s[points]) * lattice.spacing, 0.0)
    order = np.argsort(away)
    points, away, roots = points[order], away[order], np.sqrt(HALF_INFINITE * away[order])
    outcome, friction = state.outcome.points, min(law.contact.friction, law.contact.residual_friction)
    pressure, is_open = -outcome.normal[points], outcome.state[points] == OPEN
    shear = np.maximum(np.abs(outcome.tangential[points]) - friction * np.maximum(pressure, 0.0), 0.0)
    unseen = 0.0
    if K_I > 0.0 and not is_open[0]:
        unseen = float(shear[0] * min(roots[0], K_I / pressure[0] if pressure[0] > 0.0 else np.inf))
    first = np.flatnonzero(is_open[1:] != is_open[:-1])
    there = lattice.to_metres(faces.nodes.points[points])
    sizes = state.cover.surfaces[tip.crack].in_cells.size(faces.s[points]) * lattice.spacing
    ends = (there[first + 1], there[first]) if tip.at_end else (there[first], there[first + 1])
    return Partings(
        places=np.column_stack(ends),
        cells=np.minimum(sizes[first], sizes[first + 1]),
        of_shear=0.5 * np.maximum(shear[first], shear[first + 1]) * np.diff(roots)[first],
        of_pressure=_misplaced(away, pressure, is_open, first),
        friction=max(law.contact.friction, law.contact.residual_friction),
        unseen=unseen,
        touches=not (is_open[0] or law.elastic),
    )


def _misplaced(away: Floats, pressure: Floats, is_open: Bools, first: Ints) -> Floats:
    """K_misplaced (n,) Pa sqrt(m) of the partings between the points `first` (n,) and those that follow them.

    Of all points `away` (m,) m from the tip, and `pressure` (m,) Pa.
    """
    opened, closed = np.where(is_open[first], (first, first + 1), (first + 1, first))
    beyond = np.clip(2 * closed - opened, 0, len(away) - 1)
    beyond = np.where(is_open[beyond], closed, beyond)
    largest = np.maximum(np.maximum(pressure[closed], pressure[beyond] / math.sqrt(2.0)), 0.0)
    y, stretch = away[closed], away[opened] - away[closed]
    half = np.where(beyond == closed, stretch, 0.5 * (away[opened] - away[beyond]))
    other = np.maximum(y + np.sign(stretch) * np.minimum(np.abs(half), MOST_GROWN * np.abs(stretch)), 0.0)
    spread = math.sqrt(HALF_INFINITE) * (np.sqrt(y) - np.sqrt(other))
    moved = np.abs(spread - (y - other) * np.sqrt(HALF_INFINITE / (4.0 * y)))
    return np.asarray(0.5 * largest * moved)
