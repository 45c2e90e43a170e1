"""What a case says, checked and in SI units: frozen data without behaviour.

A field that is a key of the case format has its line in `Doc`, and what it takes in the spec before it, unless its
type says that: see `declared`. The others follow from the geometry.
"""

from __future__ import annotations

from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Final, Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.accuracy import AUTO, MOST_ASKED_FOR, STANDARD, TARGETS, target_of
from crackgrow.case.declared import ByName, Doc
from crackgrow.case.formula import Component, Formula, OrFormula, component_at
from crackgrow.case.read_only import read_only
from crackgrow.case.regions import EdgeRegion
from crackgrow.case.scalars import (
    NOT_NEGATIVE,
    POSITIVE,
    Bounds,
    Choice,
    Integer,
    Number,
    Quantity,
    Share,
    Text,
    WordOr,
)
from crackgrow.case.schema import BY_PARTS, OPTIONAL, Field, ListOf, Mapping, Same
from crackgrow.case.spellings import DISPLACEMENT, PAIR, PATH, POINT, REGION, SHAPE, SIZE, TRACTION
from crackgrow.case.surface import SurfaceName, crack_name
from crackgrow.vectors import across

__all__ = ["Component", "EdgeRegion", "Formula"]  # with the classes of this module

MODULUS: Final = Quantity("stress", POSITIVE)
COHESION: Final = Quantity("stress", NOT_NEGATIVE)
ACUTE: Final = Quantity("angle", Bounds(at_least=0, below=90))


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """Isotropic linear elasticity."""

    young: Annotated[float, MODULUS, Doc("Young's modulus")]  # Pa
    poisson: Annotated[float, Number(Bounds(above=-1, at_most=0.5)), Doc("Poisson's ratio")]
    density: Annotated[float | None, Quantity("density", POSITIVE), Doc("mass density")] = None  # kg/m^3


@dataclass(frozen=True, slots=True, eq=False)
class Strength:
    """Tension cut-off and Mohr-Coulomb shear strength."""

    tension: Annotated[float, MODULUS, Doc("tensile strength")]  # Pa
    cohesion: Annotated[float, COHESION, Doc("cohesion of the intact rock")]  # Pa
    friction_angle: Annotated[float, ACUTE, Doc("angle of internal friction")]  # degrees
    toughness: Annotated[
        float | None,
        Quantity("toughness", POSITIVE),
        Doc("K_Ic, at which tips open; gives the averaging radius"),
    ] = None  # Pa sqrt(m)
    shear_toughness: Annotated[
        float | None,
        Quantity("toughness", POSITIVE),
        Doc("K_IIc, at which tips grow in shear; left out: by the cohesion"),
    ] = None  # Pa sqrt(m)


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed line round rock, which lies on its left: an outline runs counter-clockwise, a hole clockwise."""

    points: Floats  # (n, 2) m, corners, not closed
    edge_names: tuple[str, ...]  # (n,): name of the edge that the side from corner i to corner i + 1 belongs to


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One piece of rock. Its sides are numbered ring by ring."""

    name: str
    rings: Annotated[
        tuple[Ring, ...], SHAPE, Doc("outline of the body", key="shape", drawn=True)
    ]  # the outline, then the holes
    material: Annotated[Material, ByName("material", "materials"), Doc("elastic constants")]
    strength: Annotated[Strength | None, Doc("strength of the rock, where cracks may grow", default=OPTIONAL)]

    @property
    def outline(self) -> Floats:
        """Corners (n, 2) m of the outline."""
        return self.rings[0].points


@dataclass(frozen=True, slots=True, eq=False)
class Wear:
    """What faces are after slips, from `friction` and `dilation_angle` of the law on."""

    slip: Annotated[tuple[float, ...], ListOf(SIZE), Doc("slips, rising")]  # m
    friction: Annotated[tuple[float, ...], ListOf(Number(NOT_NEGATIVE)), Doc("friction after each")]
    dilation_angle: Annotated[
        tuple[float, ...] | None, ListOf(ACUTE), Doc("dilation angle after each; left out: as it was")
    ] = None  # degrees


STEEPEST: Final = 70.0
"""Degrees: friction of rough faces under little pressure (Barton, Choubey 1977)."""


