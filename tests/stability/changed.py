"""The same scene written otherwise: turned, mirrored, moved, scaled, in other units, in another order, reversed, split.

Of a changed document everything that a run gives is known from what the first one gives.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.case.units import UNITS
from crackgrow.errors import CrackgrowError
from crackgrow.fracture.advance import TIE
from crackgrow.run.loop import for_each, grow
from crackgrow.run.result import StepResult

Scene = dict[str, Any]
LENGTHS = frozenset({"width", "height", "radius", "length", "spacing", "increment", "link_distance"})
STRESSES = frozenset({"tension", "cohesion", "pressure"})
PLACES = frozenset({"center", "polygon", "points", "at"})
EDGES = {(0, -1): "bottom", (1, 0): "right", (0, 1): "top", (-1, 0): "left"}
NORMALS = {edge: normal for normal, edge in EDGES.items()}
NO_K = 1e-3
"""Of the stress times the root of a spacing: smaller K are those of cracks that stick, and round-off."""


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """x -> size turn x + shift, loads and strengths times `stress`, moduli times `young`; or one that is `written`."""

    name: str
    turn: Floats = field(default_factory=lambda: np.eye(2))
    shift: tuple[float, float] = (0.0, 0.0)  # m
    size: float = 1.0
    stress: float = 1.0
    young: float = 1.0
    written: Callable[[Scene], Scene] | None = None
    points_stay: bool = True  # contact points and vertices are those of the first scene
    reverses: bool = False

    @property
    def displacement(self) -> float:
        return self.size * self.stress / self.young

    def apply(self, scene: Scene) -> Scene:
        """A document (m, Pa) as `Case.to_dict` gives it, changed."""
        if self.written:
            return self.written(copy.deepcopy(scene))
        found: Scene = self._value(scene, "", "")
        for item in (*found["supports"], *found["loads"]):
            if "on" in item and not {"rectangle", "disk"}.isdisjoint(scene["bodies"][item["on"]["body"]]["shape"]):
                item["on"] = self._edge(item["on"])
        return found

    def points(self, points: Any) -> Floats:
        return np.asarray(self.size * np.asarray(points, dtype=float) @ self.turn.T + self.shift)

    def before(self, points: Floats) -> Floats:
        return np.asarray((points - np.array(self.shift)) @ self.turn / self.size)

    def _value(self, value: Any, key: str, within: str) -> Any:
        if key in PLACES and not isinstance(value, str):
            return self.points(value).tolist()
        if key == "displacement":
            return self._components(value, self.displacement)
        if key in ("traction", "gravity"):
            factor = self.stress / (self.size if key == "gravity" else 1.0)
            return [self._sum(zip(factor * row, value, strict=True)) for row in self.turn]
        if key == "stress" and isinstance(value, list):
            (a, b), (c, d) = self.turn
            rows = np.array([(a * a, b * b, 2.0 * a * b), (c * c, d * d, 2.0 * c * d), (a * c, b * d, a * d + b * c)])
            return [self._sum(zip(self.stress * row, value, strict=True)) for row in rows]
        if isinstance(value, dict):
            found = {name: self._value(inner, name, key) for name, inner in value.items()}
            if key == "rectangle" and self.turn[0, 0] == 0.0:
                found["width"], found["height"] = found["height"], found["width"]
            if "angle" in found:
                along = self.turn @ np.array([np.cos(np.deg2rad(value["angle"])), np.sin(np.deg2rad(value["angle"]))])
                found["angle"] = float(np.rad2deg(np.arctan2(along[1], along[0])))
            return value if key == "on" else found
        if isinstance(value, list):
            return [self._value(inner, "", key) for inner in value]
        factors = dict.fromkeys(LENGTHS, self.size) | dict.fromkeys(STRESSES, self.stress) | {"young": self.young}
        if (
            key not in factors
            or (key == "spacing" and within == "contact")
            or within == "units"
            or value in (None, "auto")
        ):
            return value
        return self._sum([(factors[key], value)])

    def _sum(self, parts: Any) -> Any:
        """A sum of numbers, or of formulas whose x and y are those before the change."""
        parts = [(float(factor), value) for factor, value in parts if factor != 0.0 and value != 0.0]
        if not any(isinstance(value, str) for _, value in parts):
            return float(sum(factor * value for factor, value in parts))
        (a, c), (b, d) = self.turn / self.size
        x, y = (
            f"((x - {self.shift[0]!r})*{float(p)!r} + (y - {self.shift[1]!r})*{float(q)!r})"
            for p, q in ((a, b), (c, d))
        )
        formulas = (re.sub(r"\b[xy]\b", lambda name: {"x": x, "y": y}[name[0]], str(value)) for _, value in parts)
        return " + ".join(f"{factor!r}*({text})" for (factor, _), text in zip(parts, formulas, strict=True))

    def _components(self, value: Scene, factor: float) -> Scene:
        """Prescribed components; turns are by right angles."""
        found = {}
        for name, row in zip("xy", self.turn, strict=True):
            (axis,) = np.flatnonzero(row)
            if "xy"[axis] in value:
                found[name] = self._sum([(factor * row[axis], value["xy"[axis]])])
        return found

    def _edge(self, on: Scene) -> Scene:
        """A side of a rectangle, from one coordinate to another, or a part of an arc in degrees."""
        ends = [on[end] for end in ("from", "to") if end in on]
        if on["edge"] == "arc" and self.turn[0, 0] != 1.0:
            ends = [90.0 + end for end in ends] if self.turn[0, 0] == 0.0 else [180.0 - end for end in reversed(ends)]
        elif on["edge"] in NORMALS:
            normal = np.array(NORMALS[on["edge"]])
            ends = sorted(
                float(self.points(end * np.abs(normal[::-1])) @ np.abs(self.turn @ normal)[::-1]) for end in ends
            )
            on = {**on, "edge": EDGES[tuple(int(part) for part in self.turn @ normal)]}
        return {**on, **dict(zip(("from", "to"), ends, strict=False))}


def in_other_units(scene: Scene) -> Scene:
    """In centimetres and gigapascals."""
    units = {"length": "cm", "stress": "GPa"}
    by = Change("", size=1.0 / float(UNITS["length"]["cm"]), stress=1e-9, young=1e-9)
    found = by.apply({key: part for key, part in scene.items() if key != "units"})
    for load in found["loads"]:
        if "gravity" in load:
            load["gravity"] = [by.size / by.stress * part for part in load["gravity"]]  # m/s^2 in any units
    return {**found, "units": units}


def in_another_order(scene: Scene) -> Scene:
    """Cracks, loads and supports the other way round."""
    return {
        **scene,
        "cracks": dict(reversed(scene["cracks"].items())),
        **{key: scene[key][::-1] for key in ("loads", "supports")},
    }


def _with_points(path: Scene) -> list[list[float]]:
    if "points" in path:
        return list(path["points"])
    angle = np.deg2rad(path["angle"])
    half = 0.5 * path["length"] * np.array([np.cos(angle), np.sin(angle)])
    return [(path["center"] - half).tolist(), (path["center"] + half).tolist()]


def reversed_cracks(scene: Scene) -> Scene:
    """Start and end of every crack exchanged."""
    for crack in scene["cracks"].values():
        crack["path"] = {"points": _with_points(crack["path"])[::-1]}
        crack["tips"] = {"start": "end", "end": "start"}.get(crack["tips"], crack["tips"])
    return scene


def with_more_vertices(scene: Scene) -> Scene:
    """The first segment of every crack in two."""
    for crack in scene["cracks"].values():
        first, second, *others = np.array(_with_points(crack["path"])).tolist()
        middle = (0.45 * np.array(first) + 0.55 * np.array(second)).tolist()
        crack["path"] = {"points": [first, middle, second, *others]}
    return scene


QUARTER, MIRROR = np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[-1.0, 0.0], [0.0, 1.0]])
CHANGES = {
    change.name: change
    for change in (
        Change("turned by 90 degrees", QUARTER),
        Change("mirrored", MIRROR),
        Change("other units", written=in_other_units),
        Change("scaled", size=37.0, stress=5.0, young=5.0),
        Change("another order", written=in_another_order),
        Change("reversed", written=reversed_cracks, points_stay=False, reverses=True),
        Change("a vertex more", written=with_more_vertices, points_stay=False),
    )
}


def told(step: StepResult, by: Change) -> dict[str, Floats]:
    """What a step gives, as it was before the change; of contact points the values in their order of size."""
    flip, K = float(np.linalg.det(by.turn)), by.stress * np.sqrt(by.size)
    names = {"start": "end", "end": "start"} if by.reverses else {}
    tips = sorted(step.tips, key=lambda tip: (tip.crack, names.get(tip.tip, tip.tip)))
    contact, energy = step.contact, step.energy
    found = {
        "K": np.array([(tip.K_I, flip * tip.K_II, tip.K_growth) for tip in tips]).reshape(-1, 3) / K,
        "stress at tips": np.array([(tip.sigma_1, tip.sigma_3) for tip in tips]).reshape(-1, 2) / by.stress,
        "criticality": np.array([tip.criticality for tip in tips]),
        "load factor": np.array([step.load_factor]),
        "energy": np.array([energy.work, energy.strain, energy.dissipated, energy.released]),
        "displacement": np.array([step.load_displacement]) / by.displacement,
    }
    found["energy"] = found["energy"] / (by.displacement * by.stress * by.size)
    if by.points_stay:
        tractions, jumps = (contact.normal_traction, contact.tangential_traction), (contact.opening, contact.slip)
        found["tractions"] = np.sort(np.abs(tractions), axis=1) / by.stress
        found["jumps"] = np.sort(np.abs(jumps), axis=1) / by.displacement
        found["states"] = np.sort(contact.state).astype(float)
    return found


def _size(quantity: str, known: dict[str, Floats], spacing: float) -> float:
    """What a deviation of a quantity is held against."""
    largest = float(np.nanmax(np.abs(known[quantity]), initial=0.0))
    if quantity == "K":
        stress = max(np.nanmax(np.abs(known[name]), initial=0.0) for name in ("stress at tips", "tractions"))
        return max(largest, NO_K * float(stress) * np.sqrt(spacing))
    return max(largest, abs(float(known["displacement"][0]))) if quantity == "jumps" else largest


def _path_off(one: StepResult, other: StepResult, by: Change) -> float:
    """m: the largest distance of the paths."""
    there, worst = {crack.name: by.before(crack.points) for crack in other.cracks}, 0.0
    for crack in one.cracks:
        back = there[crack.name][:: -1 if by.reverses else 1]
        if len(back) == len(crack.points):
            worst = max(worst, float(np.hypot(*(crack.points - back).T).max()))
        else:
            worst = max(worst, shapely.hausdorff_distance(*map(shapely.LineString, (crack.points, back))))
    return worst


def outcome(scene: Scene) -> tuple[list[StepResult], str]:
    """The steps of a run, and how it ended: the kind of an error, or the status."""
    steps: list[StepResult] = []
    try:
        case = Case.from_dict({**scene, "output": {"frames": "none", "figures": False, "report": False}})
        return steps, for_each(grow(case), steps.append).status
    except CrackgrowError as error:
        return steps, type(error).__name__


def deviations(scene: Scene, first: Sequence[StepResult], other: Sequence[StepResult], by: Change) -> dict[str, float]:
    """What the changed scene gave otherwise, relative: the largest of all steps by quantity, infinite for other steps.

    Of tips that are equally critical but for what a lattice resolves the leftmost grows. Which that is depends on how
    the scene is turned: where such tips grow otherwise the runs are compared up to that step.
    """
    plain, spacing = Change(""), float(scene["numerics"]["spacing"])
    scale = scene["growth"]["increment"] if scene.get("growth") else spacing
    names = {"start": "end", "end": "start"} if by.reverses else {}
    found: dict[str, float] = {}
    for one, two in zip(first, other, strict=False):
        known = told(one, plain)
        for quantity, value in told(two, by).items():
            size = _size(quantity, known, spacing)
            off = np.inf
            if value.shape == known[quantity].shape and np.array_equal(np.isnan(value), np.isnan(known[quantity])):
                off = float(np.nanmax(np.abs(value - known[quantity]), initial=0.0))
            found[quantity] = max(found.get(quantity, 0.0), off / size if size > 0.0 else off)
        found["path"] = max(found.get("path", 0.0), _path_off(one, two, by) / scale)
        grown = [
            {(t.crack, turn.get(t.tip, t.tip)) for t in step.tips if t.advanced}
            for step, turn in ((one, {}), (two, names))
        ]
        if grown[0] != grown[1]:
            critical = [t.criticality for t in one.tips if (t.crack, t.tip) in grown[0] ^ grown[1]]
            return found if min(critical) >= (1.0 - TIE) * max(critical) else {**found, "who grows": np.inf}
    return found if len(first) == len(other) else {**found, "steps": np.inf}
