"""Scenes at random whose cracks grow, of every kind that rock mechanics asks for, on a coarse lattice.

The same seed gives the same scene; the seed's remainder gives its kind. Loads balance or supports bear them, strengths
are of the size of the stress at the tips, so that most cracks grow for a few steps. What is left to chance is what
users do not think of: cracks that cross in slivers of rock, ends on outlines, loads that no friction can hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from crackgrow.case.units import UNITS
from tests.stability.judge.written import region, ring

Scene = dict[str, Any]
Rng = np.random.Generator

SAME_PLACE = 1e-9
"""Of the size of the body: an end of a crack that is closer to another one, or to the outline, lies on it."""

TRIES = 100
"""Places that are tried for a crack; one that finds none is left out."""

WEAKER = 0.4
"""Strength of rock that is pressed, over that of rock that is pulled: else most cracks under pressure never grow."""


DENSITY = 2500.0
"""kg/m^3"""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What a scene is drawn with: numbers are in the units of the case."""

    rng: Rng
    size: float
    spacing: float
    young: float
    level: float  # stress
    in_metres: float  # one unit of length
    in_pascals: float

    def weight(self, share: float) -> list[float]:
        """Gravity (m/s^2) that presses the foot of a body of this size with a share of the level of stress."""
        return [0.0, -share * self.level * self.in_pascals / (DENSITY * self.size * self.in_metres)]


def growing_scene(seed: int) -> Scene:
    """A case document."""
    rng, kind = np.random.default_rng([seed, 14]), list(SCENES)[seed % len(SCENES)]
    length, stress = str(rng.choice(["m", "cm", "mm"])), str(rng.choice(["Pa", "kPa", "MPa"]))
    in_metres, in_pascals = float(UNITS["length"][length]), float(UNITS["stress"][stress])
    size, young = float(10.0 ** rng.uniform(-1.5, 1.0)) / in_metres, float(10.0 ** rng.uniform(9.0, 11.0)) / in_pascals
    level = young * float(10.0 ** rng.uniform(-4.0, -2.7))
    frame = Frame(rng, size, size / float(rng.uniform(12.0, 18.0)), young, level, in_metres, in_pascals)
    block = rectangle(frame)
    material = {"young": frame.young, "poisson": float(rng.choice([0.0, 0.2, 0.25, 0.35])), "density": DENSITY}
    scene: Scene = {
        "title": f"growing scene {seed}: {kind}",
        "units": {"length": length, "stress": stress},
        "plane": str(rng.choice(["strain", "stress"])),
        "bodies": {"rock": {"shape": block, "material": material}},
        "supports": [],
        "loads": [],
    }
    SCENES[kind](frame, scene)
    if kind in ("hole", "in situ"):
        _cut_hole(frame, scene)
    _set_cracks(frame, scene, kind)
    if kind == "fluid":
        for name in scene["cracks"]:
            pressure = {"crack": name, "pressure": float(frame.level * rng.uniform(0.1, 1.0))}
            scene["loads"] += [pressure] if rng.random() < 0.7 else []
    _set_loading(frame, scene, kind)
    numerics: Scene = {"spacing": frame.spacing}
    if rng.random() < 0.15:
        numerics["contact"] = {"solver": "lemke"}
    return {**scene, "numerics": numerics, "output": {"frames": "none", "figures": False, "report": False}}


def rectangle(frame: Frame) -> Scene:
    """A block, with its centre anywhere."""
    rng, size = frame.rng, frame.size
    width, height = size * rng.uniform(0.7, 1.0), size * rng.uniform(0.8, 1.1)
    x, y = rng.uniform(-1.0, 1.0, 2) * size
    return {"rectangle": {"center": [float(x), float(y)], "width": float(width), "height": float(height)}}


def bounds(scene: Scene) -> tuple[float, float, float, float]:
    """Least x and y of the rock, and the largest."""
    return ring(scene["bodies"]["rock"]["shape"]).bounds


