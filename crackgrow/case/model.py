"""What a case says, checked and in SI units: frozen data without behaviour.

What keys mean, and what they take, is declared in `format.yaml`; fields that are no keys follow from the geometry.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Final, Literal

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.accuracy import STANDARD, target_of
from crackgrow.case.formula import Component, Formula, component_at
from crackgrow.case.regions import EdgeRegion
from crackgrow.case.shapes import Ring, Ringed
from crackgrow.case.surface import SurfaceName, crack_name
from crackgrow.vectors import across

__all__ = ["Component", "EdgeRegion", "Formula"]  # with the classes of this module

STEEPEST: Final = 70.0
"""Degrees: friction of rough faces under little pressure (Barton, Choubey 1977)."""


@dataclass(frozen=True, slots=True)
class ElasticBedding:
    """What planes of bedding or foliation make of elasticity: transversely isotropic about their normal."""

    angle: float  # degrees, of the planes
    young: float  # Pa, across them
    poisson: float  # strain along them over that across, of stress across
    shear: float | None = None  # Pa; None: Saint-Venant's


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """Linear elasticity: isotropic, or with bedding, along whose planes `young` and `poisson` then are."""

    young: float  # Pa
    poisson: float
    density: float | None = None  # kg/m^3
    bedding: ElasticBedding | None = None

    @property
    def least_young(self) -> float:
        """The least Young's modulus (Pa) of all directions along and across planes."""
        return self.young if self.bedding is None else min(self.young, self.bedding.young)


@dataclass(frozen=True, slots=True)
class Bedding:
    """What a crack that runs along planes of bedding or foliation opens at."""

    angle: float  # degrees, of the planes
    tension: float | None = None  # Pa
    toughness: float | None = None  # Pa sqrt(m)


@dataclass(frozen=True, slots=True, eq=False)
class Strength:
    """Tension cut-off and Mohr-Coulomb shear strength; with bedding, tension and toughness are those across it."""

    tension: float  # Pa
    cohesion: float  # Pa
    friction_angle: float  # degrees
    toughness: float | None = None  # Pa sqrt(m)
    shear_toughness: float | None = None  # Pa sqrt(m)
    bedding: Bedding | None = None


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Drawn:
    """What is drawn: the geometry of it follows from keys that are no fields."""

    given: Mapping[str, Any] = field(default_factory=dict, repr=False)  # these keys as they were read, in SI


@dataclass(frozen=True, slots=True, eq=False)
class Body(Drawn, Ringed):
    """One piece of rock. Its sides are numbered ring by ring."""

    name: str
    rings: tuple[Ring, ...]
    material: Material
    strength: Strength | None


@dataclass(frozen=True, slots=True, eq=False)
class Wear:
    """What faces are after slips, from `friction` and `dilation_angle` of the law on."""

    slip: tuple[float, ...]  # m
    friction: tuple[float, ...]
    dilation_angle: tuple[float, ...] | None = None  # degrees


@dataclass(frozen=True, slots=True, eq=False)
class Barton:
    """Shear strength of rough faces, p tan(phi + JRC log10(JCS / p)), with tan(phi) the `friction` of the law."""

    jrc: float
    jcs: float  # Pa


@dataclass(frozen=True, slots=True, eq=False)
class CoulombContact:
    """Coulomb friction with cohesion on closed faces, |p_t| <= c - mu p_n, and what slip makes of it.

    A point that has slipped or opened is broken: friction falls to its residual value, tensile strength is lost, and
    cohesion unless it is kept. Slip over asperities opens the faces by tan(dilation angle) |slip|.
    """

    friction: float
    cohesion: float  # Pa
    tension: float = field(default=0.0, kw_only=True)  # Pa
    residual_friction: float
    cohesion_kept: bool = False
    dilation_angle: float = 0.0  # degrees
    weakening_length: float = 0.0  # m
    decay_length: float = 0.0  # m
    residual_dilation_angle: float | None = None  # degrees
    wear: Wear | None = None
    stiffness: tuple[float, float] | None = None  # Pa/m: normal, shear; None: that of the numerics
    max_closure: float | None = None  # m
    barton: Barton | None = None

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
class Crack(Drawn):
    """A pre-existing crack: an open polyline."""

    name: str
    points: Floats  # (n, 2) m, from start to end
    tip_at_start: bool  # whether the start can grow; an end in rock, on no other crack, is a singular tip all the same
    tip_at_end: bool
    contact: CoulombContact | None
    body: str  # the body that it lies in
    left_out: int = 0  # vertices that were given besides: each repeats the one before it

    @property
    def surface(self) -> SurfaceName:
        """Which surface it is."""
        return crack_name(self.name)


