"""How far a solved scene is from what is known of it. All deviations are relative."""

from __future__ import annotations

import numpy as np

from tests.stability.solved import Measure, Solved, difference


def contact_tractions(found: Solved, plain: Solved) -> float:
    """Largest difference of the contact tractions, by the largest."""
    return difference(found.tractions, plain.tractions, float(np.abs(plain.tractions).max(initial=0.0)))


def K_II_against(value: float) -> Measure:
    """|K_II| of every tip against one value, Pa sqrt(m), and K_I against zero."""

    def measure(found: Solved) -> float:
        size = np.abs(found.K) / value
        return float(np.abs(size - (0.0, 1.0)).max())

    return measure


def uniform(normal: float, tangential: float) -> Measure:
    """Tractions of cracks against uniform ones (Pa), and K against zero: faces that stick are as if there were none."""

    def measure(found: Solved) -> float:
        size = np.hypot(normal, tangential)
        tractions = np.abs(found.tractions - np.array([[normal], [tangential]])).max() / size
        half = 0.5 * max(np.hypot(*(crack.points[-1] - crack.points[0])) for crack in found.case.cracks)
        return float(max(tractions, np.abs(found.K).max() / (size * np.sqrt(np.pi * half))))

    return measure
