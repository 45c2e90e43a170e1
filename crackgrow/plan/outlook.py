"""What a run is about to take, guessed from lengths and areas alone: told before anything is laid out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from crackgrow.case.features import line_length
from crackgrow.case.model import Case
from crackgrow.plan.cost import Cost, estimated_cost
from crackgrow.plan.overview import estimated_nodes
from crackgrow.plan.sizes import Sizes
from crackgrow.results.units import memory_text
from crackgrow.run.configuration import first_cells
from crackgrow.run.scene import make_scene

CARRIERS_AT_A_TIP: Final = (16, 3)  # of its functions: one for each patch, or gathered
SPACINGS_OF_A_POINT: Final = 2.0  # along a crack, of contact points
CUT_MORE: Final = 0.3  # of elements, where cells of several sizes meet
MEET_MORE: Final = 0.6  # of pairs of patches on an element there
MOST_SHARE: Final = 0.9  # of the machine's memory: others need some, too


@dataclass(frozen=True, slots=True)
class Outlook:
    """How large the first step is, about, and what the run takes."""

    n_dofs: int
    cost: Cost

    @property
    def words(self) -> str:
        """What to expect, on a line."""
        return f"about {memory_text(self.cost.memory)} of memory, {self.cost.words}"

    @property
    def needs(self) -> str:
        """How large it is, and the memory that it takes."""
        return f"about {self.n_dofs} dofs, {memory_text(self.cost.memory)} of memory"

    @property
    def warning(self) -> str:
        """What to say where the machine has less memory than that; empty where it has enough."""
        return self.cost.memory_warning(MOST_SHARE)


def outlook(case: Case) -> Outlook:
    """What a run of the case is about to take; good to a factor of two, and made in hundredths of a second."""
    support, spacing = case.numerics.support, case.numerics.spacing
    uniform, more = estimated_nodes(case), _n_halved(case)
    nodes = uniform + more
    share = more / nodes  # of cells among others of another size: more of them are cut, more patches meet on each
    tips = sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    tiles = 1 if support % 1.0 == 0.0 else 4 if support % 0.5 == 0.0 else 9  # of a cell, cut by the edges of patches
    elements = round(nodes * tiles * (1.0 + CUT_MORE * share))
    pairs = round(elements * (2.0 * support) ** 4 * (1.0 + MEET_MORE * share))
    singular = CARRIERS_AT_A_TIP[case.numerics.gathers_tip_functions] * tips
    lines = [crack.points for crack in case.cracks if crack.contact is not None]
    lines += [line for interface in case.interfaces for line in interface.lines]
    length = sum(map(line_length, lines))
    points = round(length / (SPACINGS_OF_A_POINT * spacing))
    n_dofs = 2 * nodes + 8 * singular
    cells = ((spacing, uniform), (0.5 * spacing, more))
    sizes = Sizes(n_dofs, nodes, singular, tips, elements, pairs, points, 0, (), (), cells=cells)
    return Outlook(n_dofs, estimated_cost(case, sizes))


def _n_halved(case: Case) -> int:
    """How many cells more there are since some are halved."""
    refine = case.numerics.refine
    if (refine.tips, refine.kinks, refine.corners) == (0, 0, 0):
        return 0  # a lattice of many cells is not laid out to learn that
    scene = make_scene(case)
    return first_cells(scene).n - scene.lattice.cells.n
