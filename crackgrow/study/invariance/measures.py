"""How far apart two solved scenes are, and how far one is from what is known of it. All deviations are relative."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.run.reactions import imbalance
from crackgrow.study.invariance.solved import Solved

Measure = Callable[[Solved], float]
Difference = Callable[[Solved, Solved], float]


def against(plain: Callable[[], Solved], apart: Difference) -> Measure:
    """How far apart a scene is from one that is solved when it is needed."""
    return lambda found: apart(found, plain())


def stress_intensity(found: Solved, plain: Solved) -> float:
    """Largest difference of K_I and K_II, by the largest |K|, or what the contact tractions could make of a spacing."""
    pressure = np.abs(plain.tractions).max(initial=0.0)
    size = max(np.abs(np.nan_to_num(plain.K)).max(initial=0.0), pressure * np.sqrt(plain.case.numerics.spacing))
    return difference(found.K, plain.K, float(size))


def overall(found: Solved, plain: Solved) -> float:
    """Largest difference of K, the displacement along the loads, energies and forces: what no lattice may change."""
    return max(
        stress_intensity(found, plain),
        difference(np.array(found.load_displacement), np.array(plain.load_displacement), plain.displacement_size),
        difference(found.energies, plain.energies, float(np.abs(plain.energies).max())),
        difference(found.forces, plain.forces, float(max(plain.load_size, plain.forces.max(initial=0.0)))),
    )


def everything(found: Solved, plain: Solved) -> float:
    """As `overall`, with tractions and jumps of every contact point, its state, tip stress and criticality."""
    if not np.array_equal(found.result.contact.state, plain.result.contact.state):
        return float("inf")
    return max(
        overall(found, plain),
        difference(found.tractions, plain.tractions, float(np.abs(plain.tractions).max(initial=0.0))),
        difference(found.jumps, plain.jumps, plain.displacement_size),
        difference(found.tip_stress, plain.tip_stress, float(np.abs(plain.tip_stress).max(initial=0.0))),
        difference(found.criticality, plain.criticality, float(np.abs(plain.criticality).max(initial=0.0))),
    )


def balanced(found: Solved) -> float:
    """What loads and reactions leave, the energy balance and the equilibrium residual, whichever is largest."""
    return max(imbalance(found.solution), found.result.energy.error, found.result.residual)


def difference(found: Floats, plain: Floats, size: float) -> float:
    """Largest difference by `size`; infinite where only one of the two has a number, or the shapes are unlike."""
    if found.shape != plain.shape or not np.array_equal(np.isnan(found), np.isnan(plain)):
        return float("inf")
    left = float(np.nan_to_num(np.abs(found - plain)).max(initial=0.0))
    return left / size if size > 0.0 else left
