"""What a case says, checked and in SI units: frozen data without behaviour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.case.read_only import read_only


class Formula(Protocol):
    """A component of a displacement or a load as a function of the place."""

    def __call__(self, points: Floats) -> Floats:
        """Values (n,) in SI at points (n, 2) m."""
        ...


Component = float | Formula


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """Isotropic linear elasticity."""

    young: float  # Pa
    poisson: float
    density: float | None = None  # kg/m^3


@dataclass(frozen=True, slots=True, eq=False)
class Strength:
    """Tension cut-off and Mohr-Coulomb shear strength."""

    tension: float  # Pa
    cohesion: float  # Pa
    friction_angle: float  # degrees
    toughness: float | None = None  # Pa sqrt(m), K_Ic; the averaging radius follows from it


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """A closed line round rock, which lies on its left: an outline runs counter-clockwise, a hole clockwise."""

    points: Floats  # (n, 2) m, corners, not closed
    edge_names: tuple[str, ...]  # (n,): name of the edge that the side from corner i to corner i + 1 belongs to


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One piece of rock. Its sides are numbered ring by ring."""

    name: str
    rings: tuple[Ring, ...]  # the outline, then the holes
    material: Material
    strength: Strength | None

    @property
    def outline(self) -> Floats:
        """Corners (n, 2) m of the outline."""
        return self.rings[0].points


@dataclass(frozen=True, slots=True, eq=False)
class CoulombContact:
    """Coulomb friction with cohesion on closed faces, |p_t| <= c - mu p_n, and what slip makes of it.

    A point that has slipped or opened is broken: friction falls to its residual value, and cohesion is lost unless it
    is kept. Slip over asperities opens the faces by tan(dilation angle) |slip|.
    """

    friction: float
    cohesion: float  # Pa
    residual_friction: float  # of broken points
    cohesion_kept: bool  # whether broken points cohere where they are closed
    dilation_angle: float = 0.0  # degrees
    stiffness: tuple[float, float] | None = None  # Pa/m: normal, shear; None: that of the numerics
    weakening_length: float = 0.0  # m of slip over which friction and cohesion fall; 0: with the first slip


@dataclass(frozen=True, slots=True, eq=False)
class Crack:
    """A pre-existing crack: an open polyline."""

    name: str
    points: Floats  # (n, 2) m, from start to end
    tip_at_start: bool  # whether the start can grow; an end in rock, on no other crack, is a singular tip all the same
    tip_at_end: bool
    contact: CoulombContact | None  # None: the faces never touch each other
    body: str  # the body that it lies in
    left_out: int = 0  # vertices that were given besides: each repeats the one before it


@dataclass(frozen=True, slots=True, eq=False)
class Interface:
    """Where two bodies share a boundary."""

    bodies: tuple[str, str]
    lines: tuple[Floats, ...]  # each (n, 2) m, open polylines; the first body lies on the left
    contact: CoulombContact | Literal["bonded"]


