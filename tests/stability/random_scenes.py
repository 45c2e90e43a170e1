"""Scenes at random: everything that the case format allows in one body or two, on a coarse lattice.

The same seed gives the same scene. Numbers are drawn so that a scene is possible, not so that it is likely: supports
hold the rock, cracks lie inside it, laws of contact make no energy. What is left to chance is what users do not think
of: cracks that cross in slivers of rock, ends on outlines, loads that no friction can hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
import yaml
from shapely import LineString, Point, Polygon
from shapely.affinity import translate

from crackgrow.case.units import UNITS

Scene = dict[str, Any]
Rng = np.random.Generator

SAME_PLACE = 1e-9
"""Of the size of the body: an end of a crack that is closer to another one, or to the outline, lies on it."""

TRIES = 100
"""Places that are tried for a crack; one that finds none is left out."""

MOST_GAUSS_SEGMENTS = 1
"""A segment has 50 contact points then, and an increment is followed from change to change of every one of them."""


@dataclass(frozen=True, slots=True)
class Manner:
    """How cracks are drawn."""

    n: int
    longest: float  # spacings, of a segment
    most_segments: int = 3
    meetings: tuple[float, ...] = (0.4, 0.2, 0.2, 0.2)  # probabilities: meets nothing, the outline; touches, crosses
    apart: float = 0.0  # spacings: one that meets nothing is as far from all others and the outline


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A body's shape, in the units of the case, and what loads and supports can act on."""

    shape: Scene
    polygon: Polygon
    regions: list[Scene]  # edges, or parts of them, without the body's name
    places: np.ndarray  # (k, 2) points on the rim


def random_scene(seed: int) -> Scene:
    """A case document."""
    rng = np.random.default_rng(seed)
    length, stress = rng.choice(["m", "cm", "mm", "km"]), rng.choice(["Pa", "kPa", "MPa", "GPa"])
    size = float(10.0 ** rng.uniform(-1.0, 2.0))
    spacing = size / rng.uniform(6.0, 10.0)
    young = 10.0 ** rng.uniform(4.0, 12.0) / float(UNITS["stress"][stress])
    level = young * 10.0 ** rng.uniform(-6.0, -2.0)
    outline = random_outline(rng, size)
    bodies = {"rock": {"shape": outline.shape, "material": random_material(rng, young)}}
    cracks = random_cracks(rng, outline.polygon, spacing, Manner(int(rng.integers(1, 4)), 4.0))
    scene: Scene = {
        "title": f"random scene {seed}",
        "units": {"length": str(length), "stress": str(stress)},
        "plane": str(rng.choice(["strain", "stress"])),
        "bodies": bodies,
        "cracks": {name: random_crack(rng, points, level) for name, points in cracks.items()},
        "numerics": _numerics(rng, spacing, sum(len(points) - 1 for points in cracks.values())),
    }
    set_tips(rng, scene, outline.polygon, size)
    held = outline
    if "rectangle" in outline.shape and "holes" not in outline.shape and rng.random() < 0.4:
        held = _base(rng, scene, outline, level)
    scene["supports"] = random_supports(rng, held, "rock" if held is outline else "base", level, level / young * size)
    scene["loads"] = random_loads(rng, outline, list(cracks), level, size, stress)
    _set_growth(rng, scene, level, spacing)
    return scene


def text_of(scene: Scene) -> str:
    """A case document as YAML."""
    return yaml.safe_dump(_plain(scene), sort_keys=False)


