"""Growth at a rate, below the toughness: how fast tips advance, and how far they come in a step.

v = v_max (K / K_c)^n (Charles 1958). K / K_c is the criticality of the tip, by the criterion of the case. From K_c on
the tip is unstable and outruns the law, which has no more than v_max to say of it. In fatigue cycles take the place of
seconds: da/dN = C dK^m (Paris, Erdogan 1963), where dK is the range of the K that opens a tip along its kink. Where
that is negative faces are closed, and it counts as zero (ASTM E647).

In a step every tip comes as far as its velocity at the beginning takes it, until the first one has come to the largest
length. A tip that comes only a small part of that waits where it is, and keeps what it has gathered. What that was off
by, as the velocities at the end tell, is gathered as well, or taken from it.
"""

from __future__ import annotations

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Fatigue, Subcritical
from crackgrow.cover.shapes import Roots
from crackgrow.fracture.advance import CLEARANCE
from crackgrow.fracture.opening import ahead

WAITS = CLEARANCE
"""Increments: a tip that has gathered less waits. A path is not known more finely than that."""

SLOWEST = 1e-60
"""m/s, or m: what is slower stands still."""


def velocities(driving: Floats, law: Subcritical | Fatigue) -> Floats:
    """Velocity (n,) m/s of tips by their criticality, or growth in a cycle (n,) m by their range of K (Pa sqrt(m)).

    It is zero up to the threshold, and v_max from a criticality of 1 on.
    """
    driving = np.maximum(driving, 0.0)
    if isinstance(law, Fatigue):
        found = law.rate * (driving / law.at) ** law.exponent
    else:
        found = law.velocity * np.minimum(driving, 1.0) ** law.exponent
    return np.where((driving > law.threshold) & (found > SLOWEST), found, 0.0)


def range_of_K(first: tuple[float, float], last: tuple[float, float], kink: float, roots: Roots) -> float:
    """Range dK (Pa sqrt(m)) of the K that opens a tip along a kink (rad), between (K_I, K_II) at two loads."""
    opens = [max(float(ahead(K, kink, roots)[0]), 0.0) for K in (first, last)]
    return abs(opens[1] - opens[0])


def lengths(velocity: Floats, gathered: Floats, increment: float) -> tuple[Floats, Floats, int | None]:
    """How far tips advance in a step, what they have gathered behind it, both (n,) m, and the number of the first one.

    That is the tip which comes to the increment (m) first, of those with a velocity (n,) m/s, where each has `gathered`
    (n,) m before; None where all stand still.
    """
    moving = np.flatnonzero(velocity > 0.0)
    if len(moving) == 0:
        return np.zeros(len(velocity)), gathered, None
    first = int(moving[np.argmin((increment - gathered[moving]) / velocity[moving])])
    due = gathered + velocity / velocity[first] * (increment - gathered[first])
    due[first] = increment
    goes = (due >= WAITS * increment) & (velocity > 0.0)
    return np.where(goes, due, 0.0), np.where(goes, 0.0, due), first


def mean_velocity(before: float, after: float) -> float:
    """Length over time (m/s) of a tip whose ln(v) is linear along the length, from a velocity to another one.

    (1/v_0 - 1/v_1) / ln(v_1 / v_0) is the mean of 1/v: where K grows by a few percent, v does by tens of them.
    """
    change = float(np.log(after / before))
    return before * (change / -np.expm1(-change) if change else 1.0)