@dataclass(frozen=True, slots=True, eq=False)
class PointSupport:
    """Displacement prescribed at a point of a body; a component that is None is free."""

    body: str
    point: Floats  # (2,) m
    displacement: tuple[Component | None, Component | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class EdgeRegion:
    """A named edge of a body, or a part of it: sides of its rings, each from one fraction of its length to another."""

    body: str
    edge: str
    sides: NDArray[np.int64]  # (k,) numbers of the body's sides, in order along the ring
    limits: Floats  # (k, 2) where the part begins and ends on each of them: 0 at its first corner, 1 at its second


@dataclass(frozen=True, slots=True, eq=False)
class EdgeSupport:
    """Displacement prescribed along an edge; a component that is None is free."""

    region: EdgeRegion
    displacement: tuple[Component | None, Component | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class ContactSupport:
    """A rigid foundation under an edge, which the body can lift off from."""

    region: EdgeRegion
    contact: CoulombContact


@dataclass(frozen=True, slots=True, eq=False)
class EdgeTraction:
    """Traction on an edge."""

    region: EdgeRegion
    traction: tuple[Component, Component]  # Pa
    held: bool = False  # acts in full at every load factor
    name: str | None = None  # by which stages give it factors of its own; several loads may share one


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """Weight of a body."""

    body: str
    acceleration: tuple[float, float]  # m/s^2
    held: bool = False
    name: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FluidPressure:
    """Pressure of a fluid on both faces of a crack or of an interface."""

    surface: str | tuple[str, str]  # a crack, or the two bodies of an interface
    pressure: Component  # Pa, positive pushes the faces apart
    held: bool = False
    name: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class InSituStress:
    """Stress that a body holds before anything displaces."""

    body: str
    stress: tuple[Component, Component, Component]  # Pa: xx, yy, xy
    held: bool = False
    name: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PointForce:
    """A force at a point of a body."""

    body: str
    point: Floats  # (2,) m
    force: tuple[float, float]  # N per metre of thickness
    held: bool = False
    name: str | None = None


Support = PointSupport | EdgeSupport | ContactSupport
Load = EdgeTraction | Gravity | FluidPressure | InSituStress | PointForce


@dataclass(frozen=True, slots=True, eq=False)
class LoadHistory:
    """Factors of the loads that are not held, applied in turn; friction remembers."""

    factors: tuple[float, ...]


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

    at: Literal["tips", "cracks", "outlines", "anywhere"] = "tips"  # each also where those before it
    spacing: float | None = None  # m, of points on outlines and in the rock; None: by increment and averaging radius


@dataclass(frozen=True, slots=True)
class Subcritical:
    """How fast tips grow below the toughness: v = v_max (K / K_c)^n."""

    velocity: float  # m/s, v_max
    exponent: float  # n
    threshold: float  # K / K_c up to which a tip stands still


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """How cracks grow."""

    steps: int
    increment: float  # m
    advance: Literal["most_critical", "in_turn", "all"]
    criterion: Literal["strength", "directional_strength", "max_hoop_stress"]
    direction: Literal["explicit", "implicit"]  # implicit: the kink is corrected until K_II vanishes at the new tip
    tip_radius: float | None  # m, Shepard averaging radius where rock has no toughness
    unload_between_steps: bool
    initiation: Initiation = Initiation()
    link_distance: float | None = None  # m, from other cracks at which a segment has reached them; None: a tenth of it
    subcritical: Subcritical | None = None  # None: a tip grows where the criterion is met


@dataclass(frozen=True, slots=True, eq=False)
class ContactNumerics:
    """How the contact problem is discretized and solved."""

    stiffness: float | None  # kappa in k = kappa E / h; None: rigid
    discretization: Literal["mortar", "gauss"]
    solver: Literal["newton", "lemke"]
    spacing: float  # distance of the mortar nodes, in lattice spacings


Halvings = int | Literal["auto"]


@dataclass(frozen=True, slots=True)
class Refinement:
    """How often cells are halved at places that ask for small ones; auto: until they are as small as accuracy asks."""

    tips: Halvings = 0
    kinks: Halvings = 0  # kinks, meetings and ends of cracks
    corners: Halvings = 0  # re-entrant corners, point supports, ends of loaded and supported parts
    rings: float = 2.0  # cells of each size on every side of such a place


Goal = Literal["K", "slip", "reaction", "load_factor"]


@dataclass(frozen=True, slots=True, eq=False)
class Numerics:
    """Settings of the discretization."""

    spacing: float  # m, lattice spacing h: side of the largest cells
    support: float  # half width of a patch, in spacings
    quadrature: int  # Gauss points per direction on an uncut cell
    contact: ContactNumerics
    accuracy: str | float = "standard"  # the preset of what the case leaves out, or a target of the error of the goal
    refine: Refinement = Refinement()
    tip_functions: Literal["auto", "patch", "gathered"] = "auto"
    auto_rule: str | None = None  # what gave an automatic spacing; None: it was given
    goal: Goal = "K"  # what a target is the error of

    @property
    def target(self) -> float | None:
        """Error of the goal, over its largest value, that cells are halved for; None: those of the case."""
        return None if isinstance(self.accuracy, str) else self.accuracy

    @property
    def gathers_tip_functions(self) -> bool:
        """Whether the functions of tips with room are gathered: they take several cells, so in small ones."""
        return self.tip_functions == "gathered" or (self.tip_functions == "auto" and self.refine.tips != 0)


@dataclass(frozen=True, slots=True, eq=False)
class RockPoint:
    """A point of a body: displacement and stress."""

    name: str
    body: str
    point: Floats  # (2,) m


@dataclass(frozen=True, slots=True, eq=False)
class FacePoint:
    """A place on a crack or an interface: opening and slip."""

    name: str
    surface: str | tuple[str, str]  # a crack, or the two bodies of an interface
    point: Floats  # (2,) m


@dataclass(frozen=True, slots=True, eq=False)
class PointPair:
    """Two points: by how much they come closer."""

    name: str
    bodies: tuple[str, str]
    points: Floats  # (2, 2) m


HistoryPoint = RockPoint | FacePoint | PointPair


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """What is written."""

    frames: Literal["every_step", "first_and_last", "none"]
    fields: tuple[str, ...]  # of "displacement", "stress"
    figures: bool
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
    """What of a line of a set of cracks lies outside of the rock, and was left out."""

    crack: str  # name of the set with the number of the line
    length: float  # m, of what was left out
    whole: bool  # whether all of the line was
    place: tuple[float, float]  # m, a point of it


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A whole scene. `resolved` is the same as a mapping in the case format, SI, every default filled in; read-only."""

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
    resolved: dict[str, object]
    moved: tuple[Move, ...] = ()  # farther than rounding; `resolved` has the points where they were given
    cut: tuple[Cut, ...] = ()  # more than rounding; `resolved` has what is left

    def __repr__(self) -> str:
        return f"<Case {self.name}: {self.title}>"

    def __post_init__(self) -> None:
        object.__setattr__(self, "resolved", read_only(self.resolved))

    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any], name: str = "case") -> Case:
        """The checked case of a mapping in the case format; raises CaseError with every fault."""
        from crackgrow.case.mappings import case_from  # it stands on the classes of this module

        return case_from(mapping, name)

    def to_dict(self) -> dict[str, Any]:
        """The case as a mapping in the case format, as `case.yaml` of a run: SI, every default filled in."""
        from crackgrow.case.mappings import mapping_of  # it stands on the classes of this module

        return mapping_of(self)

    def with_(self, *settings: str) -> Case:
        """The case with settings such as "numerics.spacing=1 mm"; bare numbers are in SI."""
        from crackgrow.case.mappings import changed  # it stands on the classes of this module

        return changed(self, settings)

    @property
    def last_factor(self) -> float:
        """The last load factor of the history; nan where factors are found."""
        return self.loading.factors[-1] if isinstance(self.loading, LoadHistory) else float("nan")

    @property
    def last_step(self) -> int:
        """Number of the last step, counted from 0, if nothing ends the run before."""
        if self.growth is not None:
            return self.growth.steps
        return 1 if isinstance(self.loading, StrengthReduction) else self.n_loads - 1

    @property
    def n_loads(self) -> int:
        """Number of load factors that are given, or of stages; 1 where factors are found."""
        if isinstance(self.loading, Stages):
            return len(self.loading.stages)
        return len(self.loading.factors) if isinstance(self.loading, LoadHistory) else 1
