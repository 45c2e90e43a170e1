"""Warnings as records: of what cause, where, how large, in words; and the table of causes with their thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Cause(Enum):
    """What makes results doubtful, the most important first: (limit, what it is of, what was measured beyond it)."""

    CONTACT_NONE = (0.05, "largest jump of the faces", "faces that never touch pass through each other; K_I < 0")
    UNBALANCED = (
        1e-6, "all loads",
        "a force on a point of a plane has no finite displacement: with half of its lower traction compression30 has "
        "2.1 times the displacement of its loads at 3 mm, 2.4 times at 0.75 mm, and on",
    )  # fmt: skip
    RESIDUAL = (1e-9, "forces", "digits of the equilibrium are lost")
    IMBALANCE = (1e-8, "forces", "digits of reactions are lost where stiffnesses are very unlike")
    ENERGY = (1e-4, "largest energy", "work, dissipation and released energy are off by as much")
    SHARP_KINK = (75.0, "degrees", "open: K within 5 % of the larger K below, off by half of it (see `cautions`)")
    CLOSED_KINK = (10.0, "degrees", "K off by up to half of the K without the kink (see `cautions`)")
    UNRESOLVED = (
        0.9, "spacing that accuracy: draft would take",
        "with a spacing of a tunnel's radius and twice that stresses at its wall are 2 and 33 to 65 % off",
    )  # fmt: skip
    SHORT_CRACK = (3.0, "spacings", "K off by 2 % from one spacing on, by 8 % at half a spacing, by 20 % below")
    SHORT_ARM = (
        4.0, "spacings",
        "of two cracks in line or at 30 degrees one of 1, 2, 3 spacings has K off by 55, 22, 11 %, the other, of 4 or "
        "more, by 16, 6, 2 %: tip functions fade out too near its tip",
    )  # fmt: skip
    CLOSE = (1.0, "spacings", "all patches are shared: K 10 % low at a tenth of a spacing, 30 % at a hundredth")
    SAWING = (20.0, "degrees", "explicit max_hoop_stress in compression30 turns by +-50 at each increment of 2 mm")
    OVERLAP = (0.05, "largest jump of the faces", "opening, slip and K beside it are off by up to as much")
    RIPPLE = (0.1, "mean pressure", "waves of contact tractions that no rock makes, and K_I with them")
    SOFT_CONTACT = (
        0.1, "what a crack of its length would open under the pressure",
        "r = E'/(2k length): of the pressure on rigid faces a crack bears 1/(1 + r), within 0.04 with mortar nodes and "
        "0.06 with gauss points",
    )  # fmt: skip
    CONTACT_LAYER = (
        0.25, "spacings, E'/(2k) with gauss points",
        "the pressure falls to a closed tip over it: K_I within 5 % of its own at 0.18, 20 % off at 0.05, and of the "
        "wrong sign or size far below",
    )  # fmt: skip
    SMALL_DISC = (0.0, "", "K from a smaller disc than usual, or from the faces alone: within 2 % and 10 %")
    NEARLY_INCOMPRESSIBLE = (
        0.49, "Poisson's ratio in plane strain",
        "K within 1 % up to it, off by 3 % at 0.499 and 20 % at 0.4999; at a support of 1.5 displacements are 3 and 7 %"
        " small",
    )  # fmt: skip
    SUPPORT = (2.0, "spacings, half width of a patch", "K is within 1 % from it on, 2 % low at 1.5")
    CONTACT_SPACING = (1.25, "spacings", "contact tractions oscillate below, where faces stick up to their full size")
    SMALL_RADIUS = (0.5, "spacings", "the averaged stress varies by less than 2.5 % with the spacing from it on")
    SHORT_INCREMENT = (1.0, "spacings", "kinks that follow closer on each other share all of their patches")
    MEMORY = (1.0, "memory of the machine", "the run is killed, or takes disk for memory and stands still")
    NO_TIPS = (0.0, "", "nothing can grow")
    MOVED = (0.0, "", "corners and ends that nearly touch do so in the scene that is solved")
    LEFT_OUT = (0.0, "", "vertices that repeat the one before them are no kinks")
    NOTE = (0.0, "", "what a solver tells of how it came to its answer")

    def __init__(self, limit: float, of: str, effect: str) -> None:
        self.limit, self.of, self.effect = limit, of, effect


RANK = {cause: number for number, cause in enumerate(Cause)}


@dataclass(frozen=True, slots=True)
class Caution:
    """One thing that makes the results of a step doubtful."""

    cause: Cause
    words: str  # a sentence of this place alone
    place: str = ""  # "crack 'flaw'", "the end of crack 'flaw'"; empty: the whole scene
    size: float = 0.0  # of cautions of one cause the larger is the worse; may be infinite

    @property
    def rank(self) -> int:
        """The smaller the more important."""
        return RANK[self.cause]
