"""How large the first step of a case is: counted, not guessed, on the cover that the run will make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.cover.squares import QUANTA
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.plan.overview import estimated_nodes
from crackgrow.run.layout import cells_of, contact_faces, cover_of, n_constraints_of
from crackgrow.run.missing_loads import dry_joints
from crackgrow.run.scene import make_scene
from crackgrow.run.scene_warnings import scene_warnings, unbalanced_loads
from crackgrow.run.surface_laws import SurfaceLaw
from crackgrow.run.warning_causes import StepWarning


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


def squares_of(case: Case) -> Floats:
    """Corners (n, 4, 2) m, on the map, of the cells before anything grows."""
    scene = make_scene(case)
    cells = cells_of(scene, tuple(map(GrowingCrack.given, scene.case.cracks)))
    corners = cells.low[:, None] + cells.size[:, None, None] * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    return scene.lattice.to_map(corners / QUANTA)


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
        n_products=int((cover.functions_on(np.arange(cover.elements.n)).counts ** 2).sum()),
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
