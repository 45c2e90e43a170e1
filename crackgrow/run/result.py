"""What one step and one run give: frozen arrays, the only thing that `results` reads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats, Ints
from crackgrow.case.units import place_text
from crackgrow.contact.coulomb import OPEN as OPEN
from crackgrow.contact.coulomb import SLIP as SLIP
from crackgrow.contact.coulomb import SOLVED_RESIDUAL
from crackgrow.contact.coulomb import STICK as STICK
from crackgrow.run.warning_causes import StepWarning, limit_of

STATE_NAMES = ("open", "stick", "slip")

BALANCED = 1e-5
"""Energies that miss each other by less than this part of the largest are balanced."""

CHECK_LIMITS = {
    "residual": limit_of("RESIDUAL"),
    "penetration": 1e-6,  # of the largest jump of the step: beyond round-off
    "complementarity": SOLVED_RESIDUAL,
    "overlap_share": 1.0,
    "energy_error": BALANCED,  # of the balance
}
"""What the columns of steps.csv that tell how good a step is should not be beyond."""


@dataclass(frozen=True, slots=True, eq=False)
class CrackPath:
    """A crack as it lies in the step that was solved."""

    name: str
    points: Floats  # (n, 2) m, from start to end
    steps: Ints  # (n,) the step whose advance made the vertex; 0 for the given crack


@dataclass(frozen=True, slots=True, eq=False)
class TipResult:
    """Fracture quantities at one tip."""

    crack: str
    tip: Literal["start", "end"]
    point: Floats  # (2,) m, before the advance
    K_I: float  # Pa sqrt(m), by the interaction integral; nan where it finds no room
    K_II: float  # Pa sqrt(m)
    sigma_1: float  # Pa, major (most tensile) averaged principal stress; nan without growth
    sigma_3: float  # Pa
    criterion: Literal["tension", "shear", "none"]  # the branch that is met
    criticality: float  # strength ratio: >= 1 where the criterion is met
    kink_deg: float  # degrees, from the tip's direction to the growth direction, counter-clockwise
    advanced: bool
    K_I_error: float  # Pa sqrt(m), bound of what K_I is off by: see `accuracy.companion`; nan where cells are by hand
    K_II_error: float  # Pa sqrt(m)
    K_radius: float  # m, of the disc
    K_note: str  # why the disc is smaller than usual, or missing; empty where it is not
    K_I_faces: float  # Pa sqrt(m), from the displacement of the faces: a coarse check
    K_II_faces: float  # Pa sqrt(m)
    K_I_spread: float  # Pa sqrt(m), between discs of integration: a part of the error, often a small one
    K_II_spread: float  # Pa sqrt(m)
    cell_size: float  # m, side of the cells round the tip
    kink_error_deg: float = float("nan")  # degrees, bound of what the direction of growth is off by; nan without growth
    velocity: float = float("nan")  # m/s, by the law of subcritical growth; nan where growth takes no time
    K_error_expected: float = float("nan")  # Pa sqrt(m), of K_I and K_II together; nan where it was not measured
    sticks: bool = False  # its crack has faces that have not moved: its K is zero, and K_I, K_II what cells leave of it
    K_growth: float = float("nan")  # Pa sqrt(m), at which the tip grows: K_eq in tension, |K_II| in shear; nan: unknown
    T: float = float("nan")  # Pa: stress along the crack at the tip, without what is singular
    T_error: float = float("nan")  # Pa, bound of what T is off by; nan where it was not measured
    K_range: float = float("nan")  # Pa sqrt(m), along the kink, between the loads of a cycle; nan without cycles
    growth_per_cycle: float = float("nan")  # m, by the law of fatigue


@dataclass(frozen=True, slots=True, eq=False)
class InterfaceTipResult:
    """An end of the cracked part of an interface. No K_I and K_II: between two materials these do not exist."""

    crack: str  # "first/second"
    tip: Literal["start", "end"]
    point: Floats  # (2,) m
    G: float  # J/m^2, energy release rate along the interface; nan where it is not known
    G_spread: float  # J/m^2, between discs of integration
    K: float  # Pa sqrt(m), size of the complex K
    G_radius: float  # m, of the disc
    cell_size: float  # m, side of the cells round the tip
    length: float  # m, of the cracked part
    criticality: float = float("nan")  # sqrt(G / G_c): >= 1 where it grows; nan without a toughness
    advanced: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class StartResult:
    """The most critical place of a step at which a crack may start."""

    point: Floats  # (2,) m
    criterion: Literal["tension", "shear"]  # how a crack starts there, or would
    criticality: float  # strength ratio: >= 1 where the criterion is met


@dataclass(frozen=True, slots=True, eq=False)
class ContactPoints:
    """Contact points of all surfaces that have a contact law, one after the other, in order of s."""

    crack: tuple[str, ...]  # (n,) name of the crack, "first/second" of an interface, "body.edge" of a foundation
    s: Floats  # (n,) m, arc length from the surface's start
    points: Floats  # (n, 2) m
    normal_traction: Floats  # (n,) Pa, negative in compression
    tangential_traction: Floats  # (n,) Pa
    opening: Floats  # (n,) m
    slip: Floats  # (n,) m
    state: Ints  # (n,) index into STATE_NAMES
    mean_opening: Floats  # (n,) m, averages round the point: the contact law holds for these
    mean_slip: Floats  # (n,) m


@dataclass(frozen=True, slots=True, eq=False)
class CrackFaces:
    """Samples along one crack, interface or foundation, from start to end, both ends included."""

    crack: str
    s: Floats  # (n,) m
    points: Floats  # (n, 2) m
    opening: Floats  # (n,) m, jump of displacement across the crack
    slip: Floats  # (n,) m
    normal_traction: Floats  # (n,) Pa
    tangential_traction: Floats  # (n,) Pa
    state: Ints  # (n,) index into STATE_NAMES
    cell_size: Floats  # (n,) m, side of the cells there


@dataclass(frozen=True, slots=True, eq=False)
class Reaction:
    """The force that a support or a contact surface carries, or the pressure that a volume of fluid takes."""

    where: str  # "supports.0", "body.edge" of a foundation, "first/second" of an interface, "loads.0" of a volume
    force: tuple[float, float]  # N per metre of thickness, on the rock; of an interface on its first body
    pressure: float = float("nan")  # Pa, of a volume


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The specimen as a mesh for output: nodes are double along cracks. Cells: triangles first, then quads.

    The stress of a node at a tip, where it is infinite, is the mean of its neighbours'.
    """

    points: Floats  # (n, 2) m
    triangles: Ints  # (t, 3)
    quads: Ints  # (q, 4)
    displacement: Floats  # (n, 2) m
    point_stress: Floats  # (n, 3) Pa: xx, yy, xy
    point_stress_zz: Floats  # (n,) Pa
    stress: Floats  # (t + q, 3) Pa: xx, yy, xy at cell centres
    stress_zz: Floats  # (t + q,) Pa
    body: Ints  # (t + q,) index of the body
    error_density: Floats | None = None  # (t + q,) root of the error's energy density over the mean one of the rock


