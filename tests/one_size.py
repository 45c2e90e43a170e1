"""Spacings of one size for scenes whose own cells follow from their accuracy: for tests that know them."""

from __future__ import annotations

from typing import Final

SPACINGS: Final = {
    "brazilian_disk": 2.5, "compression30": 1.5, "compression45": 1.5, "compression60": 1.5, "confined30": 2,
    "cyclic_friction": 2.5, "edge_tension": 1.2, "en_echelon": 2, "flaw_and_hole": 1.5, "junction_static": 1.5,
    "slant_tension": 1, "tension0": 1.5, "two_flaws": 2, "two_flaws_overlapping": 2,
}  # fmt: skip
"""In the unit of the case."""


def one_size(scene: str) -> tuple[str, ...]:
    """The setting that gives a shipped scene cells of one size; none where it has them anyway."""
    return (f"numerics.spacing={SPACINGS[scene]}",) if scene in SPACINGS else ()
