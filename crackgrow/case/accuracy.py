"""Presets of the numerical settings, and the sizes of cells that follow from a scene.

The numbers are chosen from the measurement of `crackgrow trade`: tests/benchmarks/README.md.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final

from crackgrow.case.features import Kind, Length

AUTO: Final = "auto"
STANDARD: Final = "standard"

MOST_ASKED_FOR: Final = 11
"""How often a case can ask for cells to be halved; a run can halve them more often."""

LEVELS_OF_PRESETS: Final = 12
"""How often presets count on halving them; the rest is for kinks, and for runs that halve cells further."""

REFINED_AT: Final[Mapping[str, tuple[Kind, ...]]] = {
    "tips": ("crack", "increment", "radius"),
    "kinks": ("stretch",),
    "corners": ("feature", "bridge", "support", "load"),
}
"""Lengths at which cells are halved, by the key of `numerics.refine` that says so; all others are for the spacing."""


@dataclass(frozen=True, slots=True)
class Preset:
    """What `numerics.accuracy` sets: how many cells the lengths of a scene are wide at least.

    Measured, next to the feature and over the largest stress or displacement there: a round hole of 4, 6, 8, 16
    spacings is off by 18, 4, 0.7, 0.03 %; stress at the corner of a square hole of 6, 8, 12 spacings by 6, 5, 4 %,
    before a notch whose sides are 4, 8, 16 spacings long by 15, 3, 1.5 %; rock of 1, 2, 3 spacings between two holes by
    3, 0.7, 0.2 %; a body on a contact of 2, 4, 8 spacings sinks in by 1.9, 0.9, 0.2 % too much or too little; below a
    load on 1, 2, 4 spacings stress at the depth of its width is off by 7, 0.5, 0.04 %, displacement by 9, 1.4, 0.2 %.
    """

    per_crack: float  # cells of the size at its tips along a crack
    per_stretch: float  # of the size at tips and kinks along the part of a crack between them
    per_longer: float  # of the size at a kink along the longer one of the parts beside it
    per_room: float  # of the size at a tip from there to what lies nearest
    per_rough: float  # along a crack at most, whatever its jogs ask for
    per_increment: float  # along a growth increment
    per_radius: float  # along the averaging radius of the tip stress
    per_width: float  # across the smaller side of the narrowest body
    per_feature: float  # across holes, along sides at re-entrant corners, across curves
    per_bridge: float  # across the rock between holes, corners and outlines
    per_distance: float  # from a re-entrant corner or the end of a held part to the nearest tip; of cells there
    per_support: float  # along supported parts of edges and interfaces
    per_load: float  # along loaded parts of edges

    def parts(self, kind: Kind) -> float:
        """How many spacings a length of a kind is wide at least."""
        return float(getattr(self, f"per_{kind}"))


_CELLS: Final = {  # by preset: draft, standard, fine
    "per_crack": (3.0, 6.0, 12.0),
    "per_stretch": (3.0, 12.0, 24.0),
    "per_longer": (12.0, 100.0, 300.0),
    "per_room": (1.0, 2.0, 4.0),
    "per_rough": (50.0, 200.0, 600.0),
    "per_increment": (0.5, 1.0, 2.0),
    "per_radius": (0.25, 0.5, 1.0),
    "per_width": (6.0, 10.0, 20.0),
    "per_feature": (6.0, 8.0, 16.0),
    "per_bridge": (2.0, 3.0, 6.0),
    "per_distance": (30.0, 100.0, 300.0),
    "per_support": (2.0, 4.0, 8.0),
    "per_load": (1.0, 2.0, 4.0),
}

PRESETS: Final[Mapping[str, Preset]] = {
    name: Preset(**{length: cells[number] for length, cells in _CELLS.items()})
    for number, name in enumerate(("draft", STANDARD, "fine"))
}


UNREFINED = 0.2
"""Error of K, over the largest, of closed and of grown flaws on cells as large as the flaw, as coarse ones have it."""

OF_STRAIGHT = 0.015
"""The least target that cells are made for to begin with where no crack has a kink, and there is no growth.

Tip functions follow the field there, and K alone counts, not the stress that a criterion averages over cells: these
cells leave less than 0.1 % in most scenes. Those for 0.1 % would be thirty times as many in wide plates.
"""

RIMS = 2.0
"""Cells from a re-entrant corner to the nearest tip, times a target: they leave a tenth of it."""

FIRST_HALVINGS = 7
"""Of the largest cells at the tips of the shortest crack, for a target, and the most that a run begins with.

Each leaves half of the error.
"""

NOTHING = 1e-9
"""Cells that are asked for along what a target halves cells at by itself."""


def preset_of(accuracy: str | float) -> Preset:
    """The preset of a name, or of a target of the error of K: as the draft, but for what cells are halved at.

    Cells can be halved so often, so the smaller the target the smaller they are to begin with.
    """
    if isinstance(accuracy, str):
        return PRESETS[accuracy]
    draft = PRESETS["draft"]
    part = min(1.0, UNREFINED / (accuracy * 2**FIRST_HALVINGS * draft.per_crack))
    return replace(
        draft,
        per_crack=part * draft.per_crack,
        per_increment=part * draft.per_increment,
        per_radius=part * draft.per_radius,
        per_distance=RIMS / accuracy,
        per_stretch=NOTHING,
        per_longer=NOTHING,
        per_room=NOTHING,
    )


def begun_with(target: float, straight: bool) -> float:
    """The target whose cells a run begins with; `straight` where no crack has a kink, and there is no growth."""
    return max(target, OF_STRAIGHT) if straight else target


def name_of(accuracy: str | float, goal: str = "K") -> str:
    """What messages say of it."""
    return accuracy if isinstance(accuracy, str) else f"{goal} within {100.0 * accuracy:.3g} %"


def automatic_spacing(preset: Preset, lengths: Iterable[Length], refined: Container[Kind] = ()) -> tuple[float, str]:
    """The spacing (m) that resolves every one of the lengths, of which there is one at least, and what gave it.

    At lengths of the kinds `refined` cells are halved, as often as they can be.
    """
    found = []
    for length in lengths:
        halvings = LEVELS_OF_PRESETS if length.kind in refined else 0
        found.append((2**halvings * length.metres / preset.parts(length.kind), _rule(preset, length, halvings)))
    return min(found)


def _rule(preset: Preset, length: Length, halvings: int) -> str:
    return f"{length.what} / {preset.parts(length.kind):g}" + (f" x 2^{halvings}" if halvings else "")