def on(edge: str, body: str = "rock", **part: float) -> Scene:
    """An edge, or a part of it."""
    return {"body": body, "edge": edge, **{key.strip("_"): float(value) for key, value in part.items()}}


def at_its_corners(scene: Scene) -> list[Scene]:
    """Supports that take rigid motions alone, where the loads balance each other."""
    x0, y0, x1, _ = bounds(scene)
    return [{"at": [x0, y0], "displacement": {"x": 0, "y": 0}}, {"at": [x1, y0], "displacement": {"y": 0}}]


def balanced(xx: float, yy: float, xy: float, held: tuple[bool, bool]) -> list[Scene]:
    """Tractions of a uniform stress on all edges; whether those on the sides and those on top and bottom are held."""
    loads = [
        {"on": on("right"), "traction": [xx, xy], "held": held[0]},
        {"on": on("left"), "traction": [-xx, -xy], "held": held[0]},
        {"on": on("top"), "traction": [xy, yy], "held": held[1]},
        {"on": on("bottom"), "traction": [-xy, -yy], "held": held[1]},
    ]
    return [load for load in loads if any(load["traction"])]


def pressed(frame: Frame, scene: Scene) -> None:
    """Compression along y, with confinement, perhaps held."""
    side = frame.level * float(frame.rng.choice([0.0, 0.0, 0.05, 0.1, 0.3]))
    scene["loads"] = balanced(-side, -frame.level, 0.0, (bool(frame.rng.random() < 0.5), False))
    scene["supports"] = at_its_corners(scene)


def pulled(frame: Frame, scene: Scene) -> None:
    """Tension along y, and shear."""
    shear = frame.level * float(frame.rng.choice([0.0, frame.rng.uniform(-0.5, 0.5)]))
    scene["loads"] = balanced(0.0, frame.level, shear, (False, False))
    scene["supports"] = at_its_corners(scene)


def driven(frame: Frame, scene: Scene) -> None:
    """A rigid platen moves the top; the bottom rests on another one, or is clamped."""
    rng, down = frame.rng, frame.level / frame.young * frame.size
    x0, y0, _, _ = bounds(scene)
    top: Scene = {"y": float(-down * rng.choice([1.0, 1.0, -0.3]))}
    if rng.random() < 0.5:
        top["x"] = float(down * rng.uniform(-1.0, 1.0))
    clamped = rng.random() < 0.5
    scene["supports"] = [
        {"on": on("bottom"), "displacement": {"x": 0, "y": 0} if clamped else {"y": 0}},
        {"on": on("top"), "displacement": top},
    ]
    if not clamped:
        scene["supports"].append({"at": [x0, y0], "displacement": {"x": 0}})


def in_situ(frame: Frame, scene: Scene) -> None:
    """Given stress in a block whose rim is fixed."""
    xx, yy = -frame.level * frame.rng.uniform(0.2, 1.0, 2)
    stress = [float(xx), float(yy), float(frame.level * frame.rng.uniform(-0.5, 0.5))]
    scene["supports"] = [{"on": on(e), "displacement": {"x": 0, "y": 0}} for e in ("left", "right", "bottom", "top")]
    scene["loads"] = [{"body": "rock", "stress": stress}]


def disk(frame: Frame, scene: Scene) -> None:
    """A disk pressed between two jaws, or all round."""
    rng, radius = frame.rng, 0.5 * frame.size
    x, y = scene["bodies"]["rock"]["shape"]["rectangle"]["center"]
    scene["bodies"]["rock"]["shape"] = {"disk": {"center": [x, y], "radius": radius}}
    half = float(rng.uniform(5.0, 20.0))
    jaws = [on("arc", from_=90.0 - half, to=90.0 + half), on("arc", from_=270.0 - half, to=270.0 + half)]
    scene["loads"] = [
        {"on": jaw, "traction": [0.0, sign * frame.level]} for jaw, sign in zip(jaws, (-1, 1), strict=True)
    ]
    scene["supports"] = [
        {"at": [x - radius, y], "displacement": {"x": 0, "y": 0}},
        {"at": [x + radius, y], "displacement": {"y": 0}},
    ]


