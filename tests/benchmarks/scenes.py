"""What benchmarks run."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from crackgrow.case.model import Case
from tests.benchmarks.beside import Scene

FRINGE = 4.0
"""Spacings that the lattice of two unknowns per node has, per direction, more than the plate."""

TIPS = 260
"""Unknowns of the tip functions of two tips, about."""


def solved_once(case: Case) -> Case:
    """The case on the same cells, whose error of K is not measured: that is another solve, on smaller ones."""
    return replace(case, numerics=replace(case.numerics, auto_rule=None))


def spacing_for(n_dofs: int, width: float = 31.0, height: float = 55.0) -> float:
    """Spacing (mm) at which a plate, by default that of compression30, has about so many unknowns with its two tips."""
    half, product = 0.5 * FRINGE * (width + height), width * height
    nodes = 0.5 * (n_dofs - TIPS) - FRINGE**2
    return (half + math.sqrt(half**2 + product * nodes)) / nodes


def _plate(n_dofs: int) -> Scene:
    """compression30 with about so many unknowns."""
    return Scene(
        f"compression30 {n_dofs:,}", "compression30", (f"numerics.spacing={spacing_for(n_dofs):.5g}",), steps=4
    )


BESIDE: Final = (
    Scene("compression30 3 mm", "compression30", ("numerics.spacing=3",)),
    Scene("compression30 1.5 mm", "compression30", ("numerics.spacing=1.5",), quick=True),
    Scene("compression30 0.75 mm", "compression30", ("numerics.spacing=0.75",)),
    _plate(20_000),
    _plate(80_000),
    Scene("flaw_and_hole 2 mm", "flaw_and_hole", ("numerics.spacing=2",), quick=True),
    Scene("en_echelon 1 mm", "en_echelon", ("numerics.spacing=1",), steps=6),
    Scene("two_flaws 1 mm", "two_flaws", ("numerics.spacing=1",), steps=5),
    Scene("interface_friction04 0.04", "interface_friction04", ("numerics.spacing=0.04",), quick=True),
    Scene("random_flaws 3 mm", "random_flaws", ("numerics.spacing=3",), steps=4),
)
"""Shipped cases on cells of one size, that both programs know."""