@dataclass(frozen=True, slots=True, eq=False)
class Interface(Drawn):
    """Where two bodies share a boundary."""

    bodies: tuple[str, str]
    lines: tuple[Floats, ...]  # each (n, 2) m, open polylines; the first body lies on the left
    contact: CoulombContact | Literal["bonded"]
    toughness: float | None = None  # J/m^2, at which its cracked part grows
    beside_crack: bool = False  # whether it is what is bonded of a boundary that has, or may get, a cracked part
    boundary: tuple[Floats, ...] = ()  # all lines of such a boundary, each (n, 2) m

    @property
    def surface(self) -> SurfaceName:
        """Which surface all of its lines are."""
        return SurfaceName("bond" if self.beside_crack else "interface", self.bodies)


@dataclass(frozen=True, slots=True, eq=False)
class PointSupport(Drawn):
    """Displacement prescribed at a point of a body; a component that is None is free."""

    body: str
    point: Floats  # (2,) m
    displacement: tuple[Component | None, Component | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class EdgeSupport(Drawn):
    """Displacement prescribed along an edge; a component that is None is free."""

    region: EdgeRegion
    displacement: tuple[Component | None, Component | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class ContactSupport(Drawn):
    """A rigid foundation under an edge, which the body can lift off from; or a platen that moves."""

    region: EdgeRegion
    contact: CoulombContact
    moves: tuple[float, float] = (0.0, 0.0)  # m, at load factor 1

    @property
    def surface(self) -> SurfaceName:
        """Which surface it is, but for its number among several on one edge."""
        return SurfaceName("foundation", (self.region.body, self.region.edge))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Loaded(Drawn):
    """A load."""

    held: bool = False  # whether it acts in full at every load factor
    name: str | None = None  # by which stages give it factors


@dataclass(frozen=True, slots=True, eq=False)
class EdgeTraction(Loaded):
    """Traction on an edge."""

    region: EdgeRegion
    traction: tuple[Component, Component]  # Pa

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the edge with unit normals (n, 2) out of the rock."""
        return np.stack([component_at(component, places) for component in self.traction], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class EdgePressure(Loaded):
    """Pressure of a fluid on an edge, such as the wall of a borehole or a face below water."""

    region: EdgeRegion
    pressure: Component  # Pa, positive pushes into the rock

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the edge with unit normals (n, 2) out of the rock."""
        return -component_at(self.pressure, places)[:, None] * outward


@dataclass(frozen=True, slots=True, eq=False)
class FarField(Loaded):
    """Traction of a stress, far away, on the outline of a body."""

    body: str
    stress: tuple[Component, Component, Component]  # Pa
    region: EdgeRegion  # the outline, as far as no other body lies there

    def traction_at(self, places: Floats, outward: Floats) -> Floats:
        """Traction (n, 2) Pa at places (n, 2) m of the outline with unit normals (n, 2) out of the rock."""
        return across(np.stack([component_at(component, places) for component in self.stress], axis=1), outward)


EdgeLoad = EdgeTraction | EdgePressure | FarField


@dataclass(frozen=True, slots=True, eq=False)
class Gravity(Loaded):
    """Weight of a body."""

    body: str
    acceleration: tuple[float, float]  # m/s^2


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fluid(Loaded):
    """A fluid between faces."""

    surface: SurfaceName  # a crack, or an interface with all of its lines
    connected: bool = False  # whether it enters cracks that touch
    beyond: tuple[SurfaceName, ...] = ()  # other cracks that it has entered

    def fills(self, name: SurfaceName) -> bool:
        """Whether it is between the faces of a crack or of a line of an interface."""
        return name.is_of(self.surface) or name in self.beyond


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FluidPressure(Fluid):
    """Pressure of a fluid on both faces of cracks or of an interface."""

    pressure: Component  # Pa, positive pushes the faces apart


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FluidVolume(Fluid):
    """Volume of a fluid between the faces of cracks, at the pressure that it takes."""

    volume: float  # m^2, per metre of thickness


@dataclass(frozen=True, slots=True, eq=False)
class InSituStress(Loaded):
    """Stress that a body holds before anything displaces."""

    body: str
    stress: tuple[Component, Component, Component]  # Pa


@dataclass(frozen=True, slots=True, eq=False)
class PointForce(Loaded):
    """A force at a point of a body."""

    point: Floats  # (2,) m
    force: tuple[float, float]  # N per metre of thickness
    body: str


Support = PointSupport | EdgeSupport | ContactSupport
Load = EdgeTraction | EdgePressure | FarField | Gravity | FluidPressure | FluidVolume | InSituStress | PointForce


@dataclass(frozen=True, slots=True, eq=False)
class LoadHistory:
    """Factors of the loads that are not held, applied in turn; friction remembers."""

    factors: tuple[float, ...]
    increments: int | Literal["events"] | None = None  # of each load, or from event to event; None: as laws need it

    @property
    def grows(self) -> bool:
        """Whether each load goes on where the one before has ended."""
        steps = [last - first for first, last in pairwise((0.0, *self.factors))]
        return all(step >= 0.0 for step in steps) or all(step <= 0.0 for step in steps)


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
class Stages(Drawn):
    """Stages in turn; friction remembers."""

    before: Stage  # what holds before the first one
    stages: tuple[Stage, ...]


Loading = LoadHistory | CriticalLoad | StrengthReduction | Stages


@dataclass(frozen=True, slots=True)
class Initiation:
    """Where cracks start."""

    at: Literal["tips", "ends", "cracks", "outlines", "anywhere"] = "tips"
    spacing: float | None = None  # m


@dataclass(frozen=True, slots=True)
class Subcritical:
    """How fast tips grow below the toughness: v = v_max (K / K_c)^n."""

    velocity: float  # m/s
    exponent: float
    threshold: float = 0.0


@dataclass(frozen=True, slots=True)
class Fatigue:
    """How far tips grow in a cycle: da/dN = rate (dK / at)^m."""

    rate: float  # m
    at: float  # Pa sqrt(m)
    exponent: float
    threshold: float = 0.0  # Pa sqrt(m)


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """How cracks grow."""

    steps: int
    increment: float  # m
    advance: Literal["most_critical", "in_turn", "all"]
    criterion: Literal["strength", "directional_strength", "max_hoop_stress"]
    direction: Literal["explicit", "implicit"]
    tip_radius: float | None  # m
    unload_between_steps: bool = True
    initiation: Initiation = Initiation()
    link_distance: float | None = None  # m
    law: Literal["critical", "subcritical", "fatigue"] = "critical"
    subcritical: Subcritical | None = None
    fatigue: Fatigue | None = None

    @property
    def rate_law(self) -> Subcritical | Fatigue | None:
        """How fast tips grow; None where growth takes no time."""
        return self.subcritical or self.fatigue


@dataclass(frozen=True, slots=True, eq=False)
class ContactNumerics:
    """How the contact problem is discretized and solved."""

    stiffness: float | None = None  # kappa; None: rigid
    discretization: Literal["mortar", "gauss"] = "mortar"
    solver: Literal["newton", "lemke"] = "newton"
    spacing: float = 1.25


Levels = int | Literal["auto"]


@dataclass(frozen=True, slots=True)
class Refinement:
    """Refinement levels at features: how often cells of the spacing are halved; auto: as accuracy asks."""

    tips: Levels = 0
    kinks: Levels = 0
    corners: Levels = 0
    rings: float = 2.0


Goal = Literal["K", "slip", "reaction", "load_factor"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Numerics:
    """Settings of the discretization."""

    accuracy: str | float = STANDARD
    goal: Goal = "K"
    spacing: float  # m, side of the largest cells
    auto_rule: str | None = None  # None: the spacing was given
    support: float = 2.0
    quadrature: int = 3
    refine: Refinement = Refinement()
    tip_functions: Literal["auto", "patch", "gathered"] = "auto"
    contact: ContactNumerics = ContactNumerics()

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
class RockPoint(Drawn):
    """A point of a body: displacement and stress."""

    name: str
    point: Floats  # (2,) m
    body: str


@dataclass(frozen=True, slots=True, eq=False)
class FacePoint(Drawn):
    """A place on a crack or an interface: opening and slip."""

    name: str
    surface: SurfaceName  # a crack, or an interface with all of its lines
    point: Floats  # (2,) m


@dataclass(frozen=True, slots=True, eq=False)
class PointPair(Drawn):
    """Two points: by how much they come closer."""

    name: str
    bodies: tuple[str, str]
    points: Floats  # (2, 2) m


HistoryPoint = RockPoint | FacePoint | PointPair
FIELDS: Final = ("displacement", "stress", "energy_error")


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """What is written."""

    frames: Literal["every_step", "first_and_last", "none"] = "every_step"
    fields: tuple[str, ...] = ("displacement", "stress")
    figures: bool = True
    report: bool = True
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
    """A whole scene.

    A case that is changed by `dataclasses.replace` is written as its fields are. What is drawn, the outlines, paths and
    places, is written as it was read; where that is changed the case cannot be written.
    """

    name: str
    title: str
    source: str
    plane: Literal["strain", "stress"]
    bodies: tuple[Body, ...]
    cracks: tuple[Crack, ...]
    interfaces: tuple[Interface, ...]
    supports: tuple[Support, ...]
    loads: tuple[Load, ...]
    loading: Loading
    growth: Growth | None
    numerics: Numerics
    output: Output
    origin: tuple[float, float] = (0.0, 0.0)  # m on a map: places are seen from there
    moved: tuple[Move, ...] = ()  # farther than rounding
    cut: tuple[Cut, ...] = ()  # more than rounding

    def __repr__(self) -> str:
        return f"<Case {self.name}: {self.title}>"

    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any], name: str = "case") -> Case:
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
    def rate_law(self) -> Subcritical | Fatigue | None:
        """How fast tips grow; None where growth takes no time."""
        return None if self.growth is None else self.growth.rate_law

    @property
    def n_loads(self) -> int:
        """Number of load factors that are given, or of stages; 1 where factors are found."""
        if isinstance(self.loading, Stages):
            return len(self.loading.stages)
        return len(self.loading.factors) if isinstance(self.loading, LoadHistory) else 1