@dataclass(frozen=True, slots=True, eq=False)
class Barton:
    """Shear strength of rough faces, p tan(phi + JRC log10(JCS / p)), with tan(phi) the `friction` of the law."""

    jrc: Annotated[float, Number(Bounds(above=0, at_most=20)), Doc("joint roughness coefficient")]
    jcs: Annotated[float, MODULUS, Doc("compressive strength of the joint's walls")]  # Pa


@dataclass(frozen=True, slots=True, eq=False)
class CoulombContact:
    """Coulomb friction with cohesion on closed faces, |p_t| <= c - mu p_n, and what slip makes of it.

    A point that has slipped or opened is broken: friction falls to its residual value, tensile strength is lost, and
    cohesion unless it is kept. Slip over asperities opens the faces by tan(dilation angle) |slip|.
    """

    friction: Annotated[float, Number(NOT_NEGATIVE), Doc("Coulomb's friction coefficient")]
    cohesion: Annotated[float, COHESION, Doc("cohesion of the closed faces", default=0.0)]  # Pa
    tension: Annotated[
        float,
        COHESION,
        Doc("tensile strength; none once faces have opened or slipped"),
    ] = field(default=0.0, kw_only=True)  # Pa
    residual_friction: Annotated[
        float,
        Number(NOT_NEGATIVE),
        Doc("friction of points that have slipped or opened", default=Same("friction")),
    ]
    cohesion_kept: Annotated[
        bool,
        Choice(("lost", "kept"), ("none is left", "stays where the point is closed")),
        Doc("cohesion of points that slipped or opened", key="cohesion_after_slip"),
    ] = False
    dilation_angle: Annotated[float, ACUTE, Doc("psi: slip opens faces by tan(psi)")] = 0.0  # degrees
    weakening_length: Annotated[
        float,
        SIZE,
        Doc(
            "slip over which friction, cohesion, tension fall linearly; left out: at once",
            default=OPTIONAL,
        ),
    ] = 0.0  # m
    decay_length: Annotated[
        float,
        SIZE,
        Doc("in its place: slip after which 1/e of what can be lost is left", default=OPTIONAL),
    ] = 0.0  # m
    residual_dilation_angle: Annotated[
        float | None, ACUTE, Doc("dilation angle after that; left out: it does not wear")
    ] = None  # degrees
    wear: Annotated[Wear | None, Doc("friction and dilation angle after slips, linear between them")] = None
    stiffness: Annotated[
        tuple[float, float] | None,
        Mapping(
            {
                "normal": Field(Quantity("stiffness", POSITIVE), "pressure per closure"),
                "shear": Field(Quantity("stiffness", POSITIVE), "shear stress per elastic slip"),
            }
        ),
        Doc("stiffness of the joint, in place of numerics.contact.stiffness"),
    ] = None  # Pa/m: normal, shear; None: that of the numerics
    max_closure: Annotated[
        float | None,
        SIZE,
        Doc("largest closure of a hyperbolic joint (Bandis); left out: linear"),
    ] = None  # m
    barton: Annotated[Barton | None, Doc("friction is tan(phi + JRC log10(JCS/p)), tan(phi) = friction")] = None

    @property
    def worn(self) -> tuple[float, float]:
        """Friction and dilation angle (degrees) where slip has taken all."""
        friction, angle = self.residual_friction, self.residual_dilation_angle
        if self.wear is not None:
            friction = self.wear.friction[-1]
            angle = self.wear.dilation_angle[-1] if self.wear.dilation_angle else None
        return friction, self.dilation_angle if angle is None else angle

    @property
    def without_bond(self) -> CoulombContact:
        """The law of faces that are broken from the start."""
        friction, angle = self.worn
        bare = replace(self, friction=friction, residual_friction=friction, dilation_angle=angle, wear=None)
        return replace(bare, cohesion=0.0, tension=0.0, residual_dilation_angle=None)