class FrameOnDemand:
    """A frame that is made when it is first asked for, and kept: of most steps nobody wants one."""

    def __init__(self, make: Callable[[], Frame]) -> None:
        self._make: Callable[[], Frame] | None = make
        self._frame: Frame | None = None

    def __call__(self) -> Frame:
        """Return the frame."""
        if self._frame is None:
            assert self._make is not None
            self._frame, self._make = self._make(), None  # lets go of what it was made of
        return self._frame


EventKind = Literal[
    "coalescence", "hole", "break_through", "interface", "initiation", "slip", "opening", "break", "growth", "parted",
    "stop", "deflection", "crossing",
]  # fmt: skip

VERBS: Final[Mapping[str, str]] = {"stop": "stops at", "deflection": "turns along", "crossing": "crosses"}
"""What tips do at the interfaces that they have reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """A tip has met something in its advance: it ends there; or a crack has started (initiation): where, and how.

    Also what is told of in the table alone: faces slip, open or break, a tip grows, rock parts.
    """

    step: int  # whose advance made it, or in which it happens
    kind: EventKind
    crack: str  # or another surface
    tip: Literal["start", "end", ""]  # "" of faces
    point: Floats  # (2,) m
    met: str  # "crack 'b'", "its own path", "hole0 of body 'rock'", "the outline of body 'rock'", "interface 'a/b'"
    load_factor: float = float("nan")  # at which it happens
    energy: float = float("nan")  # J per metre of thickness, that is dissipated or released

    @property
    def words(self) -> str:
        """What has happened, and where."""
        at = place_text(self.point)
        if self.kind == "initiation":
            return f"crack '{self.crack}' starts on {self.met} at {at}"
        return f"crack '{self.crack}' ({self.tip}) {VERBS.get(self.kind, 'reached')} {self.met} at {at}"


def event_record(event: Event) -> dict[str, Any]:
    """The event in numbers and words."""
    x, y = (float(coordinate) for coordinate in event.point)
    return {
        "step": int(event.step), "kind": event.kind, "crack": event.crack, "tip": event.tip, "x": x, "y": y,
        "met": event.met,
    }  # fmt: skip


def event_of(record: Mapping[str, Any]) -> Event:
    """The event of an `event_record`."""
    point = np.array([record["x"], record["y"]])
    return Event(record["step"], record["kind"], record["crack"], record["tip"], point, record["met"])


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """All that the run can go on from: its step, to be solved again, in plain data. See `run.checkpoint`."""

    step: int
    values: Mapping[str, Any]  # whatever JSON can hold
    arrays: Mapping[str, NDArray[Any]]  # of numbers


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Displacements, stresses and slip at the places of `output.points`, and reactions, on the way of a step."""

    columns: tuple[str, ...]  # "wall.u_x" (m), "wall.stress_xx" (Pa), "mouth.opening" (m), "supports.0.force_x" (N/m)
    load_factor: Floats  # (n,) of the states on the way, in turn; the last one is that at the end of the step
    values: Floats  # (n, columns)


