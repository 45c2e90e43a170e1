"""A case in other places, sizes and units: turned, mirrored, moved, scaled. What it models stays the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, is_dataclass, replace
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case import model
from crackgrow.case.declared import Declared, declared
from crackgrow.case.formula import component_at
from crackgrow.case.model import Case, Component, EdgeRegion
from crackgrow.case.schema import Components, Mapping

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

    @property
    def factors(self) -> dict[str, float]:
        """What fields of the model are multiplied by: under their names, or else by the kind of what they take."""
        return {
            "young": self.young,
            "displacement": self.displacement,
            "weakening_length": self.displacement,
            "length": self.size,
            "stress": self.stress,
            "toughness": self.stress * float(np.sqrt(self.size)),
            "stiffness": self.stress / self.displacement,
            "force": self.stress * self.size,
            "acceleration": self.stress / self.size,
        }

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
    corners = {body.name: [len(ring.points) for ring in body.rings] for body in case.bodies}
    order = -1 if placement.mirrors else 1  # the first body stays on the left of an interface

    def of(thing: Any, **others: object) -> Any:
        """A part of the case with its keys placed; `others` are fields that the keys do not tell."""
        cls: Any = type(thing)
        told = [item for item in declared(cls) if item.name not in others]
        return replace(thing, **{item.name: value_of(item, getattr(thing, item.name)) for item in told}, **others)

    def value_of(item: Declared, value: Any) -> Any:
        if isinstance(value, EdgeRegion):
            return _region(value, placement, corners)
        if is_dataclass(value) and not callable(value):
            return of(value)
        if isinstance(value, np.ndarray):
            return placement.points(value.reshape(-1, 2)).reshape(value.shape)
        return _value(item, value, placement)

    return replace(
        case,
        bodies=tuple(of(body, rings=tuple(_ring(ring, placement) for ring in body.rings)) for body in case.bodies),
        cracks=tuple(map(of, case.cracks)),
        interfaces=tuple(
            of(pair, lines=tuple(placement.points(line)[::order].copy() for line in pair.lines))
            for pair in case.interfaces
        ),
        supports=tuple(map(of, case.supports)),
        loads=tuple(map(of, case.loads)),
        growth=None if case.growth is None else of(case.growth),
        numerics=of(case.numerics),
    )


def _value(item: Declared, value: Any, placement: Placement) -> Any:
    """A number, a formula, a vector or a stress of a field; what has no unit stays."""
    kind = _kind_of(item.spec)
    factor = placement.factors.get(item.name) or placement.factors.get(kind)
    if factor is None or value is None or isinstance(value, str):
        return value
    if not isinstance(value, tuple):
        return _Sum([value], [factor], placement) if callable(value) else factor * value
    if isinstance(item.spec, Mapping):
        return tuple(factor * part for part in value)
    return _pair(value, placement, factor) if len(value) == 2 else _stress(value, placement)


def _kind_of(spec: Any) -> str:
    """The kind of quantity that a key takes, alone or as a vector; empty where it takes none."""
    fields = spec.mapping.fields if isinstance(spec, Components) else getattr(spec, "fields", None)
    inner = next(iter(fields.values())).spec if fields else getattr(spec, "spec", None)
    return str(getattr(spec, "kind", "")) if inner is None else _kind_of(inner)


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


def _pair(vector: Sequence[Component | None], placement: Placement, factor: float) -> tuple[Component | None, ...]:
    """A vector turned and multiplied; components that are free stay so, formulas are turned by right angles only."""
    numbers = [part for part in vector if part is not None and not callable(part)]
    if len(numbers) == len(vector):
        return placement.vector(numbers, factor)
    found: list[Component | None] = []
    for row in placement.turn:
        along = np.flatnonzero(row)
        if len(along) != 1:
            raise ValueError("supports of single components can be turned by right angles only")
        component, size = vector[along[0]], float(row[along[0]]) * factor
        formula = _Sum([component], [size], placement) if callable(component) else None
        found.append(formula or (None if component is None else size * component))
    return tuple(found)


def _stress(stress: Sequence[Component], placement: Placement) -> tuple[Component, ...]:
    """Components of a stress turned."""
    (a, b), (c, d) = placement.turn
    rows = np.array([(a * a, b * b, 2.0 * a * b), (c * c, d * d, 2.0 * c * d), (a * c, b * d, a * d + b * c)])
    if any(map(callable, stress)):
        return tuple(_Sum(stress, (placement.stress * row).tolist(), placement) for row in rows)
    return tuple((placement.stress * rows @ np.asarray(stress)).tolist())
