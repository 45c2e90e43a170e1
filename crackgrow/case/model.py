"""What a case says, checked and in SI units: frozen data without behaviour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One piece of rock."""

    name: str
    outline: Floats  # (n, 2) m, corners counter-clockwise, not closed
    edge_names: tuple[str, ...]  # (n,): name of the edge from corner i to corner i + 1
    material: Material
    strength: Strength | None


@dataclass(frozen=True, slots=True, eq=False)
class CoulombContact:
    """Coulomb friction with cohesion on closed faces."""

    friction: float
    cohesion: float  # Pa


@dataclass(frozen=True, slots=True, eq=False)
class Crack:
    """A pre-existing crack: an open polyline."""

    name: str
    points: Floats  # (n, 2) m, from start to end
    tip_at_start: bool  # whether the start can grow; an end inside of the body is a singular tip all the same
    tip_at_end: bool
    contact: CoulombContact | None  # None: the faces never touch each other


@dataclass(frozen=True, slots=True, eq=False)
class PointSupport:
    """Displacement prescribed at a point; a component that is None is free."""

    point: Floats  # (2,) m
    displacement: tuple[float | None, float | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class EdgeRegion:
    """A named edge of a body, or the part of it between two coordinates along it."""

    body: str
    edge: str
    start: float | None = None  # m: x on bottom/top, y on left/right
    end: float | None = None  # m


@dataclass(frozen=True, slots=True, eq=False)
class EdgeSupport:
    """Displacement prescribed along an edge; a component that is None is free."""

    region: EdgeRegion
    displacement: tuple[float | None, float | None]  # m


@dataclass(frozen=True, slots=True, eq=False)
class EdgeTraction:
    """Uniform traction on an edge."""

    region: EdgeRegion
    traction: tuple[float, float]  # Pa


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """How cracks grow."""

    steps: int
    increment: float  # m
    advance: Literal["most_critical", "in_turn", "all"]
    criterion: Literal["strength", "directional_strength"]
    tip_radius: float  # m, Shepard averaging radius
    unload_between_steps: bool


@dataclass(frozen=True, slots=True, eq=False)
class ContactNumerics:
    """How the contact problem is discretized and solved."""

    stiffness: float | None  # kappa in k = kappa E / h; None: rigid
    discretization: Literal["mortar", "gauss"]
    solver: Literal["newton", "lemke"]
    spacing: float  # distance of the mortar nodes, in lattice spacings


@dataclass(frozen=True, slots=True, eq=False)
class Numerics:
    """Settings of the discretization."""

    spacing: float  # m, lattice spacing h
    support: float  # half width of a patch, in spacings
    quadrature: int  # Gauss points per direction on an uncut cell
    contact: ContactNumerics


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """What is written."""

    frames: Literal["every_step", "first_and_last", "none"]
    fields: tuple[str, ...]  # of "displacement", "stress"
    figures: bool


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A whole scene. `resolved` is the same as a mapping in the case format, SI, every default filled in."""

    name: str
    title: str
    source: str
    plane: Literal["strain", "stress"]
    bodies: tuple[Body, ...]
    cracks: tuple[Crack, ...]
    supports: tuple[PointSupport | EdgeSupport, ...]
    loads: tuple[EdgeTraction, ...]
    load_factors: tuple[float, ...]
    growth: Growth | None
    numerics: Numerics
    output: Output
    resolved: dict[str, object]
