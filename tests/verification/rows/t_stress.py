"""The T stress: open, pressed and sliding cracks, in plates and in a disk."""

from __future__ import annotations

from functools import partial

from tests.verification.row import Row
from tests.verification.slit_body import closed_plate, disk, plate
from tests.verification.solutions import solved

SOURCE = "series solution, tests/verification/slit_body.py"
OPEN = 5e-3
PRESSED = 1e-2
"""T of pressed faces is as good as the pressure at the tip, three times as large here."""


def T(case: str, *settings: str) -> float:
    """T (MPa) of the crack's end."""
    return next(tip.T for tip in solved(case, *settings).result.tips if tip.tip == "end") / 1e6


def _rows():
    for angle in (0.0, 25.0, 65.0):
        exact = plate(5.0, angle, 31.0, 55.0, 1.0).T
        yield "tension0", f"cracks.flaw.path.angle={angle}", f"{angle:g} degrees, open", exact, OPEN
    for friction in (0.0, 0.3):
        exact = closed_plate(5.0, 30.0, 31.0, 55.0, (0.0, -100.0, 0.0), friction).T
        yield "compression30", f"cracks.flaw.contact.friction={friction}", f"friction {friction}", exact, PRESSED
    exact = disk(0.025, 90.0, 0.05, 2.0, 100.0).T
    yield "brazilian_disk", "cracks.flaw.path.angle=90", "along the load, open", exact, OPEN


ROWS = [
    Row(case, f"T, {words} [MPa]", exact, "exact", SOURCE, tolerance, partial(T, case, "growth.steps=0", setting))
    for case, setting, words, exact, tolerance in _rows()
]
