"""A case in other places, sizes and units: turned, mirrored, moved, scaled. What it models stays the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.formula import component_at
from crackgrow.case.model import Body, Case, Component, EdgeRegion

Pair = tuple[Component | None, Component | None]
Stress = tuple[Component, Component, Component]

STRAIGHT = 1e-12
"""A direction this close to an axis is along it."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """x -> size Q x + shift for places, with stresses and moduli multiplied; strengths go with the stresses."""

    turn: Floats  # (2, 2) Q, orthogonal
    shift: Floats  # (2,) m
    size: float = 1.0
    stress: float = 1.0
    young: float = 1.0

    @property
    def mirrors(self) -> bool:
        """Whether left becomes right."""
        return bool(np.linalg.det(self.turn) < 0.0)

    @property
    def displacement(self) -> float:
        """What displacements are multiplied by."""
        return self.size * self.stress / self.young

    def points(self, points: Floats) -> Floats:
        """Places (n, 2) m of points (n, 2) m."""
        return np.asarray(self.size * points @ self.turn.T + self.shift)

    def before(self, points: Floats) -> Floats:
        """The points (n, 2) m whose places these are."""
        return np.asarray((points - self.shift) @ self.turn / self.size)

    def vector(self, vector: Sequence[float], factor: float) -> tuple[float, float]:
        """A vector (2,) turned, and multiplied by a factor."""
        x, y = (factor * (self.turn @ np.asarray(vector))).tolist()
        return x, y


@dataclass(frozen=True, slots=True, eq=False)
class _Sum:
    """A sum of components, some of them formulas, at places after a placement."""

    components: Sequence[Component]
    factors: Sequence[float]
    placement: Placement

    def __call__(self, points: Floats) -> Floats:
        before = self.placement.before(points)
        values = (component_at(component, before) for component in self.components)
        return np.asarray(sum(factor * value for factor, value in zip(self.factors, values, strict=True)))


def scaled(size: float = 1.0, stress: float = 1.0, young: float = 1.0) -> Placement:
    """Other units: the same scene with lengths, stresses and moduli multiplied."""
    return Placement(np.eye(2), np.zeros(2), size, stress, young)


def turned(degrees: float) -> Placement:
    """Counter-clockwise about the origin; whole right angles are exact."""
    angle = np.deg2rad(degrees)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    return Placement(np.where(np.abs(turn) < STRAIGHT, 0.0, turn), np.zeros(2))


def mirrored() -> Placement:
    """Left becomes right."""
    return Placement(np.diag([-1.0, 1.0]), np.zeros(2))


def moved(x: float, y: float) -> Placement:
    """Shifted by so many metres."""
    return Placement(np.eye(2), np.array([x, y]))


def placed(case: Case, placement: Placement) -> Case:
    """The case after a placement. `resolved` stays that of the case given.

    Raises ValueError for a support with one free component in a direction that is no longer along an axis.
    """
    numerics = replace(case.numerics, spacing=placement.size * case.numerics.spacing)
    growth = case.growth
    if growth is not None:
        growth = replace(
            growth,
            increment=placement.size * growth.increment,
            tip_radius=_scaled(growth.tip_radius, placement),
            initiation=replace(growth.initiation, spacing=_scaled(growth.initiation.spacing, placement)),
            link_distance=_scaled(growth.link_distance, placement),
        )
    corners = {body.name: [len(ring.points) for ring in body.rings] for body in case.bodies}
    return replace(
        case,
        bodies=tuple(_body(body, placement) for body in case.bodies),
        cracks=tuple(
            replace(
                c, points=placement.points(c.points), contact=None if c.contact is None else _law(c.contact, placement)
            )
            for c in case.cracks
        ),
        interfaces=tuple(_interface(interface, placement) for interface in case.interfaces),
        supports=tuple(_support(support, placement, corners) for support in case.supports),
        loads=tuple(_load(load, placement, corners) for load in case.loads),
        growth=growth,
        numerics=numerics,
    )


def _scaled(length: float | None, placement: Placement) -> float | None:
    return None if length is None else placement.size * length


def _body(body: Body, placement: Placement) -> Body:
    strength = body.strength
    if strength is not None:
        K, K_shear = (
            None if K is None else placement.stress * float(np.sqrt(placement.size)) * K
            for K in (strength.toughness, strength.shear_toughness)
        )
        strength = replace(
            strength,
            tension=placement.stress * strength.tension,
            cohesion=placement.stress * strength.cohesion,
            toughness=K,
            shear_toughness=K_shear,
        )
    material = replace(body.material, young=placement.young * body.material.young)
    return replace(
        body, rings=tuple(_ring(ring, placement) for ring in body.rings), material=material, strength=strength
    )


def _ring(ring: model.Ring, placement: Placement) -> model.Ring:
    """Rock stays on the left: in the mirror the corners come in reversed order, and side i becomes n - 2 - i."""
    points = placement.points(ring.points)
    if not placement.mirrors:
        return model.Ring(points, ring.edge_names)
    n = len(points)
    return model.Ring(points[::-1].copy(), tuple(ring.edge_names[(n - 2 - i) % n] for i in range(n)))


def _region(region: EdgeRegion, placement: Placement, corners: dict[str, list[int]]) -> EdgeRegion:
    if not placement.mirrors:
        return region
    starts = np.concatenate([[0], np.cumsum(corners[region.body])])
    ring = np.searchsorted(starts, region.sides, side="right") - 1
    n = np.asarray(corners[region.body])[ring]
    sides = starts[ring] + (n - 2 - (region.sides - starts[ring])) % n
    return replace(region, sides=sides[::-1].copy(), limits=1.0 - region.limits[::-1, ::-1])


def _law(contact: model.CoulombContact, placement: Placement) -> model.CoulombContact:
    stiffness = contact.stiffness
    if stiffness is not None:
        per = placement.stress / placement.displacement
        stiffness = (per * stiffness[0], per * stiffness[1])
    return replace(
        contact,
        cohesion=placement.stress * contact.cohesion,
        stiffness=stiffness,
        weakening_length=placement.displacement * contact.weakening_length,
    )


def _interface(interface: model.Interface, placement: Placement) -> model.Interface:
    """The first body stays on the left of the lines."""
    order = -1 if placement.mirrors else 1
    lines = tuple(placement.points(line)[::order].copy() for line in interface.lines)
    contact = interface.contact
    return replace(interface, lines=lines, contact=contact if contact == "bonded" else _law(contact, placement))


def _support(support: model.Support, placement: Placement, corners: dict[str, list[int]]) -> model.Support:
    if isinstance(support, model.ContactSupport):
        return model.ContactSupport(_region(support.region, placement, corners), _law(support.contact, placement))
    displacement = _components(support.displacement, placement, placement.displacement)
    if isinstance(support, model.PointSupport):
        return replace(support, point=placement.points(support.point[None])[0], displacement=displacement)
    return model.EdgeSupport(_region(support.region, placement, corners), displacement)


def _components(displacement: Pair, placement: Placement, size: float) -> Pair:
    """Prescribed components turned and multiplied by `size`; those that are free stay so."""
    found: list[Component | None] = []
    for row in placement.turn:
        along = np.flatnonzero(row)
        if len(along) != 1:
            raise ValueError("supports of single components can be turned by right angles only")
        component = displacement[along[0]]
        factor = float(row[along[0]]) * size
        if component is None:
            found.append(None)
        else:
            found.append(_Sum([component], [factor], placement) if callable(component) else factor * component)
    return found[0], found[1]


def _traction(given: tuple[Component, Component], placement: Placement) -> tuple[Component, Component]:
    """Components of a traction turned; formulas by right angles only."""
    x, y = given
    if not callable(x) and not callable(y):
        return placement.vector((x, y), placement.stress)
    first, second = _components(given, placement, placement.stress)
    assert first is not None
    assert second is not None
    return first, second


def _load(load: model.Load, placement: Placement, corners: dict[str, list[int]]) -> model.Load:
    if isinstance(load, model.EdgeTraction):
        traction = _traction(load.traction, placement)
        return replace(load, region=_region(load.region, placement, corners), traction=traction)
    if isinstance(load, model.EdgePressure):
        region = _region(load.region, placement, corners)
        return replace(load, region=region, pressure=_pressure(load.pressure, placement))
    if isinstance(load, model.Gravity):
        return replace(load, acceleration=placement.vector(load.acceleration, placement.stress / placement.size))
    if isinstance(load, model.FluidPressure):
        return replace(load, pressure=_pressure(load.pressure, placement))
    if isinstance(load, model.PointForce):
        force = placement.vector(load.force, placement.stress * placement.size)
        return replace(load, point=placement.points(load.point[None])[0], force=force)
    assert isinstance(load, model.InSituStress)
    return replace(load, stress=_stress(load.stress, placement))


def _pressure(pressure: Component, placement: Placement) -> Component:
    if callable(pressure):
        return _Sum([pressure], [placement.stress], placement)
    return placement.stress * pressure


def _stress(stress: Stress, placement: Placement) -> Stress:
    """Components of a stress turned."""
    (a, b), (c, d) = placement.turn
    rows = np.array([(a * a, b * b, 2.0 * a * b), (c * c, d * d, 2.0 * c * d), (a * c, b * d, a * d + b * c)])
    if any(map(callable, stress)):
        xx, yy, xy = (_Sum(stress, (placement.stress * row).tolist(), placement) for row in rows)
        return xx, yy, xy
    return tuple((placement.stress * rows @ np.asarray(stress)).tolist())
