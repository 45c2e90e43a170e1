"""The outline of all rock, held or loaded as a whole: outer rings of bodies, as far as no other body lies there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from crackgrow.case.check_regions import knows
from crackgrow.case.layout import Scene
from crackgrow.case.regions import Along, Edge, EdgeRegion, edge_of
from crackgrow.case.report import Faults, Path
from crackgrow.case.shapes import BodyShape, Resolved
from crackgrow.case.touching import divided, lies_on

Run = tuple[Resolved, float, float]
"""What is held along an edge, and from where to where (m) as it was drawn."""


def settle_outlines(scene: Scene) -> Faults:
    """Put supports of edges in the place of `outline`, and loads of single bodies in that of `far_field`.

    The first takes the place of the item, others come last: the numbers of other items stay.
    """
    for key, word in (("supports", "outline"), ("loads", "far_field")):
        for index, item in scene.listed(key):
            if word not in item or not scene.report.sound(key, index):
                continue
            names = [item["body"]] if "body" in item else list(scene.bodies)
            if not scene.complete or not all(knows(scene, (key, index, "body"), "body", name) for name in names):
                scene.report.doubt((key, index))  # the faults of bodies are told
                continue
            outer = {name: _outer_sides(scene, scene.bodies[name]) for name in names}
            if not any(outer.values()):
                yield (key, index), f"other bodies lie all round {', '.join(names)}: there is no outline"
            number = index
            for name, parts in outer.items():
                body = scene.bodies[name]
                loaded = [{"body": name, **item}] if parts else []
                for each in _held(scene, (key, index), item, body, parts) if word == "outline" else loaded:
                    scene.resolved[key][number : number + 1] = [each]
                    if word == "far_field":
                        sides, limits = np.array([p[0] for p in parts]), np.array([p[1:] for p in parts])
                        scene.regions[key, number, "on"] = EdgeRegion(name, "outline", sides, limits)
                    number = len(scene.resolved[key])


def _outer_sides(scene: Scene, body: BodyShape) -> list[tuple[int, float, float]]:
    """Sides of the outline of a body, each between two fractions of it, where no other body lies."""
    lines = [line for pair, lines in scene.shared.items() if body.name in pair for line in lines]
    boundary, corners = shapely.MultiLineString(lines), np.concatenate([np.empty((0, 2)), *lines])
    return [
        (number, low, high)
        for number, side in enumerate(body.rings[0].sides)
        for (low, start), (high, end) in pairwise(divided(side, corners, scene.tolerance))
        if not lies_on(boundary, start, end, scene.tolerance)
    ]


def _held(
    scene: Scene, key: Path, item: Resolved, body: BodyShape, parts: list[tuple[int, float, float]]
) -> Iterator[Resolved]:
    """Supports of the edges that these parts of sides belong to; reports parts that can't be held so."""
    for name in dict.fromkeys(body.rings[0].edge_names):
        edge = edge_of(body, name, scene.tolerance)
        total = float(edge.lengths.sum())
        for held, start, end in _runs(scene, edge, parts, item["outline"] == "fixed"):
            whole = start <= scene.tolerance and end >= total - scene.tolerance
            what = f"edge '{name}' of body '{body.name}'"
            if not held:
                inclined = "rollers hold edges along x or y, and it is inclined"
                scene.report.fault((*key, "outline"), f"{what}: {inclined}; take fixed, or load it by loads: far_field")
                return
            if not whole and edge.measure == "angle":
                scene.report.fault((*key, "outline"), f"{what} lies partly on another body: give a list of supports")
                return
            places = () if whole else _places(edge, start, end)
            part = {key: Along(place, None) for key, place in zip(("from", "to"), places, strict=False)}
            yield {"on": {"body": body.name, "edge": name, **part}, "displacement": held}


def _runs(scene: Scene, edge: Edge, parts: list[tuple[int, float, float]], fixed: bool) -> list[Run]:
    """Parts of an edge, as it was drawn, that are held alike; rollers hold nothing of an inclined side."""
    runs: list[Run] = []
    passed = 0.0
    for side, (first, last) in zip(edge.sides, edge.ends, strict=True):
        step = last - first
        length, flat = float(np.hypot(*step)), np.abs(step) <= scene.tolerance
        held = {axis: 0.0 for axis, along in zip("xy", flat, strict=True) if fixed or (along and flat.sum() == 1)}
        for limits in [part[1:] for part in parts if part[0] == side]:
            low, high = (1.0 - limits[1], 1.0 - limits[0]) if edge.backwards else limits
            start, end = passed + low * length, passed + high * length
            if runs and runs[-1][0] == held and start - runs[-1][2] <= scene.tolerance:
                start = runs.pop()[1]
            runs.append((held, start, end))
        passed += length
    return runs


def _places(edge: Edge, start: float, end: float) -> list[float]:
    """From where to where on an edge, m, by its own measure, a part between two distances (m) from its begin is."""
    if edge.measure == "distance":
        return [start, end]
    axis = "xy".index(edge.measure)
    first, last = (float(point[axis]) for point in (edge.ends[0, 0], edge.ends[-1, 1]))
    return sorted(first + math.copysign(along, last - first) for along in (start, end))