def foundation(frame: Frame, scene: Scene) -> None:
    """A block on a rigid, rough foundation, under its weight and what presses and pushes it."""
    rng = frame.rng
    friction = float(rng.uniform(0.2, 1.5))
    push = float(rng.uniform(-0.5, 0.5) * friction * frame.level)
    cohesion = float(rng.choice([0.0, 0.0, 0.2])) * frame.level
    scene["supports"] = [{"on": on("bottom"), "contact": {"friction": friction, "cohesion": cohesion}}]
    held = bool(rng.random() < 0.5)
    scene["loads"] = [
        {"body": "rock", "gravity": frame.weight(float(rng.uniform(0.1, 0.5))), "held": held},
        {"on": on("top"), "traction": [push, -frame.level]},
    ]


def on_base(frame: Frame, scene: Scene) -> None:
    """The block on an elastic base, with contact or bonded, perhaps pushed."""
    _add_block(frame, scene, "base", 0.4)
    law = "none" if frame.rng.random() < 0.25 else _law(frame)
    scene["interfaces"] = [{"between": ["rock", "base"], "contact": "bonded" if law == "none" else law}]
    scene["supports"] = [{"on": on("bottom", "base"), "displacement": {"x": 0, "y": 0}}]
    push = frame.level * float(frame.rng.choice([0.0, frame.rng.uniform(-0.2, 0.2)]))
    scene["loads"] = [{"on": on("top"), "traction": [push, -frame.level]}]


def stack(frame: Frame, scene: Scene) -> None:
    """Blocks on top of each other on a foundation: contact alone holds them."""
    rng, held = frame.rng, bool(frame.rng.random() < 0.5)
    low, scene["interfaces"] = "rock", []
    for number in range(int(rng.integers(1, 4))):
        name = f"block{number}"
        scene["interfaces"].append(
            {"between": [low, name], "contact": {"friction": float(rng.uniform(0.2, 1.0)), "cohesion": 0}}
        )
        _add_block(frame, scene, name, 0.3, above=0.3 * number)
        low = name
    scene["supports"] = [{"on": on("bottom"), "contact": {"friction": float(rng.uniform(0.3, 1.0)), "cohesion": 0}}]
    g = frame.weight(float(rng.uniform(0.1, 0.5)))
    scene["loads"] = [{"body": name, "gravity": g, "held": held} for name in scene["bodies"]]
    scene["loads"].append(
        {"on": on("top", low), "traction": [float(0.1 * rng.uniform(-1, 1) * frame.level), -frame.level]}
    )


def _add_block(frame: Frame, scene: Scene, name: str, height: float, above: float | None = None) -> None:
    """A block as wide as the rock, below it or on top of it and of what is `above` it already (parts of its size)."""
    x0, y0, x1, y1 = bounds(scene)
    tall = height * frame.size
    y = y0 - tall / 2 if above is None else y1 + above * frame.size + tall / 2
    material = dict(scene["bodies"]["rock"]["material"])
    material["young"] = float(material["young"] * 10.0 ** frame.rng.uniform(-0.7, 0.7))
    shape = {"rectangle": {"center": [(x0 + x1) / 2, y], "width": x1 - x0, "height": tall}}
    scene["bodies"][name] = {"shape": shape, "material": material}


SCENES = {
    "plate": pressed, "tension": pulled, "hole": pressed, "edge": pressed, "crossing": pressed, "interface": on_base,
    "stack": stack, "foundation": foundation, "disk": disk, "driven": driven, "fluid": pressed, "in situ": in_situ,
    "cyclic": pressed,
}  # fmt: skip
"""By kind, in the order of the seeds."""