@dataclass(frozen=True, slots=True, eq=False)
class Energy:
    """Energies since the unloaded state, J per metre of thickness."""

    work: float  # of loads and prescribed displacements
    strain: float  # of the rock and of elastic contact
    dissipated: float  # by friction and dilation, as the law says
    released: float  # by bonds that break, and by growth where steps do not start unloaded
    error: float  # relative: what the balance misses, by its largest term

    @property
    def size(self) -> float:
        """The largest term, which what is missing is measured by."""
        return max(abs(self.work), self.strain, abs(self.dissipated))

    @property
    def created(self) -> float:
        """What is released below zero, by the size: energy that nothing has given."""
        return max(-self.released, 0.0) / self.size if self.size > 0.0 else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class StepResult:
    """One solved step."""

    step: int
    load_factor: float
    cracks: tuple[CrackPath, ...]
    events: tuple[Event, ...]  # of the advance that led to this configuration
    tips: tuple[TipResult, ...]
    interface_tips: tuple[InterfaceTipResult, ...]
    contact: ContactPoints
    faces: tuple[CrackFaces, ...]  # cracks, then interfaces, then foundations
    reactions: tuple[Reaction, ...]
    mesh: Callable[[], Frame] | None  # makes the frame; None where nothing can want one
    n_dofs: int
    n_contact: int  # contact unknowns that the solver saw
    contact_iterations: int
    contact_status: str  # "none" | "solved"
    factorizations: int
    residual: float  # relative equilibrium residual
    penetration: float  # m, largest overlap at a contact point beyond what the contact stiffness explains
    complementarity: float  # relative complementarity residual of the contact conditions
    overlap: float  # m, largest overlap of closed faces at any place, beyond what the contact stiffness explains
    overlap_share: float  # of what is small beside a surface's jump and the displacement: beyond 1 the step warns
    energy: Energy
    load_displacement: float  # m, of the loads
    mean_stress: tuple[float, float, float]  # Pa, xx, yy, xy: of the whole specimen, holes included
    mean_strain: tuple[float, float, float]  # the same, cracks included; xy is half the angle
    crack_length: float  # m, of all cracks
    seconds: dict[str, float]  # by phase: cover, assembly, factorize, contact, criterion, output
    step_warnings: tuple[StepWarning, ...]  # what makes the step doubtful, the most important first
    emissions: tuple[Event, ...] = ()  # of faces on the way of the loads, as they begin, and of tips that grow
    norm_error: float = float("nan")  # percent of the energy norm, estimated for step 0; nan for others
    stress: float = 0.0  # Pa: the size of that which the loads make, by which K can be nothing
    history: History | None = None  # where the case names points
    load_factor_error: float = float("nan")  # percent, bound of what a critical load factor is off by; nan for others
    goal_error: float = float("nan")  # percent, bound of what `numerics.goal` is off by; nan where that is K
    slip_error: float = float("nan")  # percent of the largest, bound of what the jumps of faces are off by
    reaction_error: float = float("nan")  # the same of reactions
    time: float = float("nan")  # s, at which the cracks have come here; nan where growth takes no time
    cycles: float = float("nan")  # after which they have come here in fatigue
    start: StartResult | None = None  # where cracks may start elsewhere than at tips
    checkpoint: Checkpoint | None = None  # from which this step and those behind it can be made again

    @property
    def warnings(self) -> tuple[str, ...]:
        """The warnings in words."""
        return tuple(warning.words for warning in self.step_warnings)

    @property
    def frame(self) -> Frame | None:
        """The specimen as a mesh."""
        return None if self.mesh is None else self.mesh()


FARTHEST = 1024.0
"""Factors of strength beyond this, and below its inverse, are not tried."""


@dataclass(frozen=True, slots=True, eq=False)
class Safety:
    """How safe a scene is."""

    factor: float  # the largest at which it holds; infinite where it holds at all that are tried
    fails_at: float  # the next one that was tried
    mechanism: str  # what moves, and how; empty where it never fails
    error: float = float("nan")  # percent, bound of what the factor is off by; nan where cells are by hand

    def __str__(self) -> str:
        if np.isinf(self.factor):
            return f"the scene does not fail: with friction and cohesion divided by {FARTHEST:g} it still holds"
        how = f"with friction and cohesion divided by {self.fails_at:.6g} {self.mechanism}"
        within = f" within {self.error:.2g} %" if np.isfinite(self.error) else ""
        return f"the factor of safety is {self.factor:.5g}{within}: {how}"


@dataclass(frozen=True, slots=True, eq=False)
class RunEnd:
    """Why a run ended, or that it has not."""

    status: Literal["completed", "arrested", "broke_through", "failed", "interrupted", "running"]
    reason: str
    cracks: tuple[CrackPath, ...]  # the final paths, the last advance included
    events: tuple[Event, ...] = ()  # of an advance that was not solved any more
    norm_error: float = float("nan")  # percent of the energy norm, estimated for the last step; nan if it is unknown
    safety: Safety | None = None  # where strength was reduced