@dataclass(frozen=True, slots=True, eq=False)
class Crack:
    """A pre-existing crack: an open polyline."""

    name: str
    points: Annotated[Floats, PATH, Doc("where the crack runs", key="path", drawn=True)]  # (n, 2) m, from start to end
    tip_at_start: bool  # whether the start can grow; an end in rock, on no other crack, is a singular tip all the same
    tip_at_end: bool
    contact: Annotated[
        CoulombContact | None,
        ByName("law", "laws", ("none",)),
        Doc("law of the closed faces; none: they never touch"),
    ]
    body: str  # the body that it lies in
    left_out: int = 0  # vertices that were given besides: each repeats the one before it

    @property
    def surface(self) -> SurfaceName:
        """Which surface it is."""
        return crack_name(self.name)


@dataclass(frozen=True, slots=True, eq=False)
class Interface:
    """Where two bodies share a boundary."""

    bodies: Annotated[tuple[str, str], PAIR, Doc("names of two bodies that share a boundary", key="between")]
    lines: tuple[Floats, ...]  # each (n, 2) m, open polylines; the first body lies on the left
    contact: Annotated[
        CoulombContact | Literal["bonded"],
        ByName("law", "laws", ("bonded",)),
        Doc("law of the common faces; bonded: they never part or slip"),
    ]

    @property
    def surface(self) -> SurfaceName:
        """Which surface all of its lines are."""
        return SurfaceName("interface", self.bodies)


OfPoint = Annotated[str, Doc("the body, if the point lies on more than one", default=OPTIONAL, drawn=True)]
OnlyBody = Annotated[str, Doc("name of a body; may be left out where there is one", default=OPTIONAL)]
At = Annotated[Floats, POINT, Doc("a point, [x, y]", key="at", drawn=True)]
Displacement = Annotated[tuple[Component | None, Component | None], DISPLACEMENT, Doc("prescribed displacement")]


@dataclass(frozen=True, slots=True, eq=False)
class PointSupport:
    """Displacement prescribed at a point of a body; a component that is None is free."""

    body: OfPoint
    point: At  # (2,) m
    displacement: Displacement  # m


OnEdge = Annotated[
    EdgeRegion,
    REGION,
    Doc(
        "an edge or a part of one; in YAML 1.1: along",
        key="on",
        also=("along", "true"),
        drawn=True,
    ),
]


@dataclass(frozen=True, slots=True, eq=False)
class EdgeSupport:
    """Displacement prescribed along an edge; a component that is None is free."""

    region: OnEdge
    displacement: Displacement  # m


@dataclass(frozen=True, slots=True, eq=False)
class ContactSupport:
    """A rigid foundation under an edge, which the body can lift off from."""

    region: OnEdge
    contact: Annotated[CoulombContact, ByName("law", "laws"), Doc("law of the contact with a rigid foundation")]

    @property
    def surface(self) -> SurfaceName:
        """Which surface it is, but for its number among several on one edge."""
        return SurfaceName("foundation", (self.region.body, self.region.edge))


Held = Annotated[bool, Doc("acts in full at every load factor")]
LoadName = Annotated[str | None, Doc("name, by which stages give it factors")]


@dataclass(frozen=True, slots=True, eq=False)
class EdgeTraction:
    """Traction on an edge."""

    region: OnEdge
    traction: Annotated[tuple[Component, Component], TRACTION, Doc("force per area, [x, y]")]  # Pa
    held: Held = False
    name: LoadName = None

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the edge with unit normals (n, 2) out of the rock."""
        return np.stack([component_at(component, places) for component in self.traction], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class EdgePressure:
    """Pressure of a fluid on an edge, such as the wall of a borehole or a face below water."""

    region: OnEdge
    pressure: Annotated[
        Component,
        OrFormula("stress"),
        Doc("fluid pressure on the edge, or on both faces; negative: it pulls"),
    ]  # Pa, positive pushes into the rock
    held: Held = False
    name: LoadName = None

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the edge with unit normals (n, 2) out of the rock."""
        return -component_at(self.pressure, places)[:, None] * outward


