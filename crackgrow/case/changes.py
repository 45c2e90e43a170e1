"""What was changed when a case was read, in words."""

from __future__ import annotations

import numpy as np

from crackgrow.case.model import Case
from crackgrow.case.units import Metres, place_text


def changes_of(case: Case) -> tuple[list[str], list[str]]:
    """What was moved when the case was read, and what of cracks was left out, the largest first."""
    moved, left = [], []
    for move in sorted(case.moved, key=lambda move: -move.distance):
        there = place_text(np.add(move.place, case.origin), 12)
        moved.append(f"{move.what} by {Metres(move.distance):.2g} onto {move.onto} at {there}")
    for part in sorted(case.cut, key=lambda part: (not part.whole, -part.length)):
        crack = f"'{part.crack}'{f' ({part.where})' if part.where else ''}"
        much = "all of " if part.whole else f"{Metres(part.length):.3g} of " if part.length else ""
        left.append(f"{much}{crack} at {place_text(np.add(part.place, case.origin))}: {part.why}")
    return moved, left
