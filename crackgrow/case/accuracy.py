"""Presets of the numerical settings, and the lattice spacing that follows from a scene.

The numbers are chosen from the measurement of `crackgrow trade`: README, "The trade between accuracy and time".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

AUTO: Final = "auto"
STANDARD: Final = "standard"


@dataclass(frozen=True, slots=True)
class Preset:
    """What `numerics.accuracy` sets: how many spacings the lengths of a scene are wide at least, and other settings."""

    per_crack: float  # spacings along the shortest crack
    per_increment: float  # along a growth increment
    per_radius: float  # along the averaging radius of the tip stress
    per_width: float  # across the smaller side of the narrowest body
    support: float
    quadrature: int
    contact_spacing: float


PRESETS: Final[Mapping[str, Preset]] = {
    "draft": Preset(3.0, 0.5, 0.25, 6.0, support=2.0, quadrature=4, contact_spacing=1.25),
    STANDARD: Preset(6.0, 1.0, 0.5, 10.0, support=2.0, quadrature=4, contact_spacing=1.25),
    "fine": Preset(12.0, 2.0, 1.0, 20.0, support=2.0, quadrature=4, contact_spacing=1.25),
}


@dataclass(frozen=True, slots=True)
class Lengths:
    """The lengths of a scene that the spacing must resolve, m."""

    cracks: Mapping[str, float]  # along each crack
    widths: Mapping[str, float]  # body by body, the smaller side of the box round it
    increment: float | None = None
    radius: float | None = None  # of the average of the stress round a tip


def automatic_spacing(preset: Preset, lengths: Lengths) -> tuple[float, str]:
    """The spacing (m) that resolves every length of a scene, and the rule that gave it; needs a body.

    h = min(crack / per_crack, increment / per_increment, radius / per_radius, width / per_width).
    """
    return min(_candidates(preset, lengths))


def _candidates(preset: Preset, lengths: Lengths) -> Iterator[tuple[float, str]]:
    for kind, found, parts in (("crack", lengths.cracks, preset.per_crack), ("body", lengths.widths, preset.per_width)):
        if found:
            name = min(found, key=lambda name: found[name])
            what = f"length of crack '{name}'" if kind == "crack" else f"smaller side of body '{name}'"
            yield found[name] / parts, f"{what} / {parts:g}"
    if lengths.increment is not None:
        yield lengths.increment / preset.per_increment, f"growth.increment / {preset.per_increment:g}"
    if lengths.radius is not None:
        yield lengths.radius / preset.per_radius, f"growth.tip_stress.radius / {preset.per_radius:g}"
