"""How large the first step of a case is, counted on the cover that the run will make, and what the whole run takes.

Cost is a few terms, start, files, figures and report included. tests/benchmarks/cost.py measures shipped cases and fits
the constants, cost.json. Seconds are those of the CPU there.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, LoadHistory, Stages
from crackgrow.cover.squares import QUANTA
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.limits import allowed
from crackgrow.results.units import duration, memory_text
from crackgrow.run.layout import cells_of, contact_faces, cover_of, n_constraints_of
from crackgrow.run.scene import make_scene
from crackgrow.run.scene_warnings import dry_joints, scene_warnings, unbalanced_loads
from crackgrow.run.surface_laws import SurfaceLaw
from crackgrow.run.warning_causes import StepWarning, limit_of

OF_COMPANION: Final = 0.5  # of a step: to hold it against its companion mesh
MOST_LAID_OUT: Final = 300_000  # nodes: their cover is made in two seconds
STATIC_SHARE: Final = 0.03  # of the first step that another load factor on the same cracks takes
IMPLICIT_SOLVES: Final = 3.0  # of a step whose direction is corrected at the new tip
CONTAINER_MEMORY = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))  # bytes


@dataclass(frozen=True, slots=True)
class SurfacePlan:
    """A crack, interface line or foundation."""

    name: str
    n_points: int  # contact points
    bonded: bool
    touching: bool  # whether its faces can press on each other
    rough: bool  # whether they bear shear, by friction or cohesion


@dataclass(frozen=True, slots=True)
class Sizes:
    """Counts of step 0, and what the user should know before it."""

    n_dofs: int
    n_patches: int  # physical
    n_singular: int  # carriers of tip functions
    n_tips: int
    n_elements: int
    n_products: int  # of two functions that meet on an element, over all elements
    n_contact: int  # points
    n_multipliers: int  # of supports and bonds
    surfaces: tuple[SurfacePlan, ...]
    scene_warnings: tuple[StepWarning, ...]
    n_gathered: int = 0  # tips whose functions are gathered
    cells: tuple[tuple[float, int], ...] = ()  # sides (m) of cells that rock lies in, largest first, and their numbers

    @property
    def n_tractions(self) -> int:
        """Contact unknowns where all points are pressed: normal ones, and tangential where any surface is rough."""
        return self.n_contact * (2 if any(surface.rough for surface in self.surfaces) else 1)


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
        if self.memory <= limit_of("MEMORY") * available:
            return ""
        return (
            f"the run needs about {memory_text(self.memory)} of memory, and this machine has {memory_text(available)}: "
            "it would be killed or stand still; use a larger numerics.spacing, a smaller specimen, or "
            "numerics.accuracy draft"
        )


def squares_of(case: Case) -> Floats:
    """Corners (n, 4, 2) m, on the map, of the cells before anything grows."""
    scene = make_scene(case)
    cells = cells_of(scene, tuple(map(GrowingCrack.given, scene.case.cracks)))
    corners = cells.low[:, None] + cells.size[:, None, None] * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    return scene.lattice.to_map(corners / QUANTA)


def estimated_nodes(case: Case) -> int:
    """About how many lattice nodes have a patch that overlaps a body, counted for each body.

    Nodes within half a patch r of the outline count too: area + perimeter r + 4 r^2 (a convex outline, square
    patches), without those further than r inside of a hole: its area - perimeter r + 4 r^2; over the area h^2 of a
    node.
    """
    h = case.numerics.spacing
    reach = case.numerics.support * h
    total = 0.0
    for body in case.bodies:
        outline, *holes = (shapely.Polygon(ring.points - ring.points[0]) for ring in body.rings)
        total += outline.area + outline.length * reach + 4 * reach**2
        for hole in holes:
            if hole.area > hole.length * reach / 2:  # a square hole wider than a patch
                total -= hole.area - hole.length * reach + 4 * reach**2
    return round(total / h**2)


def guessed_sizes(case: Case) -> Sizes:
    """Estimate the sizes of step 0 from areas alone, as if all cells were of one size and none were cut.

    A cover of millions of cells takes minutes.
    """
    nodes, tips = estimated_nodes(case), sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    met = round((2.0 * case.numerics.support) ** 4)  # pairs of the patches that hold a cell
    return Sizes(2 * nodes, nodes, 0, tips, nodes, met * nodes, 0, 0, (), ())


def sizes_of(case: Case) -> Sizes:
    """Make the cover of step 0 and count. Raises GeometryError where it can't be made."""
    scene = make_scene(case)
    cover = cover_of(scene, tuple(map(GrowingCrack.given, case.cracks)))
    faces = contact_faces(scene, cover)
    cells = np.unique(cover.lattice.tiles.cell[cover.elements.tile])
    of_size, n_of_size = np.unique(cover.lattice.cells.size[cells] / QUANTA, return_counts=True)
    sides = cover.lattice.spacing * of_size[::-1]
    n_points = np.bincount(faces.surface, minlength=len(cover.surfaces)).tolist()
    surfaces = tuple(
        SurfacePlan(str(surface.name), n, law.bonded, law.contact is not None, _rough(law))
        for surface, law, n in zip(cover.surfaces, scene.laws, n_points, strict=True)
    )
    return Sizes(
        n_dofs=cover.n_dofs,
        n_patches=len(cover.patches.nodes),
        n_singular=sum(tip.carriers.n for tip in cover.tips),
        n_tips=len(cover.tips),
        n_elements=cover.elements.n,
        n_products=int((cover.functions.counts**2).sum()),
        n_contact=len(faces.surface),
        n_multipliers=n_constraints_of(scene, cover),
        surfaces=surfaces,
        scene_warnings=(*scene_warnings(scene, cover), *unbalanced_loads(scene, cover), *dry_joints(scene, cover)),
        n_gathered=sum(tip.carriers.gathered for tip in cover.tips),
        cells=tuple(zip(sides.tolist(), n_of_size[::-1].tolist(), strict=True)),
    )


def _rough(law: SurfaceLaw) -> bool:
    """Whether the faces of a surface bear shear; once they have slipped, too."""
    contact = law.contact
    return contact is not None and max(contact.friction, contact.residual_friction, contact.cohesion) > 0.0


def cost_of(case: Case) -> Cost:
    """What a run of the case takes; its cover is made for that, unless that takes long. Raises GeometryError."""
    return estimated_cost(case, sizes_of(case) if estimated_nodes(case) < MOST_LAID_OUT else guessed_sizes(case))


def estimated_cost(case: Case, sizes: Sizes) -> Cost:
    """What a run of a case with a first step of these sizes takes."""
    table = json.loads((files("crackgrow.plan") / "cost.json").read_text(encoding="utf-8"))
    seconds, memory = terms_of(case, sizes)
    return Cost(float(seconds @ table["seconds"]), float(memory @ table["memory"]), sizes.n_dofs)


def terms_of(case: Case, sizes: Sizes) -> tuple[Floats, Floats]:
    """The values of the terms of time and of memory in cost.json.

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
