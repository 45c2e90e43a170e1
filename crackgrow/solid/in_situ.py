"""In-situ stress of a body: a uniform one, and others that follow formulas of the place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.formula import component_at
from crackgrow.case.model import Component, FarField, InSituStress

STEP = 0.01
"""Spacings between the places that a slope of a formula is taken from: exact for cubic stresses but for rounding."""

Stress = tuple[Component, Component, Component]


@dataclass(frozen=True, slots=True)
class InSitu:
    """Stress before anything displaces."""

    uniform: tuple[float, float, float] = (0.0, 0.0, 0.0)  # Pa: xx, yy, xy
    varying: tuple[tuple[float, Stress], ...] = ()  # factors, and the stresses that they multiply

    def plus(self, load: InSituStress | FarField, share: float) -> InSitu:
        """The stress with a share of a load."""
        if any(callable(component) for component in load.stress):
            return InSitu(self.uniform, (*self.varying, (share, load.stress)))
        xx, yy, xy = (np.array(self.uniform) + share * np.asarray(load.stress)).tolist()
        return InSitu((xx, yy, xy), self.varying)

    def at(self, places: Floats) -> Floats:
        """Stress (n, 3) Pa at places (n, 2) m."""
        return np.array(self.uniform) + self.more_at(places)

    def more_at(self, places: Floats) -> Floats:
        """What comes on top of the uniform stress (n, 3) Pa at places (n, 2) m."""
        total = np.zeros((len(places), 3))
        for share, stress in self.varying:
            total += share * np.stack([component_at(component, places) for component in stress], axis=1)
        return total

    def divergence(self, places: Floats, spacing: float) -> Floats:
        """The force (n, 2) N/m^3 that the stress puts on the rock at places (n, 2) m; `spacing` (m) of the lattice."""
        if not self.varying:
            return np.zeros((len(places), 2))
        along_x, along_y = (_slope(self, places, step) for step in STEP * spacing * np.eye(2))
        return np.stack([along_x[:, 0] + along_y[:, 2], along_x[:, 2] + along_y[:, 1]], axis=1)


NONE = InSitu()


def _slope(stress: InSitu, places: Floats, step: Floats) -> Floats:
    """Slope (n, 3) Pa/m of a stress along a step (2,) m, to fourth order."""
    one, two = (stress.more_at(places + k * step) - stress.more_at(places - k * step) for k in (1.0, 2.0))
    return np.asarray((8.0 * one - two) / (12.0 * float(np.hypot(*step))))
