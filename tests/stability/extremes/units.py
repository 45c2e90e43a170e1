"""Young's modulus, size and load: results over their units must not change at all."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from tests.stability.extremes.scenes import Scenes
from tests.stability.extremes.trial import Trial
from tests.stability.placed import Placement, scaled
from tests.stability.solved import against, everything, solved_placed

YOUNG, STRESS, WIDTH = 10e9, 100e6, 31e-3
"""Pa, Pa, m: modulus, load and width of the flaw's specimen as they are."""

TOLERANCE = 1e-8
"""Of the same scene in other units."""

COMPARED = "K, tractions, jumps, states, tip stress, criticality, energies over their units"

FRICTION = "cracks.flaw.contact.friction=0.3"


def young(scenes: Scenes) -> Iterator[Trial]:
    """Rock as soft as 1 Pa, as stiff as 1e12 Pa."""
    for value in scenes.few((1.0, 1e3, 1e6, 1e9, 1e12), (1.0, 1e12)):
        yield _trial(scenes, "young", f"{value:g} Pa", scaled(young=value / YOUNG))


def size(scenes: Scenes) -> Iterator[Trial]:
    """Specimens from a micrometre to ten kilometres."""
    for value in scenes.few((1e-6, 1e-3, 1.0, 1e2, 1e4), (1e-6, 1e4)):
        yield _trial(scenes, "size", f"{value:g} m", scaled(size=value / WIDTH))


def load(scenes: Scenes) -> Iterator[Trial]:
    """Loads from 1e-6 to 1e9 Pa; strengths go with them."""
    for value in scenes.few((1e-6, 1.0, 1e3, 1e6, 1e9), (1e-6, 1e9)):
        yield _trial(scenes, "load", f"{value:g} Pa", scaled(stress=value / STRESS))


def size_and_young(scenes: Scenes) -> Iterator[Trial]:
    """The corners of both."""
    for length, modulus in product((1e-6, 1e4), (1.0, 1e12)):
        placement = scaled(size=length / WIDTH, young=modulus / YOUNG)
        yield _trial(scenes, "size x young", f"{length:g} m, {modulus:g} Pa", placement)


def _trial(scenes: Scenes, axis: str, value: str, placement: Placement) -> Trial:
    plain = scenes.usual_flaw(FRICTION)

    return Trial(
        axis,
        value,
        COMPARED,
        TOLERANCE,
        lambda: solved_placed(scenes.flaw(FRICTION), placement),
        against(plain, everything),
        plain,
    )
