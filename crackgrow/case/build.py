"""From the resolved mapping, all SI and checked, to the frozen data of the model."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crackgrow.case.model import (
    Body,
    Case,
    ContactNumerics,
    CoulombContact,
    Crack,
    EdgeRegion,
    EdgeSupport,
    EdgeTraction,
    Floats,
    Growth,
    Material,
    Numerics,
    Output,
    PointSupport,
    Strength,
)

Resolved = dict[str, Any]  # a part of the resolved case

RECTANGLE_EDGES = ("bottom", "right", "top", "left")

REPEATED_VERTEX = 1e-9  # vertices nearer than this part of the crack's extent are one


def build_case(name: str, resolved: Resolved) -> Case:
    """Return the case of a resolved mapping that has no faults."""
    return Case(
        name=name,
        title=resolved["title"],
        source=resolved["source"],
        plane=resolved["plane"],
        bodies=tuple(_body(key, body) for key, body in resolved["bodies"].items()),
        cracks=tuple(_crack(key, crack) for key, crack in resolved["cracks"].items()),
        supports=tuple(_support(support) for support in resolved["supports"]),
        loads=tuple(EdgeTraction(region_of(load["on"]), tuple(load["traction"])) for load in resolved["loads"]),
        load_factors=tuple(resolved["loading"]["history"]),
        growth=_growth(resolved["growth"]) if "growth" in resolved else None,
        numerics=_numerics(resolved["numerics"]),
        output=_output(resolved["output"]),
        resolved=resolved,
    )


def outline_of(shape: Resolved) -> tuple[Floats, tuple[str, ...]]:
    """Return the corners `(n, 2) float` in m, counter-clockwise, and the name of the edge after each."""
    rectangle = shape["rectangle"]
    x, y = rectangle["center"]
    a, b = rectangle["width"] / 2, rectangle["height"] / 2
    return frozen([(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]), RECTANGLE_EDGES


def points_of(path: Resolved) -> Floats:
    """Return the vertices `(n, 2) float` of a crack in m from start to end, repeated ones once.

    n is 1 if all vertices are one and 0 if none is given.
    """
    if "points" not in path:
        x, y = path["center"]
        cos, sin = _direction(path["angle"])
        a = path["length"] / 2
        return frozen([(x - a * cos, y - a * sin), (x + a * cos, y + a * sin)])
    points = np.array(path["points"], dtype=float).reshape(-1, 2)
    if len(points) == 0:
        return frozen(points)
    smallest = REPEATED_VERTEX * math.hypot(*np.ptp(points, axis=0))
    kept = [points[0]]
    for point in points[1:]:
        if math.dist(point, kept[-1]) > smallest:
            kept.append(point)
    return frozen(kept)


def region_of(on: Resolved) -> EdgeRegion:
    """Return the edge or part of an edge."""
    return EdgeRegion(on["body"], on["edge"], on.get("from"), on.get("to"))


def frozen(values: object) -> Floats:
    """Return a float array that cannot be written to."""
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def _direction(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle in degrees, exact at right angles."""
    quarter, rest = divmod(angle % 360.0, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    radians = math.radians(angle % 360.0)
    return math.cos(radians), math.sin(radians)


def _body(name: str, body: Resolved) -> Body:
    outline, edge_names = outline_of(body["shape"])
    strength = Strength(**body["strength"]) if "strength" in body else None
    return Body(name, outline, edge_names, Material(**body["material"]), strength)


def _crack(name: str, crack: Resolved) -> Crack:
    tips, contact = crack["tips"], crack["contact"]
    return Crack(
        name=name,
        points=points_of(crack["path"]),
        tip_at_start=tips in ("both", "start"),
        tip_at_end=tips in ("both", "end"),
        contact=None if contact == "none" else CoulombContact(**contact),
    )


def _support(support: Resolved) -> PointSupport | EdgeSupport:
    displacement = (support["displacement"].get("x"), support["displacement"].get("y"))
    if "at" in support:
        return PointSupport(frozen(support["at"]), displacement)
    return EdgeSupport(region_of(support["on"]), displacement)


def _growth(growth: Resolved) -> Growth:
    return Growth(
        steps=growth["steps"],
        increment=growth["increment"],
        advance=growth["advance"],
        criterion=growth["criterion"],
        tip_radius=growth["tip_stress"]["radius"],
        unload_between_steps=growth["unload_between_steps"],
    )


def _numerics(numerics: Resolved) -> Numerics:
    contact = dict(numerics["contact"])
    if contact["stiffness"] == "rigid":
        contact["stiffness"] = None
    return Numerics(numerics["spacing"], numerics["support"], numerics["quadrature"], ContactNumerics(**contact))


def _output(output: Resolved) -> Output:
    return Output(output["frames"], tuple(dict.fromkeys(output["fields"])), output["figures"])
