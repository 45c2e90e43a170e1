"""Targets of accuracy, and the sizes of cells that a run begins with for them.

A name is a target. The numbers of cells are those at which the difference to the companion mesh (`accuracy.companion`)
is within 1 % in most scenes with known K: tests/benchmarks/errors.md. A run refines its cells further where it has to.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

Kind = Literal[
    "tip", "stretch", "kink", "end", "room", "increment", "radius", "width", "feature", "bridge", "distance",
    "support", "load",
]  # fmt: skip

AUTO: Final = "auto"
STANDARD: Final = "standard"
TARGETS: Final[Mapping[str, float]] = {"draft": 0.03, STANDARD: 0.01, "fine": 0.002}
"""What the error estimate of K, or of the goal, may be, over its largest value."""

LEVELS_OF_SPACING: Final = 12  # levels that an automatic spacing counts on; the others are for what is smaller there
FEWEST, MOST = 0.6, 2.0  # parts of CELLS that a run begins with for 3 % and for less than 1 %: it refines where needed

REFINED_AT: Final[Mapping[str, tuple[Kind, ...]]] = {
    "tips": ("tip", "increment", "radius"),
    "kinks": ("stretch",),
    "corners": ("feature", "bridge", "support", "load"),
}
"""Lengths at which cells are refined, by the key of `numerics.refine` that says so; all others are for the spacing."""

CELLS: Final[Mapping[Kind, float]] = {
    "tip": 2.0,  # along a crack, of those at its tip
    "stretch": 6.0,  # along the part of a crack behind a tip or beside a kink
    "kink": 300.0,  # along a crack, of those at a kink
    "end": 12.0,  # along a crack, of those at its ends on other lines and where cracks meet
    "room": 2.0,  # from a tip to the nearest other line
    "increment": 1.0,  # along an increment of growth
    "radius": 0.5,  # along the averaging radius of the tip stress
    "width": 10.0,  # across the smaller side of the narrowest body
    "feature": 8.0,  # across holes, along sides at re-entrant corners, across curves
    "bridge": 3.0,  # across the rock between holes, corners and outlines
    "distance": 64.0,  # from a re-entrant corner or the end of a held part to the nearest tip; of cells there
    "support": 4.0,  # along supported parts of edges and interfaces
    "load": 2.0,  # along loaded parts of edges, and over which a pressure varies
}
"""Cells along a length for 1 %."""


def target_of(accuracy: str | float) -> float:
    """What a name or a number asks for."""
    return TARGETS[accuracy] if isinstance(accuracy, str) else accuracy


def cells_along(kind: Kind, accuracy: str | float) -> float:
    """How many cells a length of a kind has at least, to begin with."""
    return CELLS[kind] * min(max(TARGETS[STANDARD] / target_of(accuracy), FEWEST), MOST)


def name_of(accuracy: str | float, goal: str = "K") -> str:
    """What messages say of it."""
    return accuracy if isinstance(accuracy, str) else f"{goal} within {100.0 * accuracy:.3g} %"
