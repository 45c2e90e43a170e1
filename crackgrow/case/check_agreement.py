"""Whether supports that hold the same place prescribe the same displacement there.

A point on a supported edge, at its ends too, and parts of edges that two supports cover. Edges that meet at a corner
have no part in common: what a corner alone would have to do two ways, no edge is held to.
"""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.check_supports import sampled
from crackgrow.case.formula import CoordinateFormula
from crackgrow.case.layout import Scene
from crackgrow.case.model import EdgeRegion
from crackgrow.case.regions import SAME_PLACE, ends_of

ALIKE = 1e-6
"""Of the largest displacement of both supports: two that differ by less are one."""


def check_agreement(scene: Scene) -> None:
    """Report components of a displacement that another support prescribes otherwise at a place of both."""
    earlier: list[int] = []
    for index, _ in scene.items("supports", "displacement"):
        for other in earlier:
            places = _common(scene, index, other)
            if len(places):
                _compare(scene, index, other, places)
        earlier.append(index)


def _compare(scene: Scene, index: int, other: int, places: Floats) -> None:
    """Report the components that differ at one of the places (n, 2) m of two supports."""
    displacement, its = (scene.resolved["supports"][each]["displacement"] for each in (index, other))
    for component in [name for name in displacement if name in its]:
        here, there = (_values(each[component], places) for each in (displacement, its))
        of_mine = _values(displacement[component], _places(scene, index))
        of_other = _values(its[component], _places(scene, other))
        if here is None or there is None or of_mine is None or of_other is None:
            continue
        apart, largest = np.abs(here - there), float(np.abs(np.concatenate([of_mine, of_other])).max())
        if np.any(apart > ALIKE * largest):
            worst = int(np.argmax(apart))
            message = (
                f"{component} at {scene.point(places[worst])} is {scene.length(float(here[worst]))} here and "
                f"{scene.length(float(there[worst]))} by supports.{other}; a place can be held in one way alone"
            )
            scene.report.fault(("supports", index, "displacement", component), message)


def _values(value: float | str, places: Floats) -> Floats | None:
    """Displacements (n,) m at places (n, 2) m; None where a formula has none, which is a fault already."""
    if not isinstance(value, str):
        return np.full(len(places), value)
    values, nowhere = CoordinateFormula(value).values(places)
    return values if nowhere is None else None


def _places(scene: Scene, index: int) -> Floats:
    """Places (n, 2) m of a support: its point, or along its part of an edge."""
    region = _region(scene, index)
    if region is None:
        return np.array([scene.resolved["supports"][index]["at"]])
    return sampled(ends_of(scene.bodies[region.body], region))


def _common(scene: Scene, index: int, other: int) -> Floats:
    """Places (n, 2) m that both of two supports hold; two at one point are a fault already."""
    supports = [scene.resolved["supports"][number] for number in (index, other)]
    regions = [_region(scene, number) for number in (index, other)]
    points = [support for support in supports if "at" in support]
    along = [region for region in regions if region is not None]
    if len(along) == 2:
        return _shared(scene, along[0], along[1])
    if len(points) == 1 and len(along) == 1 and points[0].get("body") == along[0].body:
        lines = shapely.linestrings(ends_of(scene.bodies[along[0].body], along[0]))
        if np.any(shapely.dwithin(lines, shapely.Point(points[0]["at"]), scene.tolerance)):
            return np.array([points[0]["at"]])
    return np.empty((0, 2))


def _region(scene: Scene, index: int) -> EdgeRegion | None:
    """The part of an edge that a support holds; None of a point, and where it cannot be told."""
    return scene.regions.get(("supports", index, "on"))


def _shared(scene: Scene, first: EdgeRegion, second: EdgeRegion) -> Floats:
    """Places (n, 2) m along the parts of sides that two regions have in common."""
    if first.body != second.body:
        return np.empty((0, 2))
    sides, found = scene.bodies[first.body].sides, []
    for side, limits in zip(first.sides.tolist(), first.limits, strict=True):
        for its_side, its_limits in zip(second.sides.tolist(), second.limits, strict=True):
            low, high = max(limits[0], its_limits[0]), min(limits[1], its_limits[1])
            if side == its_side and high - low > SAME_PLACE:
                start, end = sides[side]
                found.append([start + share * (end - start) for share in (low, high)])
    return sampled(np.array(found)) if found else np.empty((0, 2))
