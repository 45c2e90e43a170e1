"""What K_II is off by where faces part between two contact points, and lose the cohesion that they have kept there.

Shear c that faces carry beyond friction is gone at once where they part. Between a contact point that is open, y1 from
the tip, and the next one that is closed, y2 from it, that may be anywhere. It is taken to be in the middle, so that the
shear of half of the stretch is missed at most: by the weight function of a half-infinite crack (Tada, Paris, Irwin
2000)

    K_parting = c sqrt(8 / pi) |sqrt(y2) - sqrt(y1)| / 2

A tip that K_I opens, K_I > 0, may be open over a stretch a that no contact point lies on. The pressure p at the first
one, at y from the tip, tells how long that is, K_I = p sqrt(8 a / pi), and all of its shear is missed:

    K_unseen = c min(K_I / p, sqrt(8 y / pi))

Friction falls to zero with the pressure where faces part: what K misses of that is of second order in the cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.contact.coulomb import OPEN
from crackgrow.cover.tips import Tip
from crackgrow.run.advancing import End
from crackgrow.run.increments import LoadState
from crackgrow.run.judging import TipState

HALF_INFINITE = 8.0 / np.pi


@dataclass(frozen=True, slots=True, eq=False)
class Partings:
    """Where the faces of a crack part, seen from one of its tips, and what its K_II misses by that at most."""

    places: Floats  # (n, 4) m: from one contact point, x and y, to the next, as the crack runs
    stretches: Floats  # (n,) m, from one to the other
    K: Floats  # (n,) Pa sqrt(m)
    unseen: float = 0.0  # Pa sqrt(m): where the tip is open more closely to itself than any contact point lies
    touches: bool = False  # whether the faces do at the contact point next to the tip, rigidly

    @property
    def at_most(self) -> float:
        """All of it together, Pa sqrt(m)."""
        return float(self.K.sum()) + self.unseen


NONE = Partings(np.zeros((0, 4)), np.zeros(0), np.zeros(0))


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
    ends = (there[first + 1], there[first]) if tip.at_end else (there[first], there[first + 1])
    return Partings(
        places=np.column_stack(ends),
        stretches=np.diff(away)[first],
        K=0.5 * np.maximum(shear[first], shear[first + 1]) * np.diff(roots)[first],
        unseen=unseen,
        touches=not (is_open[0] or law.elastic),
    )
