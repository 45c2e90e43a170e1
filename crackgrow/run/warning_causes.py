"""Warnings: the table of causes with their thresholds, what was measured beyond them, and what is said of them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class WarningCause(Enum):
    """What makes results doubtful, the most important first.

    (limit, what it is of, what was measured beyond it, what is said: with its place, the limit, and numbers by name)

    A spacing is the side of the cells at the place: of the lattice's own where they are all of one size.
    """

    CONTACT_NONE = (
        0.05, "largest jump of the faces", "faces that never touch pass through each other; K_I < 0",
        "{place} has contact: none, and its faces lie in each other by {depth:.2g}, {percent:.3g} % of their largest "
        "jump: rock does not do that, and K_I and the stress there mean nothing; give the crack a contact law, such as "
        "{{friction: 0, cohesion: 0}}",
    )  # fmt: skip
    UNBALANCED = (
        1e-6, "all loads",
        "a force on a point of a plane has no finite displacement: with half of its lower traction compression30 has "
        "2.1 times the displacement of its loads at 3 mm, 2.4 times at 0.75 mm, and on",
        "{what} are carried by supports at points, where a plane gives way without bound: displacements depend on the "
        "spacing, and the stress there is not that of a specimen; balance the loads, or hold an edge",
    )  # fmt: skip
    FREE_EDGES = (
        0.01, "in-situ stress", "stress at the edge is gone at once, and all of it in a body that nothing holds",
        "{what} {are} free: the in-situ stress of {stress:.3g} MPa there relaxes; unless that is meant, as "
        "where an opening is, hold the outline (supports: [{{outline: rollers}}]) or load it (loads: far_field)",
    )  # fmt: skip
    DRY = (
        0.0, "", "a fluid presses where a load says so and nowhere else",
        "{dry} meets {fluid}, where a fluid presses, and stays dry: give it a pressure of its own, 0 if that is meant",
    )  # fmt: skip
    POINT_FORCE = (
        0.0, "", "displacement at the point grows by 2 F ln(2) / (pi E') on an edge whenever cells are halved",
        "{place} acts on a point: displacement and stress there grow without bound as cells get smaller; where they "
        "matter give a traction on a part of an edge",
    )  # fmt: skip
    CONTRADICTION = (
        1e-6, "largest displacement of both", "stress at the point that grows without bound as cells get smaller",
        "{place} holds a point of an edge otherwise than {other} does: {component} is {mine:.3g} and {its:.3g} at "
        "{point}, and the stress there means nothing; leave one of them out",
    )  # fmt: skip
    RESIDUAL = (
        1e-9, "forces", "digits of the equilibrium are lost",
        "the equilibrium residual is {size:.2g}: the system is ill conditioned",
    )  # fmt: skip
    IMBALANCE = (
        1e-8, "forces", "digits of reactions are lost where stiffnesses are very unlike",
        "loads and reactions are out of balance by {size:.1g}: bodies of very unlike stiffness",
    )  # fmt: skip
    ENERGY = (
        1e-4, "largest energy", "work, dissipation and released energy are off by as much",
        "work, strain energy, dissipation and what bonds set free miss each other by {percent:.2g} % of the largest: "
        "the energies are off by as much; apply the loads in smaller steps (loading.history)",
    )  # fmt: skip
    OVERLOAD = (
        2.0, "strength",
        "G is four times what the rock takes: a crack runs at three quarters of the Rayleigh speed (Freund 1990, 6.4)",
        "growth at this load is unstable: at {where} the load is {size:.3g} times the critical one (stress over "
        "strength), and a crack would not have waited for it; use loading: critical, where each step has the load at "
        "which a crack just grows, or a smaller load",
    )  # fmt: skip
    NOT_SMALL = (
        0.03, "strain, rotation, or slip over length", "what is of second order in it is left out, as large a part",
        "{what}: small strains and rotations are assumed, and stress, slip and K are off by about as much; check the "
        "units of young and of the loads, or use a smaller load",
    )  # fmt: skip
    SAWING = (
        20.0, "degrees", "explicit max_hoop_stress in compression30 turns by +-50 at each increment of 2 mm",
        "{place} turns to and fro by {size:.0f} degrees and more at each step: the direction is that at the beginning "
        "of an increment, which is too long for it; use {criterion}growth.direction: implicit, or a smaller "
        "growth.increment",
    )  # fmt: skip
    OVERLAP = (
        0.05, "largest jump of the faces", "opening, slip and K beside it are off by up to as much",
        "the faces of {place} {how} by {overlap:.2g} between contact points, {percent:.3g} % of their largest jump"
        "{of_flat}: contact holds on average over a spacing, and opening, slip and pressure there can be off by as "
        "much; use a smaller spacing",
    )  # fmt: skip
    JUMP = (
        1e-6, "strength", "bonds that break let the tip stress jump past the strength: no load factor just meets it",
        "the stress at {place} jumps to {size:.4g} times its strength at the critical load factor, where contact gives "
        "way: growth begins with more than it needs",
    )  # fmt: skip
    RIPPLE = (
        0.1, "mean pressure", "waves of contact tractions that no rock makes, and K_I with them",
        "contact tractions on {place} oscillate by {percent:.2g} % of their mean pressure within two spacings, and K_I "
        "with them: {why}; use {remedy}, or a softer contact",
    )  # fmt: skip
    SOFT_CONTACT = (
        0.1, "what a crack of its length would open under the pressure",
        "r = E'/(2k length): of the pressure on rigid faces a crack bears 1/(1 + r), within 0.04 with mortar nodes and "
        "0.06 with gauss points",
        "numerics.contact.stiffness is {stiffness:g}, soft for {place}: its faces give way to pressure by {size:.2g} "
        "of what a crack of its length would open under it, and overlap; of its pressure a crack bears about "
        "{percent:.0f} %; use {enough:.2g} or more, or rigid",
    )  # fmt: skip
    CONTACT_LAYER = (
        0.25, "spacings, E'/(2k) with gauss points",
        "the pressure falls to a closed tip over it: K_I within 5 % of its own at 0.18, 20 % off at 0.05, and of the "
        "wrong sign or size far below",
        "elastic contact with {points}: the pressure falls to a closed tip over E'/(2k), less than {much}, and K_I "
        "there is not resolved; use a rigid contact, or {other}a spacing of the size of E'/(2k)",
    )  # fmt: skip
    NEARLY_INCOMPRESSIBLE = (
        0.49, "Poisson's ratio in plane strain",
        "K within 1 % up to it, off by 3 % at 0.499 and 20 % at 0.4999; at a support of 1.5 displacements are 3 and 7 %"
        " small",
        "{place} has a Poisson's ratio of {ratio:g}{and_so}",
    )  # fmt: skip
    WIDE_SHEAR = (
        0.05, "length of the crack", "a straight crack in shear grows within 2.5 % of the toughness up to it",
        "{place} is short beside the length that shear is averaged over by cohesion and shear_toughness, "
        "{radius:.3g}: it goes by the strength, too, and grows in shear at a K_II up to {percent:.2g} % below the "
        "toughness",
    )  # fmt: skip
    SHORT_START = (
        1.0, "averaging radius", "behind it the next kink starts another crack: rows of splinters beside one wing",
        "the increment {increment:.3g} is below the averaging radius, {radius:.3g}: with growth.initiation.at: "
        "{at} a crack can start at each kink that growth makes, beside the one before; use a longer growth.increment, "
        "or ends",
    )  # fmt: skip
    MEMORY = (1.0, "memory of the machine", "the run is killed, or takes disk for memory and stands still", "{words}")
    NO_TIPS = (
        0.0, "", "nothing can grow", "{steps} growth steps are asked for, but no crack has a tip that could grow",
    )  # fmt: skip
    MOVED = (
        0.0, "", "corners and ends that nearly touch do so in the scene that is solved",
        "what nearly touches (within {share:g} of the scene's size, {metres:.2g}, or the tolerance of a map) was "
        "brought together; these were moved: {shown}",
    )  # fmt: skip
    CUT = (
        0.0, "", "cracks end where they leave the rock; what lies outside, or on another one, is missing",
        "what lies outside of the rock, on another line or nowhere was left out of cracks, {n} times: {shown}",
    )  # fmt: skip
    TINY_CRACKS = (
        1e-3, "size of the body", "lengths of a file that are read in another unit than they are in",
        "all cracks of {place} lie within {size:.2g} of its size: is the unit of their coordinates right? A file with "
        "others than the case has `units` beside it",
    )  # fmt: skip
    LEFT_OUT = (
        0.0, "", "vertices that repeat the one before them are no kinks",
        "{place}: {size} of its vertices repeat the one before them, and are left out",
    )  # fmt: skip
    TARGET = (
        0.0, "", "K, or the goal, is as good as its bounds say, but not as good as was asked for",
        "{what} is asked for within {wanted:.3g} % of the largest (numerics.accuracy), and {came}: {why}",
    )  # fmt: skip
    UNMEASURED = (
        0.0, "", "K and all else can be off by some per cent",
        "numerics.spacing is given: cells are by hand, and no error is measured; leave it out, or give an accuracy in "
        "percent, to know what K and all else are off by",
    )  # fmt: skip
    UNSTABLE = (
        1.0, "toughness", "a tip beyond its toughness is faster than v_max, so that times are too long",
        "{where} is at {size:.3g} of its toughness: it is unstable, and faster than the v_max that growth.law: "
        "subcritical gives it: the times from here on are too long",
    )  # fmt: skip
    NOTE = (0.0, "", "what a solver tells of how it came to its answer", "{words}")

    def __init__(self, limit: float, of: str, effect: str, template: str) -> None:
        self.limit, self.of, self.effect, self.template = limit, of, effect, template

    def at(self, place: str = "", size: float = 0.0, **values: object) -> StepWarning:
        """What to say of a place; of warnings of one cause the larger `size` is the worse."""
        words = self.template.format(place=place, size=size, limit=self.limit, **values)
        return StepWarning(self, words, place, float(size))


RANK = {cause: number for number, cause in enumerate(WarningCause)}


@dataclass(frozen=True, slots=True)
class StepWarning:
    """One thing that makes the results of a step doubtful."""

    cause: WarningCause
    words: str  # a sentence of this place alone
    place: str = ""  # "crack 'flaw'", "the end of crack 'flaw'"; empty: the whole scene
    size: float = 0.0  # of warnings of one cause the larger is the worse; may be infinite

    @property
    def rank(self) -> int:
        """The smaller the more important."""
        return RANK[self.cause]