def _plain(value: Any) -> Any:
    """The same with numbers and texts of Python alone."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    return value.item() if isinstance(value, np.generic) else value


def random_outline(rng: Rng, size: float) -> Outline:
    """A rectangle, a polygon that is convex or not, or a disk, perhaps with a hole."""
    kind = rng.choice(["rectangle", "convex", "star", "disk"])
    centre = rng.uniform(-1.0, 1.0, 2) * size
    if kind == "rectangle":
        width, height = size * rng.uniform(0.6, 1.0, 2)
        shape: Scene = {"rectangle": {"center": centre.tolist(), "width": float(width), "height": float(height)}}
        x, y = centre
        polygon = shapely.box(x - width / 2, y - height / 2, x + width / 2, y + height / 2)
        regions: list[Scene] = [{"edge": name} for name in ("bottom", "right", "top", "left")]
    elif kind == "disk":
        shape = {"disk": {"center": centre.tolist(), "radius": 0.5 * size}}
        polygon = Point(centre).buffer(0.499 * size, quad_segs=90)
        starts = rng.uniform(0.0, 360.0) + np.array([0.0, 90.0, 180.0, 270.0])
        regions = [{"edge": "arc", "from": float(a), "to": float(a + rng.uniform(10.0, 80.0))} for a in starts]
    else:
        n = int(rng.integers(3, 8))
        turns = np.sort(rng.uniform(0.0, 1.0, n)) * 0.4 + np.arange(n)  # no angle above 1.4/3 of a full turn
        radii = 0.5 * size * (np.ones(n) if kind == "convex" else rng.uniform(0.45, 1.0, n))
        angles = 2.0 * np.pi * turns / n
        corners = centre + radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        shape, polygon = {"polygon": corners.tolist()}, Polygon(corners)
        regions = [{"edge": str(k)} for k in range(n)]
    if kind != "disk" and rng.random() < 0.3:
        polygon = with_hole(rng, shape, polygon, size)
    places = shapely.get_coordinates(polygon.exterior)[:-1]
    return Outline(shape, polygon, regions, places)


def with_hole(rng: Rng, shape: Scene, polygon: Polygon, size: float) -> Polygon:
    """Cut a hole into a shape where there is room for one."""
    radius = size * rng.uniform(0.05, 0.15)
    room = polygon.buffer(-1.5 * radius)
    if room.is_empty:
        return polygon
    x, y = point_inside(rng, room)
    kind = rng.choice(["disk", "rectangle", "polygon"])
    if kind == "disk":
        hole: Scene = {"disk": {"center": [x, y], "radius": float(radius)}}
        ring = Point(x, y).buffer(radius, quad_segs=90)
    elif kind == "rectangle":
        hole = {"rectangle": {"center": [x, y], "width": float(radius), "height": float(2.0 * radius)}}
        ring = shapely.box(x - radius / 2, y - radius, x + radius / 2, y + radius)
    else:
        angles = np.sort(rng.uniform(0.0, 2.0, 3)) + np.array([0.0, 2.0, 4.0])
        corners = np.array([x, y]) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        hole, ring = {"polygon": corners.tolist()}, Polygon(corners)
    shape["holes"] = [hole]
    return polygon.difference(ring)


def point_inside(rng: Rng, polygon: Polygon) -> tuple[float, float]:
    """A point inside of a polygon."""
    low, high = np.array(polygon.bounds).reshape(2, 2)
    for _ in range(TRIES):
        point = rng.uniform(low, high)
        if polygon.contains(Point(point)):
            return float(point[0]), float(point[1])
    point = polygon.representative_point()
    return float(point.x), float(point.y)


def random_cracks(rng: Rng, polygon: Polygon, spacing: float, manner: Manner) -> dict[str, np.ndarray]:
    """Polylines that may cross, touch, branch and start on the outline."""
    cracks: dict[str, np.ndarray] = {}
    room = polygon.buffer(-1e-3 * spacing)
    for number in range(manner.n):
        meeting = str(rng.choice(["nothing", "outline", "touch", "cross"], p=manner.meetings))
        others = [LineString(points) for points in cracks.values()]
        alone = meeting == "nothing" and manner.apart > 0.0
        for _ in range(TRIES):
            points = _random_path(rng, polygon, list(cracks.values()), spacing, manner, meeting)
            line = LineString(points)
            inner = LineString(points[1:]) if len(points) > 2 else Point(points[1])
            near = alone and min(line.distance(o) for o in [polygon.boundary, *others]) < manner.apart * spacing
            inside = room.contains(inner) and polygon.buffer(1e-9 * spacing).contains(line)
            if line.is_simple and inside and not near:
                cracks[f"c{number}"] = points
                break
    return cracks


def _random_path(
    rng: Rng, polygon: Polygon, others: list[np.ndarray], spacing: float, manner: Manner, meeting: str
) -> np.ndarray:
    """Vertices (n, 2) of a crack that starts on the `outline`, on another crack (`touch`) or crosses it, or none."""
    n = int(rng.integers(1, manner.most_segments + 1))
    start = np.array(point_inside(rng, polygon))
    if meeting == "outline":
        start = shapely.get_coordinates(polygon.exterior.interpolate(rng.random(), normalized=True))[0]
    elif meeting in ("touch", "cross") and others:
        other = LineString(others[int(rng.integers(len(others)))])
        start = shapely.get_coordinates(other.interpolate(rng.choice([0.0, rng.random(), 1.0]), normalized=True))[0]
    lengths = spacing * rng.uniform(1.0, manner.longest, n)
    angles = rng.uniform(0.0, 2.0 * np.pi) + np.concatenate([[0.0], np.cumsum(rng.uniform(-1.2, 1.2, n - 1))])
    steps = lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    if meeting == "cross" and others:
        start = start - rng.uniform(0.2, 0.8) * steps[0]
    return np.vstack([start, start + np.cumsum(steps, axis=0)])


def random_crack(rng: Rng, points: np.ndarray, level: float) -> Scene:
    contact = "none" if rng.random() < 0.1 else random_law(rng, level)
    return {"path": {"points": points.tolist()}, "contact": contact}


def random_law(rng: Rng, level: float) -> Scene:
    """A law of contact that makes no energy."""
    friction = float(rng.choice([0.0, rng.uniform(0.0, 1.0), rng.uniform(0.0, 2.0)]))
    law: Scene = {"friction": friction, "cohesion": float(rng.choice([0.0, level * 10.0 ** rng.uniform(-2.0, 0.5)]))}
    if rng.random() < 0.3:
        law["residual_friction"] = float(friction * rng.random())
    if rng.random() < 0.3:
        law["cohesion_after_slip"] = str(rng.choice(["lost", "kept"]))
    if rng.random() < 0.2:
        law["dilation_angle"] = float(
            0.99 * np.rad2deg(np.arctan(rng.random() * law.get("residual_friction", friction)))
        )
    return law


def random_material(rng: Rng, young: float) -> Scene:
    return {"young": young, "poisson": float(rng.choice([0.0, 0.25, 0.49, rng.uniform(0.0, 0.49)])), "density": 2500}


def _numerics(rng: Rng, spacing: float, n_segments: int) -> Scene:
    """Settings; the 50 contact points that gauss has on a segment are for few segments."""
    stiffness: str | float = "rigid" if rng.random() < 0.6 else float(10.0 ** rng.uniform(0.0, 4.0))
    few, wanted = stiffness != "rigid" and n_segments <= MOST_GAUSS_SEGMENTS, rng.random() < 0.7
    discretization = "gauss" if few and wanted else "mortar"
    solver = "newton" if rng.random() < 0.6 else "lemke"
    contact = {"stiffness": stiffness, "discretization": discretization, "solver": solver}
    return {"spacing": spacing, "support": float(rng.choice([1.5, 2.0, 2.0, 2.5])), "contact": contact}


def set_tips(rng: Rng, scene: Scene, polygon: Polygon, size: float) -> None:
    """Say which ends of the cracks are tips: those that lie in rock; now and then they must not grow."""
    lines = {name: LineString(crack["path"]["points"]) for name, crack in scene["cracks"].items()}
    for name, crack in scene["cracks"].items():
        others = [polygon.boundary, *(line for other, line in lines.items() if other != name)]
        free = [
            all(Point(crack["path"]["points"][end]).distance(other) > SAME_PLACE * size for other in others)
            for end in (0, -1)
        ]
        words = {(True, True): "both", (True, False): "start", (False, True): "end", (False, False): "none"}
        crack["tips"] = words[free[0], free[1]] if rng.random() < 0.9 else "none"


def _base(rng: Rng, scene: Scene, outline: Outline, level: float) -> Outline:
    """Put a second body below the rock, which lies on it by contact; the base is what supports hold."""
    x0, y0, x1, y1 = outline.polygon.bounds
    width, height = (x1 - x0) * rng.choice([1.0, 1.3]), 0.5 * (y1 - y0)
    box = translate(shapely.box(-width / 2, -height, width / 2, 0.0), (x0 + x1) / 2, y0)
    rock = scene["bodies"]["rock"]["material"]
    centre = [(x0 + x1) / 2, y0 - height / 2]
    corners = np.array([[centre[0] - width / 2, y0 - height], [centre[0] + width / 2, y0 - height]])
    shape: Scene = {"rectangle": {"center": centre, "width": float(width), "height": float(height)}}
    material = random_material(rng, rock["young"] * 10.0 ** rng.uniform(-2.0, 2.0))
    scene["bodies"]["base"] = {"shape": shape, "material": material}
    law: str | Scene = "bonded" if rng.random() < 0.3 else random_law(rng, level)
    scene["interfaces"] = [{"between": ["rock", "base"], "contact": law}]
    regions: list[Scene] = [{"edge": name} for name in ("bottom", "right", "left")]
    return Outline(shape, box, regions, corners)


def random_supports(rng: Rng, outline: Outline, body: str, level: float, displacement: float) -> list[Scene]:
    """Supports that hold a body: at two points, along an edge, along two that part, or a foundation."""
    kind = str(rng.choice(["points", "clamped", "stretched", "foundation"], p=[0.4, 0.25, 0.2, 0.15]))
    first, second = (dict(outline.regions[k], body=body) for k in rng.permutation(len(outline.regions))[:2])
    if kind == "points" and len(outline.places) < 100:  # else a disk, whose corners are not known here
        a, b = outline.places[rng.permutation(len(outline.places))[:2]]
        across = "y" if abs(a[0] - b[0]) > abs(a[1] - b[1]) else "x"
        return [
            {"at": a.tolist(), "body": body, "displacement": {"x": 0, "y": 0}},
            {"at": b.tolist(), "body": body, "displacement": {across: 0}},
        ]
    if kind == "stretched":
        x, y = displacement * rng.uniform(-1.0, 1.0, 2)
        along: Scene = {"x": float(x)} if rng.random() < 0.5 else {"x": float(x), "y": float(y)}
        if rng.random() < 0.3:
            along = {"y": f"{float(y)!r}*cos(x/{abs(displacement) + 1.0!r})"}
        return [
            {"on": first, "displacement": {"x": 0, "y": 0}},
            {"on": second, "displacement": along},
        ]
    if kind == "foundation":
        supports: list[Scene] = [{"on": first, "contact": random_law(rng, level)}]
        if rng.random() < 0.5:
            supports.append({"on": second, "displacement": {str(rng.choice(["x", "y"])): 0}})
        return supports
    return [{"on": first, "displacement": {"x": 0, "y": 0}}]


def random_loads(rng: Rng, outline: Outline, cracks: list[str], level: float, size: float, stress: str) -> list[Scene]:
    """One to three loads of any kind on the rock."""
    loads: list[Scene] = []
    for _ in range(int(rng.integers(1, 4))):
        amount = level * rng.uniform(0.1, 1.0)
        kind = str(rng.choice(["traction", "press", "gravity", "stress", "pressure"], p=[0.35, 0.35, 0.1, 0.1, 0.1]))
        region = dict(outline.regions[int(rng.integers(len(outline.regions)))], body="rock")
        inward = np.array([0.0, -1.0]) if region["edge"] == "top" else rng.uniform(-1.0, 1.0, 2)
        load: Scene = {"on": region, "traction": (amount * rng.uniform(-1.0, 1.0, 2)).tolist()}
        if kind == "press":
            load = {"on": region, "traction": (amount * inward).tolist()}
        elif kind == "gravity":
            load = {"body": "rock", "gravity": [0, float(-9.81 * 10.0 ** rng.uniform(-1.0, 1.0))]}
        elif kind == "stress":
            load = {"body": "rock", "stress": (amount * rng.uniform(-1.0, 0.2, 3)).tolist()}
        elif kind == "pressure" and cracks:
            load = {"crack": str(rng.choice(cracks)), "pressure": float(amount)}
        if rng.random() < 0.2:
            load["held"] = True
        loads.append(load)
    return loads


def _set_growth(rng: Rng, scene: Scene, level: float, spacing: float) -> None:
    """Let the cracks grow, one scene in two, and load the scene in more than one increment, one in three."""
    tips = any(crack["tips"] != "none" for crack in scene["cracks"].values())
    scaled = any(not load.get("held", False) for load in scene["loads"])
    if tips and rng.random() < 0.5:
        criterion = str(rng.choice(["strength", "directional_strength", "max_hoop_stress"]))
        scene["growth"] = {
            "steps": int(rng.integers(1, 3)),
            "increment": float(spacing * rng.uniform(0.8, 1.6)),
            "advance": str(rng.choice(["most_critical", "in_turn", "all"])),
            "criterion": criterion,
            "direction": "implicit" if criterion == "max_hoop_stress" and rng.random() < 0.3 else "explicit",
            "tip_stress": {"radius": float(spacing * rng.uniform(0.5, 1.5))},
            "unload_between_steps": bool(rng.random() < 0.6),
        }
        angle, tension = float(rng.uniform(0.0, 60.0)), float(level * 10.0 ** rng.uniform(-1.5, 1.0))
        cohesion = float(tension * (np.tan(np.deg2rad(angle)) + rng.uniform(0.1, 3.0)))
        strength = {"tension": tension, "cohesion": cohesion, "friction_angle": angle}
        scene["bodies"]["rock"]["strength"] = strength
        if scaled and rng.random() < 0.3:
            scene["loading"], scene["growth"]["unload_between_steps"] = "critical", True
    if "loading" not in scene and rng.random() < 0.35:
        scene["loading"] = {"history": rng.choice([1.0, 0.5, -0.5, 0.0, 2.0, -1.0], int(rng.integers(1, 4))).tolist()}
    if rng.random() < 0.9:
        scene["output"] = {"frames": "none", "figures": False}
