"""What a run takes, start, files, figures and report included: a few terms, fitted to whole runs.

tests/benchmarks/cost.py measures shipped cases and fits the constants, cost.json. Seconds are those of the CPU there.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, LoadHistory, Stages
from crackgrow.limits import allowed
from crackgrow.plan.overview import estimated_nodes
from crackgrow.plan.sizes import Sizes, guessed_sizes, sizes_of
from crackgrow.results.units import duration, memory_text
from crackgrow.run.warning_causes import WarningCause

TERMS: Final = ("command", "files", "first step", "growth", "contact")
MEMORY_TERMS: Final = ("program", "unknowns", "products", "growth", "contact")
OF_COMPANION: Final = 0.5  # of a step: to hold it against its companion mesh
MOST_LAID_OUT: Final = 300_000  # nodes: their cover is made in two seconds
STATIC_SHARE: Final = 0.03  # of the first step that another load factor on the same cracks takes
IMPLICIT_SOLVES: Final = 3.0  # of a step whose direction is corrected at the new tip
CONTAINER_MEMORY = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))  # bytes


@dataclass(frozen=True, slots=True)
class Cost:
    """An estimate of a whole run on the cells that it begins with: within a factor of two of 25 of 29 runs.

    Rounds of refinement can take five times as much, as can loads that follow many contact events.
    """

    seconds: float  # of CPU
    memory: float  # MiB, at most
    n_dofs: int  # of the first step

    @property
    def words(self) -> str:
        """What to expect, on a line."""
        return f"about {duration(self.seconds, 2)} of CPU and {memory_text(self.memory)} of memory"

    @property
    def needs(self) -> str:
        """How large the first step is, and the memory that the run takes."""
        return f"about {self.n_dofs} dofs, {memory_text(self.memory)} of memory"

    @property
    def warning(self) -> str:
        """What to say where the machine has too little memory for that; empty where it has enough."""
        available = machine_memory()
        if self.memory <= WarningCause.MEMORY.limit * available:
            return ""
        return (
            f"the run needs about {memory_text(self.memory)} of memory, and this machine has {memory_text(available)}: "
            "it would be killed or stand still; use a larger numerics.spacing, a smaller specimen, or "
            "numerics.accuracy draft"
        )


def cost_of(case: Case) -> Cost:
    """What a run of the case takes; its cover is made for that, unless that takes long. Raises GeometryError."""
    return estimated_cost(case, sizes_of(case) if estimated_nodes(case) < MOST_LAID_OUT else guessed_sizes(case))


def estimated_cost(case: Case, sizes: Sizes) -> Cost:
    """What a run of a case with a first step of these sizes takes."""
    table = json.loads((files("crackgrow.plan") / "cost.json").read_text(encoding="utf-8"))
    seconds, memory = terms_of(case, sizes)
    return Cost(float(seconds @ table["seconds"]), float(memory @ table["memory"]), sizes.n_dofs)


def terms_of(case: Case, sizes: Sizes) -> tuple[Floats, Floats]:
    """The values of TERMS and of MEMORY_TERMS.

    First steps and those of stages begin anew; each of growth makes new cells where tips advance, and takes the rest
    over. All of it is done once more, in part, on the companion mesh where errors are measured.
    """
    growth, factors = case.growth, case.last_step
    held = case.numerics.measured
    with_companion = 1.0 + OF_COMPANION * held
    first, later = 1.0, 0.0
    if growth is not None:
        later = growth.steps * (IMPLICIT_SOLVES if growth.direction == "implicit" else 1.0)
    elif isinstance(case.loading, LoadHistory | Stages):
        first += factors * (1.0 if isinstance(case.loading, Stages) else STATIC_SHARE)
    advancing = 0 if growth is None else sizes.n_tips if growth.advance == "all" else min(sizes.n_tips, 1)
    frames = {"every_step": case.last_step + 1, "first_and_last": 2, "none": 0}[case.output.frames]
    elements, products, contact = sizes.n_elements / 1e4, sizes.n_products / 1e6, sizes.n_tractions / 100
    steps = with_companion * np.array([first * products, later * advancing, (first + later) * contact])
    memory = [1.0, sizes.n_dofs / 1e4, products, held * advancing, contact]
    return np.array([1.0, (frames + 1) * elements, *steps]), np.array(memory)


def machine_memory() -> float:
    """MiB that a program on this machine can have: what is built in, or allowed to it or to its container."""
    most = [allowed("AS"), allowed("DATA")]
    if hasattr(os, "sysconf"):
        most.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    texts = (path.read_text(encoding="ascii").strip() for path in CONTAINER_MEMORY if path.is_file())
    most += [int(text) for text in texts if text.isdigit()]  # "max" where there is no limit
    return min(most) / 2**20