@dataclass(frozen=True, slots=True, eq=False)
class FarField:
    """Traction of a stress, far away, on the outline of a body."""

    body: OnlyBody
    stress: Annotated[
        tuple[Component, Component, Component],
        ListOf(OrFormula("stress"), 3),
        Doc("stress [xx, yy, xy] whose traction acts on the outline", key="far_field"),
    ]  # Pa
    region: EdgeRegion  # the outline, as far as no other body lies there
    held: Held = False
    name: LoadName = None

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the outline with unit normals (n, 2) out of the rock."""
        return across(np.stack([component_at(component, places) for component in self.stress], axis=1), outward)


EdgeLoad = EdgeTraction | EdgePressure | FarField


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """Weight of a body."""

    body: OnlyBody
    acceleration: Annotated[
        tuple[float, float], ListOf(Quantity("acceleration"), 2), Doc("acceleration, [x, y]", key="gravity")
    ]  # m/s^2
    held: Held = False
    name: LoadName = None


@dataclass(frozen=True, slots=True, eq=False)
class FluidPressure:
    """Pressure of a fluid on both faces of a crack or of an interface."""

    surface: SurfaceName  # a crack, or an interface with all of its lines
    pressure: Annotated[
        Component, OrFormula("stress"), Doc("pressure of a fluid on both faces; negative: it pulls")
    ]  # Pa, positive pushes the faces apart
    held: Held = False
    name: LoadName = None


@dataclass(frozen=True, slots=True, eq=False)
class InSituStress:
    """Stress that a body holds before anything displaces."""

    body: OnlyBody
    stress: Annotated[
        tuple[Component, Component, Component],
        ListOf(OrFormula("stress"), 3),
        Doc("in-situ stress, [xx, yy, xy]"),
    ]  # Pa
    held: Held = False
    name: LoadName = None


@dataclass(frozen=True, slots=True, eq=False)
class PointForce:
    """A force at a point of a body."""

    point: At  # (2,) m
    force: Annotated[
        tuple[float, float], ListOf(Quantity("force"), 2), Doc("force per thickness, [x, y]")
    ]  # N per metre of thickness
    body: OfPoint
    held: Held = False
    name: LoadName = None


Support = PointSupport | EdgeSupport | ContactSupport
Load = EdgeTraction | EdgePressure | FarField | Gravity | FluidPressure | InSituStress | PointForce


@dataclass(frozen=True, slots=True, eq=False)
class LoadHistory:
    """Factors of the loads that are not held, applied in turn; friction remembers."""

    factors: tuple[float, ...]
    increments: int | None = None  # of each load; None: they go from event to event


@dataclass(frozen=True, slots=True, eq=False)
class CriticalLoad:
    """Every step takes the factor at which the criterion is just met."""


@dataclass(frozen=True, slots=True, eq=False)
class StrengthReduction:
    """Friction and cohesion of contact are divided by a factor until the scene fails, under all of its loads."""

    factors: tuple[float, ...] = (1.0,)  # of the loads


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """What holds at the end of a stage; on the way there all of it changes in proportion."""

    name: str
    factor: float  # of given displacements, and of loads that are neither held nor named by stages
    loads: tuple[tuple[str, float], ...]  # factors of the loads that stages name
    excavated: tuple[tuple[str, float], ...]  # bodies that are gone, and the share of what they did that is released


@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """Stages in turn; friction remembers."""

    before: Stage  # what holds before the first one
    stages: tuple[Stage, ...]


Loading = LoadHistory | CriticalLoad | StrengthReduction | Stages


@dataclass(frozen=True, slots=True)
class Initiation:
    """Where cracks start."""

    at: Annotated[
        Literal["tips", "ends", "cracks", "outlines", "anywhere"],
        Doc(
            "where cracks may start",
            (
                "nowhere new",
                "ends of given cracks that a wing has grown from",
                "kinks, beside wings, behind a crack that another one ends on",
                "also outlines and holes",
                "also within the rock",
            ),
            short=True,
        ),
    ] = "tips"
    spacing: Annotated[
        float | None,
        WordOr((AUTO,), SIZE),
        Doc("distance of these; auto: the larger of increment and averaging radius"),
    ] = None  # m


@dataclass(frozen=True, slots=True)
class Subcritical:
    """How fast tips grow below the toughness: v = v_max (K / K_c)^n."""

    velocity: Annotated[float, Quantity("velocity", POSITIVE), Doc("v_max in v = v_max (K/K_c)^n")]  # m/s
    exponent: Annotated[float, Number(Bounds(at_least=0, at_most=200)), Doc("n")]
    threshold: Annotated[float, Number(Bounds(at_least=0, below=1)), Doc("K/K_c up to which a tip stands still")] = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """How cracks grow."""

    steps: Annotated[
        int, Integer(Bounds(at_least=0, at_most=10000)), Doc("growth steps; 0: the criterion is evaluated only")
    ]
    increment: Annotated[float, SIZE, Doc("length added to a tip in one step")]  # m
    advance: Annotated[
        Literal["most_critical", "in_turn", "all"],
        Doc(
            "tips that advance in a step",
            (
                "one tip a step",
                "one of the least grown",
                "every tip that meets the criterion",
            ),
            default="all",
        ),
    ]
    criterion: Annotated[
        Literal["strength", "directional_strength", "max_hoop_stress"],
        Doc(
            "when and where a tip grows",
            (
                "across the averaged major principal stress, else on a Mohr-Coulomb plane",
                "the ray with the largest hoop tension or shear over strength",
                "largest hoop stress, from K_I and K_II",
            ),
        ),
    ]
    direction: Annotated[
        Literal["explicit", "implicit"],
        Doc(
            "left out: implicit for max_hoop_stress with a toughness",
            ("that at the old tip", "K_II vanishes at the new tip; max_hoop_stress alone"),
            default=OPTIONAL,
        ),
    ]
    tip_radius: Annotated[
        float | None,
        Mapping({"radius": Field(SIZE, "Shepard averaging radius, a material length")}, short="radius"),
        Doc("in place of a toughness", key="tip_stress", default=OPTIONAL),
    ]  # m
    unload_between_steps: Annotated[bool, Doc("every step starts unloaded; false: friction remembers")] = True
    initiation: Annotated[Initiation, Doc("where new cracks start")] = Initiation()
    link_distance: Annotated[
        float | None,
        WordOr((AUTO,), SIZE),
        Doc("a segment that comes this close to another crack ends on it; auto: a tenth of increment"),
    ] = None  # m
    law: Annotated[
        Literal["critical", "subcritical"],
        Doc(
            "what lets a tip grow",
            (
                "where the criterion is met",
                "by a velocity that follows from K/K_c",
            ),
        ),
    ] = "critical"
    subcritical: Annotated[Subcritical | None, Doc("how fast tips grow, with law: subcritical")] = None


@dataclass(frozen=True, slots=True, eq=False)
class ContactNumerics:
    """How the contact problem is discretized and solved."""

    stiffness: Annotated[
        float | None,
        WordOr(
            ("rigid",),
            Number(
                POSITIVE,
                note=", kappa of k = kappa E / h without a unit; that of a joint in Pa/m is `stiffness` of its contact",
            ),
        ),
        Doc("rigid, or kappa in k = kappa E / h"),
    ] = None
    discretization: Annotated[
        Literal["mortar", "gauss"],
        Doc(
            "where contact is enforced",
            ("on average round nodes", "needs a finite stiffness"),
        ),
    ] = "mortar"
    solver: Annotated[
        Literal["newton", "lemke"],
        Doc(
            "how the contact problem is solved",
            ("semismooth Newton", "pivoting, slow with many points"),
        ),
    ] = "newton"
    spacing: Annotated[float, Number(Bounds(at_least=0.5, at_most=4)), Doc("least distance of contact nodes, in h")] = (
        1.25
    )


Levels = int | Literal["auto"]
LEVELS: Final = WordOr((AUTO,), Integer(Bounds(at_least=0, at_most=MOST_ASKED_FOR)))


@dataclass(frozen=True, slots=True)
class Refinement:
    """Refinement levels at features: how often cells of the spacing are halved; auto: as accuracy asks."""

    tips: Annotated[
        Levels,
        LEVELS,
        Doc("refinement levels at crack tips; auto: what accuracy asks for", default=OPTIONAL),
    ] = 0
    kinks: Annotated[Levels, LEVELS, Doc("the same at kinks, meetings and ends of cracks", default=OPTIONAL)] = 0
    corners: Annotated[
        Levels,
        LEVELS,
        Doc(
            "at re-entrant corners, ends of loaded and supported parts; auto: also at holes, in narrow rock",
            default=OPTIONAL,
        ),
    ] = 0
    rings: Annotated[float, Number(Bounds(at_least=2, at_most=8)), Doc("cells of each size on every side of these")] = (
        2.0
    )


Goal = Literal["K", "slip", "reaction", "load_factor"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Numerics:
    """Settings of the discretization."""

    accuracy: Annotated[
        str | float,
        WordOr(
            tuple(TARGETS),
            Share(Bounds(at_least=0.001, at_most=0.2)),
            tuple(f"{100.0 * target:g} %" for target in TARGETS.values()),
        ),
        Doc("largest error estimate of the goal, over its largest value"),
    ] = STANDARD
    goal: Annotated[
        Goal,
        Doc(
            "quantity that accuracy is of",
            (
                "stress intensity",
                "of all faces",
                "of supports and surfaces",
                "the critical load factor",
            ),
        ),
    ] = "K"
    spacing: Annotated[
        float, WordOr((AUTO,), SIZE), Doc("lattice spacing h", default=AUTO)
    ]  # m, side of the largest cells
    auto_rule: Annotated[str | None, Doc("what gave an automatic spacing", offered=False)] = (
        None  # None: the spacing was given
    )
    support: Annotated[
        float, Number(Bounds(at_least=1.25, at_most=4), 0.25), Doc("half width of a patch, in spacings")
    ] = 2.0
    quadrature: Annotated[
        int, Integer(Bounds(at_least=2, at_most=10)), Doc("Gauss points per direction on an uncut cell")
    ] = 3
    refine: Annotated[Refinement, Doc("refinement levels, and where")] = Refinement()
    tip_functions: Annotated[
        Literal["auto", "patch", "gathered"],
        Doc(
            "functions that follow the singular stress at tips",
            (
                "gathered where refine.tips is not 0",
                "on every patch that a tip lies in",
                "one set a tip, if it has room",
            ),
        ),
    ] = "auto"
    contact: Annotated[ContactNumerics, Doc("how contact is discretized and solved")] = ContactNumerics()

    @property
    def target(self) -> float:
        """What the error estimate of the goal may be, over its largest value, where cells are chosen for it."""
        return target_of(self.accuracy)

    @property
    def measured(self) -> bool:
        """Whether the run chooses its cells and measures its error: the spacing is automatic, or a target a number."""
        return self.auto_rule is not None or not isinstance(self.accuracy, str)

    @property
    def gathers_tip_functions(self) -> bool:
        """Whether the functions of tips with room are gathered: they take several cells, so in small ones."""
        return self.tip_functions == "gathered" or (self.tip_functions == "auto" and self.refine.tips != 0)


@dataclass(frozen=True, slots=True, eq=False)
class RockPoint:
    """A point of a body: displacement and stress."""

    name: str
    point: Annotated[
        Floats, POINT, Doc("a point of the rock, [x, y]: its displacement and stress", key="at", drawn=True)
    ]  # (2,) m
    body: OfPoint


@dataclass(frozen=True, slots=True, eq=False)
class FacePoint:
    """A place on a crack or an interface: opening and slip."""

    name: str
    surface: SurfaceName  # a crack, or an interface with all of its lines
    point: Annotated[
        Floats, POINT, Doc("where on it, [x, y]; at the mouth of a crack the crack-mouth opening", key="at", drawn=True)
    ]  # (2,) m


@dataclass(frozen=True, slots=True, eq=False)
class PointPair:
    """Two points: by how much they come closer."""

    name: str
    bodies: tuple[str, str]
    points: Annotated[
        Floats, ListOf(POINT, 2), Doc("two points of the rock: how much they converge", key="between", drawn=True)
    ]  # (2, 2) m


HistoryPoint = RockPoint | FacePoint | PointPair
FIELDS: Final = ("displacement", "stress", "energy_error")


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """What is written."""

    frames: Annotated[Literal["every_step", "first_and_last", "none"], Doc("steps written as frames")] = "every_step"
    fields: Annotated[tuple[str, ...], ListOf(Choice(FIELDS)), Doc("fields in a frame")] = ("displacement", "stress")
    figures: Annotated[bool, Doc("draw pictures and plots")] = True
    report: Annotated[bool, Doc("write report.html at the end")] = True
    points: tuple[HistoryPoint, ...] = ()  # whose course is written


@dataclass(frozen=True, slots=True)
class Move:
    """A point of a case that was brought to what it nearly touched."""

    what: str  # such as "the end of crack 'joint'"
    onto: str  # such as "the boundary of body 'rock'"
    distance: float  # m
    place: tuple[float, float]  # m, where it is now
    end: tuple[str, str] | None = None  # the crack, and `start` or `end`, of which it is the end


@dataclass(frozen=True, slots=True)
class Cut:
    """What of a crack was left out, such as what lies outside of the rock."""

    crack: str  # its name, of a line of a map that of the set with the number of the line
    length: float  # m, of what was left out; 0 where none of its length was
    whole: bool  # whether all of the crack was
    place: tuple[float, float]  # m, a point of it
    why: str
    where: str = ""  # in the file of a map, such as "feature 12"


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A whole scene. `resolved` is what was read, a mapping in the case format, SI, with all defaults; read-only.

    A case that is changed by `dataclasses.replace` is written as its fields are. What is drawn, the outlines, paths and
    places, is written as it was read; where that is changed the case cannot be written.
    """

    name: str
    title: Annotated[str, Doc("what the scene is")]
    source: Annotated[str, Text(may_be_empty=True), Doc("where the scene comes from", default="")]
    plane: Annotated[
        Literal["strain", "stress"],
        Doc("plane strain or plane stress", ("a long body, no strain across", "a thin plate, no stress across")),
    ]
    bodies: tuple[Body, ...]
    cracks: tuple[Crack, ...]
    interfaces: tuple[Interface, ...]
    supports: tuple[Support, ...]
    loads: tuple[Load, ...]
    loading: Loading
    growth: Annotated[Growth | None, Doc("how cracks grow; left out: one static solve", default=OPTIONAL)]
    numerics: Annotated[Numerics, Doc("settings of the discretization", default=BY_PARTS)]
    output: Annotated[Output, Doc("what is written", default=BY_PARTS)]
    resolved: dict[str, object]
    origin: tuple[float, float] = (0.0, 0.0)  # m on a map: places are seen from there, in `resolved` on the map
    moved: tuple[Move, ...] = ()  # farther than rounding; `resolved` has the points where they were given
    cut: tuple[Cut, ...] = ()  # more than rounding; `resolved` has what is left

    def __repr__(self) -> str:
        return f"<Case {self.name}: {self.title}>"

    def __post_init__(self) -> None:
        object.__setattr__(self, "resolved", read_only(self.resolved))

    @classmethod
    def from_dict(cls, mapping: AnyMapping[str, Any], name: str = "case") -> Case:
        """The checked case of a mapping in the case format; raises CaseError with every fault."""
        from crackgrow.case.dump import case_from  # it stands on the classes of this module

        return case_from(mapping, name)

    def to_dict(self) -> dict[str, Any]:
        """The case as a mapping in the case format, as `case.yaml` of a run: SI, every default filled in."""
        from crackgrow.case.dump import mapping_of  # it stands on the classes of this module

        return mapping_of(self)

    def with_(self, *settings: str) -> Case:
        """The case with settings such as "numerics.spacing=1 mm"; bare numbers are in SI."""
        from crackgrow.case.dump import changed  # it stands on the classes of this module

        return changed(self, settings)

    @property
    def last_step(self) -> int:
        """Number of the last step, counted from 0, if nothing ends the run before."""
        if self.growth is not None:
            return self.growth.steps
        return 1 if isinstance(self.loading, StrengthReduction) else self.n_loads - 1

    @property
    def subcritical(self) -> Subcritical | None:
        """How fast tips grow; None where growth takes no time."""
        return None if self.growth is None else self.growth.subcritical

    @property
    def n_loads(self) -> int:
        """Number of load factors that are given, or of stages; 1 where factors are found."""
        if isinstance(self.loading, Stages):
            return len(self.loading.stages)
        return len(self.loading.factors) if isinstance(self.loading, LoadHistory) else 1
