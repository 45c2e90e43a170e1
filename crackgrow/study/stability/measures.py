"""How far apart two solved scenes are, and how far one is from what is known of it. All deviations are relative."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.run.reactions import imbalance
from crackgrow.study.stability.solved import Solved

Measure = Callable[[Solved], float]
Difference = Callable[[Solved, Solved], float]


def against(plain: Callable[[], Solved], difference: Difference) -> Measure:
    """The difference from a scene that is solved when it is needed."""
    return lambda found: difference(found, plain())


def stress_intensity(found: Solved, plain: Solved) -> float:
    """Largest difference of K_I and K_II, by the largest |K|, or what the contact tractions could make of a spacing."""
    pressure = np.abs(plain.tractions).max(initial=0.0)
    size = max(np.abs(np.nan_to_num(plain.K)).max(initial=0.0), pressure * np.sqrt(plain.case.numerics.spacing))
    return _difference(found.K, plain.K, float(size))


def overall(found: Solved, plain: Solved) -> float:
    """Largest difference of K, the displacement along the loads, energies and forces: what no lattice may change."""
    return max(
        stress_intensity(found, plain),
        _difference(np.array(found.load_displacement), np.array(plain.load_displacement), plain.displacement_size),
        _difference(found.energies, plain.energies, float(np.abs(plain.energies).max())),
        _difference(found.forces, plain.forces, float(max(plain.load_size, plain.forces.max(initial=0.0)))),
    )


def everything(found: Solved, plain: Solved) -> float:
    """As `overall`, with tractions and jumps of every contact point, its state, tip stress and criticality."""
    if not np.array_equal(found.result.contact.state, plain.result.contact.state):
        return float("inf")
    return max(
        overall(found, plain),
        _difference(found.tractions, plain.tractions, float(np.abs(plain.tractions).max(initial=0.0))),
        _difference(found.jumps, plain.jumps, plain.displacement_size),
        _difference(found.tip_stress, plain.tip_stress, float(np.abs(plain.tip_stress).max(initial=0.0))),
        _difference(found.criticality, plain.criticality, float(np.abs(plain.criticality).max(initial=0.0))),
    )


def contact_tractions(found: Solved, plain: Solved) -> float:
    """Largest difference of the contact tractions, by the largest."""
    return _difference(found.tractions, plain.tractions, float(np.abs(plain.tractions).max(initial=0.0)))


def K_II_against(value: float) -> Measure:
    """|K_II| of every tip against one value, Pa sqrt(m), and K_I against zero."""

    def measure(found: Solved) -> float:
        size = np.abs(found.K) / value
        return float(np.abs(size - (0.0, 1.0)).max())

    return measure


def balanced(found: Solved) -> float:
    """What loads and reactions leave, the energy balance and the equilibrium residual, whichever is largest."""
    return max(imbalance(found.solution), found.result.energy.error, found.result.residual)


def uniform(normal: float, tangential: float) -> Measure:
    """Tractions of cracks against uniform ones (Pa), and K against zero: faces that stick are as if there were none."""

    def measure(found: Solved) -> float:
        size = np.hypot(normal, tangential)
        tractions = np.abs(found.tractions - np.array([[normal], [tangential]])).max() / size
        half = 0.5 * max(np.hypot(*(crack.points[-1] - crack.points[0])) for crack in found.case.cracks)
        return float(max(tractions, np.abs(found.K).max() / (size * np.sqrt(np.pi * half))))

    return measure


def _difference(found: Floats, plain: Floats, size: float) -> float:
    """Largest difference by `size`; infinite where only one of the two has a number, or the shapes are unlike."""
    if found.shape != plain.shape or not np.array_equal(np.isnan(found), np.isnan(plain)):
        return float("inf")
    left = float(np.nan_to_num(np.abs(found - plain)).max(initial=0.0))
    return left / size if size > 0.0 else left
