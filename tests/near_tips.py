"""What is read off a displacement near tips where nothing is kept from one step to the next, as tests want it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from crackgrow.arrays import Floats
from crackgrow.cover.cover import Cover
from crackgrow.fracture.sites import Site
from crackgrow.fracture.stress_intensity import Integrals, StressIntensity
from crackgrow.fracture.tip_stress import TipField, fields_of, stress_functionals
from crackgrow.solid.elasticity import PlaneElasticity


def site_fields(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    sites: Sequence[Site],
    radius: float | Sequence[float],
) -> list[TipField]:
    """Stress round sites of the cover within `radius` (m), one or one a site; `u` (n_dofs,) m."""
    return fields_of(cover, materials, u, stress_functionals(cover, sites, radius))


def interaction_integrals(cover: Cover, *given: Any) -> list[StressIntensity]:
    """K_I and K_II of tips of a cover: see `Integrals.intensities`."""
    return Integrals(cover).intensities(*given)
