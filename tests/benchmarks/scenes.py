"""What is run: names, cases and the settings that they differ by."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from crackgrow.case import load_case
from crackgrow.case.model import Case
from tests.benchmarks.paths import ROOT

Part = Literal["runs", "contact", "sizes"]

NO_FILES = ("output.frames=none", "output.figures=false")

FRINGE = 4.0
"""Spacings that the lattice of two unknowns per node has, per direction, more than the plate."""

TIPS = 260
"""Unknowns of the tip functions of two tips, about."""

LARGE = 100_000
"""Unknowns beyond which a size is measured on request only."""

SIZES = (10_000, 20_000, 40_000, 100_000, 200_000, 500_000)


def solved_once(case: Case) -> Case:
    """The case on the same cells, whose error of K is not measured: that is another solve, on smaller ones."""
    return replace(case, numerics=replace(case.numerics, auto_rule=None))


@dataclass(frozen=True, slots=True)
class Run:
    """One thing to measure, in a process of its own."""

    name: str
    case: str  # of the folder `cases`
    settings: tuple[str, ...]
    part: Part = "runs"
    command: bool = False  # whether the whole command line is measured too
    repeats: int = 1  # of the timed run; 0: the run whose memory is measured is timed too
    quick: bool = False  # whether it is done within a few seconds

    @property
    def path(self) -> str:
        """The case file."""
        return str(ROOT / "cases" / f"{self.case}.yaml")

    def load(self) -> Case:
        """The case, without frames and figures."""
        return load_case(self.path, (*self.settings, *NO_FILES))


def spacing_for(n_dofs: int, width: float = 31.0, height: float = 55.0) -> float:
    """Spacing (mm) at which a plate, by default that of compression30, has about so many unknowns with its two tips."""
    half, product = 0.5 * FRINGE * (width + height), width * height
    nodes = 0.5 * (n_dofs - TIPS) - FRINGE**2
    return (half + math.sqrt(half**2 + product * nodes)) / nodes


def _plate(n_dofs: int, steps: int) -> tuple[str, ...]:
    """compression30 with about so many unknowns."""
    return (f"numerics.spacing={spacing_for(n_dofs):.5g}", f"growth.steps={steps}")


def long_flaws() -> tuple[str, ...]:
    """compression30 with another plate and six long flaws: about 300 contact points and 80,000 unknowns."""
    side, length = 100.0, 34.0
    middles = [(x, y) for x in (-33.0, 0.0, 33.0) for y in (-25.0, 25.0)]
    cracks = ", ".join(
        f"flaw{number}: {{path: {{center: [{x}, {y}], length: {length}, angle: 30}}, "
        "tips: both, contact: {friction: 0.3, cohesion: 0}}"
        for number, (x, y) in enumerate(middles)
    )
    half = side / 2
    held = (((-half, -half), "y"), ((half, -half), "y"), ((0.0, -half), "x"))
    supports = ", ".join(f"{{at: [{x}, {y}], displacement: {{{component}: 0}}}}" for (x, y), component in held)
    return (
        f"bodies.rock.shape.rectangle={{center: [0, 0], width: {side}, height: {side}}}",
        f"supports=[{supports}]",
        f"cracks={{{cracks}}}",
        "numerics.spacing=0.528",
        "growth.steps=1",
    )


def all_runs() -> Iterator[Run]:
    """Everything, in the order of the tables."""
    for spacing in (3, 1.5, 0.75):
        settings = (f"numerics.spacing={spacing}",)
        yield Run(f"compression30 {spacing} mm", "compression30", settings, command=True, quick=spacing > 1)
    yield Run("compression30 20000", "compression30", _plate(20_000, 3))
    yield Run("compression30 80000", "compression30", _plate(80_000, 3), repeats=0)
    yield Run("random_flaws", "random_flaws", ("growth.steps=3",), repeats=0)
    yield Run("interface_friction04", "interface_friction04", (), repeats=15, quick=True)
    yield Run("two_flaws", "two_flaws", ("growth.steps=4",), repeats=2, quick=True)
    yield Run("300 contact points", "compression30", long_flaws(), part="contact", repeats=0)
    for n in SIZES:
        yield Run(
            f"size {n}", "compression30", _plate(n, 2 if n <= LARGE else 1), part="sizes", repeats=int(n <= LARGE)
        )


def chosen(only: str | None = None, quick: bool = False, large: bool = False) -> list[Run]:
    """The runs whose name contains `only`; the quick ones alone; those beyond `LARGE` too."""
    return [
        run
        for run in all_runs()
        if (only is None or only in run.name)
        and (run.quick or not quick)
        and (large or run.part != "sizes" or int(run.name.split()[1]) <= LARGE)
    ]
