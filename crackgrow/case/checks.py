"""What no single key can tell: whether the parts of a case fit together. Faults go to the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from shapely import Polygon

from crackgrow.case.build import outline_of, points_of
from crackgrow.case.model import Floats
from crackgrow.case.report import Report
from crackgrow.case.units import Units

MAX_NODES = 4_000_000  # lattice nodes; beyond, the memory of no workstation suffices
MIN_SPACINGS_ACROSS = 2  # of the smaller side of a body
SHORTEST = 1e-3  # least crack length and increment, in lattice spacings
ON_OUTLINE = 1e-9  # points nearer to the outline than this part of the body's diagonal lie on it
FARTHEST = 1e5  # largest distance of a body from the origin, in diagonals: coordinates must resolve ON_OUTLINE


@dataclass(frozen=True, slots=True)
class BodyShape:
    """Geometry of a body whose shape has no fault."""

    name: str
    outline: Floats  # (n, 2) m
    edge_names: tuple[str, ...]
    polygon: Polygon
    size: float  # m, diagonal of the bounding box
    tolerance: float  # m, nearer points lie on the outline

    @property
    def sides(self) -> Floats:
        """Width and height of the bounding box, `(2,) float` in m."""
        return np.asarray(np.ptp(self.outline, axis=0), dtype=float)


@dataclass(frozen=True, slots=True)
class Scene:
    """The resolved case, sound or not, with what checks need of it."""

    resolved: dict[str, Any]
    report: Report
    units: Units
    bodies: dict[str, BodyShape]  # the one body of this version, if its shape is sound
    cracks: dict[str, Floats]  # points (n, 2) m of those with a sound path

    def get(self, *path: str) -> Any:
        """Return the value at a key path if it is given and sound, else None."""
        value: Any = self.resolved
        if not self.report.sound(*path):
            return None
        for key in path:
            if key not in value:
                return None
            value = value[key]
        return value

    def length(self, value: float) -> str:
        """Write a length in the units of the case."""
        return self.units.show(value, "length")

    def point(self, point: Floats | list[float]) -> str:
        """Write a point in the units of the case."""
        return f"({self.length(point[0])}, {self.length(point[1])})"


def scene_of(resolved: dict[str, Any], report: Report, units: Units) -> Scene:
    """Collect the geometry of the body and the cracks that are sound; a body too far from the origin is a fault."""
    scene = Scene(resolved, report, units, {}, {})
    for name, body in list(named(resolved, "bodies").items())[:1]:
        if report.sound("bodies", name, "shape"):
            outline, edge_names = outline_of(body["shape"])
            size, distance = float(np.hypot(*np.ptp(outline, axis=0))), float(np.abs(outline).max())
            if distance <= FARTHEST * size:
                scene.bodies[name] = BodyShape(name, outline, edge_names, Polygon(outline), size, ON_OUTLINE * size)
            else:
                message = f"{scene.length(distance)} from the origin is too far for a body of size {scene.length(size)}"
                report.fault(("bodies", name, "shape"), f"{message}: coordinates lose accuracy; move the scene")
    for name, crack in named(resolved, "cracks").items():
        if report.sound("cracks", name, "path"):
            scene.cracks[name] = points_of(crack["path"])
    return scene


def named(resolved: dict[str, Any], key: str) -> dict[str, Any]:
    """Return the things under names, empty if they could not be read."""
    things = resolved.get(key)
    return things if isinstance(things, dict) else {}


def check_counts(scene: Scene) -> None:
    """One body, one load factor, unloading between steps: all that this version can do."""
    report = scene.report
    names = list(named(scene.resolved, "bodies"))
    if not names and report.sound("bodies"):
        report.fault(("bodies",), "no body given; a case needs one")
    for name in names[1:]:
        report.fault(("bodies", name), f"one body in this version, which is '{names[0]}'")
    history = scene.get("loading", "history")
    if history is not None and len(history) != 1:
        report.fault(("loading", "history"), f"{len(history)} factors given; exactly one in this version")
    if scene.get("growth", "unload_between_steps") is False:
        report.fault(("growth", "unload_between_steps"), "only true is supported in this version")


def check_material(scene: Scene) -> None:
    """Poisson's ratio 1/2 has no plane strain stiffness; growth needs a strength."""
    report = scene.report
    for name in named(scene.resolved, "bodies"):
        poisson = scene.get("bodies", name, "material", "poisson")
        if scene.get("plane") == "strain" and poisson is not None and poisson >= 0.5:
            message = f"{poisson:g} given; wanted in plane strain: a number > -1 and < 0.5 (0.5: incompressible)"
            report.fault(("bodies", name, "material", "poisson"), message)
        growing = "growth" in scene.resolved and named(scene.resolved, "cracks")
        strength = ("bodies", name, "strength")
        if growing and report.sound(*strength) and scene.get("bodies", name, "strength") is None:
            message = "missing: growth is given, so the rock needs a strength {tension, cohesion, friction_angle}"
            report.fault(strength, message)
        _check_tension(scene, name)


def _check_tension(scene: Scene, name: str) -> None:
    """The tensile strength cuts off the Mohr-Coulomb cone below its apex, c / tan(phi)."""
    strength = scene.get("bodies", name, "strength")
    if strength is None or not scene.report.sound("bodies", name, "strength"):
        return
    slope = np.tan(np.deg2rad(strength["friction_angle"]))
    if strength["tension"] * slope > strength["cohesion"]:
        apex = scene.units.show(strength["cohesion"] / slope, "stress")
        message = f"above the apex of the shear strength, cohesion / tan(friction_angle) = {apex}; wanted: at most that"
        scene.report.fault(("bodies", name, "strength", "tension"), message)


def check_numerics(scene: Scene) -> None:
    """The lattice fits the body, the increment fits the lattice, the contact settings fit each other."""
    report = scene.report
    spacing = scene.get("numerics", "spacing")
    if spacing is not None:
        for body in scene.bodies.values():
            _check_spacing(scene, body, spacing)
        increment = scene.get("growth", "increment")
        if increment is not None and increment < SHORTEST * spacing:
            limit = f"{SHORTEST:g} of the lattice spacing, {scene.length(SHORTEST * spacing)}"
            report.fault(("growth", "increment"), f"{scene.length(increment)} is less than {limit}")
    discretization = scene.get("numerics", "contact", "discretization")
    if discretization == "gauss" and scene.get("numerics", "contact", "stiffness") == "rigid":
        message = (
            "gauss with rigid contact has more contact points than the displacement can follow, so no unique traction; "
            "use mortar, or give numerics.contact.stiffness a number such as 100"
        )
        report.fault(("numerics", "contact", "discretization"), message)


def _check_spacing(scene: Scene, body: BodyShape, spacing: float) -> None:
    key = ("numerics", "spacing")
    side = float(body.sides.min())
    if spacing > side / MIN_SPACINGS_ACROSS:
        limit = f"half the smaller side of body '{body.name}', {scene.length(side / MIN_SPACINGS_ACROSS)}"
        scene.report.fault(key, f"{scene.length(spacing)} is too coarse; at most {limit}")
        return
    margin = 2 * (scene.get("numerics", "support") or 0.0) + 1
    n_nodes = float(np.prod(body.sides / spacing + margin))
    if n_nodes > MAX_NODES:
        message = f"{scene.length(spacing)} gives about {n_nodes:.2g} lattice nodes; at most {MAX_NODES:g} are allowed"
        scene.report.fault(key, message)