def _set_cracks(frame: Frame, scene: Scene, kind: str) -> None:
    """One to six polylines that may cross, touch, branch and start on the outline.

    In half of the scenes all are straight, so that K_I of closed ones is known.
    """
    rng, rock, spacing = frame.rng, region(scene["bodies"]["rock"]["shape"]), frame.spacing
    meetings = {"edge": (0.3, 0.7, 0.0, 0.0), "crossing": (0.4, 0.0, 0.3, 0.3)}.get(kind, (1.0, 0.0, 0.0, 0.0))
    n = min(int(rng.choice([1, 2, 3, 4, 6], p=[0.35, 0.25, 0.2, 0.1, 0.1])) + (kind == "crossing"), 6)
    straight = rng.random() < 0.5
    longest, apart = float(rng.uniform(3.0, 6.0)) * spacing, float(rng.choice([0.3, 1.5, 2.5])) * spacing
    lines: dict[str, LineString] = {}
    room, whole = rock.buffer(-1e-3 * spacing), rock.buffer(1e-9 * spacing)
    for number in range(n):
        meeting, others = str(rng.choice(["nothing", "outline", "touch", "cross"], p=meetings)), [*lines.values()]
        for _ in range(TRIES):
            points = _random_path(frame, rock, others, longest, 1 if straight else 2, meeting)
            line, inner = LineString(points), LineString(points[1:]) if len(points) > 2 else Point(points[1])
            near = meeting == "nothing" and min(line.distance(o) for o in [rock.boundary, *others]) < apart
            if line.is_simple and room.contains(inner) and whole.contains(line) and not near:
                lines[f"c{number}"] = line
                break
    alike = _law(frame)
    laws = [alike if rng.random() < 0.5 else _law(frame) for _ in lines]
    scene["cracks"] = {
        name: {"path": {"points": [list(point) for point in line.coords]}, "contact": law}
        for (name, line), law in zip(lines.items(), laws, strict=True)
    }
    for name, line in lines.items():
        rims = [rock.boundary, *(other for other in lines.values() if other is not line)]
        free = tuple(
            all(Point(line.coords[end]).distance(rim) > SAME_PLACE * frame.size for rim in rims) for end in (0, -1)
        )
        words = {(True, True): "both", (True, False): "start", (False, True): "end", (False, False): "none"}
        scene["cracks"][name]["tips"] = words[free] if rng.random() < 0.9 else "none"  # now and then none may grow


def _random_path(
    frame: Frame, rock: Polygon, others: list[LineString], longest: float, most: int, meeting: str
) -> np.ndarray:
    """Vertices (n, 2) of a crack that starts on the `outline`, on another crack (`touch`) or crosses it, or none."""
    rng = frame.rng
    n = int(rng.integers(1, most + 1))
    start = np.array(point_inside(rng, rock))
    if meeting == "outline":
        start = shapely.get_coordinates(rock.exterior.interpolate(rng.random(), normalized=True))[0]
    elif meeting in ("touch", "cross") and others:
        other = others[int(rng.integers(len(others)))]
        start = shapely.get_coordinates(other.interpolate(rng.choice([0.0, rng.random(), 1.0]), normalized=True))[0]
    lengths = rng.uniform(frame.spacing, longest, n)
    angles = rng.uniform(0.0, 2.0 * np.pi) + np.concatenate([[0.0], np.cumsum(rng.uniform(-1.2, 1.2, n - 1))])
    steps = lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    if meeting == "cross" and others:
        start = start - rng.uniform(0.2, 0.8) * steps[0]
    return np.vstack([start, start + np.cumsum(steps, axis=0)])


def _law(frame: Frame) -> Scene | str:
    """The law of a crack's contact: friction from none to 1.5, cohesion kept and lost, dilation."""
    rng = frame.rng
    if rng.random() < 0.04:
        return "none"
    friction = float(rng.choice([0.0, 0.3, rng.uniform(0.0, 0.6), rng.uniform(0.0, 1.5)]))
    law: Scene = {"friction": friction, "cohesion": 0.0}
    if rng.random() < 0.3:
        law["cohesion"] = float(frame.level * rng.uniform(0.01, 0.3))
        law["cohesion_after_slip"] = str(rng.choice(["lost", "kept"]))
    if rng.random() < 0.2:
        law["residual_friction"] = float(friction * rng.random())
    if rng.random() < 0.2:
        slope = float(rng.random()) * law.get("residual_friction", friction)
        law["dilation_angle"] = float(0.99 * np.rad2deg(np.arctan(slope)))
    return law


def _set_loading(frame: Frame, scene: Scene, kind: str) -> None:
    """How the load comes, and how cracks grow under it; cyclic scenes do not grow."""
    rng = frame.rng
    history = np.round(rng.choice([1.0, 0.5, -0.5, 0.3, -0.2, 0.8, 0.0], int(rng.integers(3, 9))), 3).tolist()
    if kind == "cyclic":
        scene["loading"] = {"history": history}
        return
    criterion = str(rng.choice(["strength", "directional_strength", "max_hoop_stress"]))
    radius = frame.spacing * float(rng.uniform(0.5, 1.5))
    angle = float(rng.uniform(10.0, 50.0))
    weaker = 1.0 if kind in ("tension", "fluid") else WEAKER
    tension = float(weaker * frame.level * np.sqrt(frame.spacing / radius) * 10.0 ** rng.uniform(-1.0, 0.1))
    cohesion = float(tension * (np.tan(np.deg2rad(angle)) + rng.uniform(0.5, 4.0)))
    scene["bodies"]["rock"]["strength"] = {"tension": tension, "cohesion": cohesion, "friction_angle": angle}
    loading = str(rng.choice(["once", "critical", "history"], p=[0.35, 0.4, 0.25]))
    if all(crack["tips"] == "none" for crack in scene["cracks"].values()):
        loading = "once"
    scene["growth"] = {
        "steps": int(rng.integers(3, 9)),
        "increment": frame.spacing * float(rng.uniform(0.7, 2.0)),
        "advance": str(rng.choice(["most_critical", "in_turn", "all"])),
        "criterion": criterion,
        "direction": "implicit" if criterion == "max_hoop_stress" and rng.random() < 0.3 else "explicit",
        "tip_stress": {"radius": radius},
        "unload_between_steps": bool(loading == "critical" or rng.random() < 0.6),
    }
    if loading == "critical":
        scene["loading"] = "critical"
    elif loading == "history":
        scene["loading"] = {"history": [*history[:2], 1.0]}


def _cut_hole(frame: Frame, scene: Scene) -> None:
    """Cut a hole into the rock where there is room for one."""
    rng, shape = frame.rng, scene["bodies"]["rock"]["shape"]
    radius = frame.size * rng.uniform(0.05, 0.15)
    room = ring(shape).buffer(-1.5 * radius)
    if room.is_empty:
        return
    place = point_inside(rng, room)
    kind = str(rng.choice(["disk", "rectangle", "polygon"]))
    if kind == "polygon":
        angles = np.sort(rng.uniform(0.0, 2.0, 3)) + np.array([0.0, 2.0, 4.0])
        corners = place + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        shape["holes"] = [{"polygon": corners.tolist()}]
    else:
        sides = {"radius": float(radius)} if kind == "disk" else {"width": float(radius), "height": float(2.0 * radius)}
        shape["holes"] = [{kind: {"center": [*place], **sides}}]


def point_inside(rng: Rng, polygon: Polygon) -> tuple[float, float]:
    """A point inside of a polygon."""
    low, high = np.array(polygon.bounds).reshape(2, 2)
    for _ in range(TRIES):
        point = rng.uniform(low, high)
        if polygon.contains(Point(point)):
            return float(point[0]), float(point[1])
    point = polygon.representative_point()
    return float(point.x), float(point.y)
