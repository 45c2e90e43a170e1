"""Whether edge supports that cover the same part of an edge prescribe the same displacement there.

Edges that meet at a corner have no part in common: what a corner alone would have to do two ways, no edge is held to.
Points on a held edge are warned of (`run.scene_cautions`).
"""

from __future__ import annotations

import numpy as np

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
            mine, its = (scene.regions.get(("supports", each, "on")) for each in (index, other))
            places = np.empty((0, 2)) if mine is None or its is None else _shared(scene, mine, its)
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
    """Places (n, 2) m along the part of an edge that a support holds."""
    region = scene.regions[("supports", index, "on")]
    return sampled(ends_of(scene.bodies[region.body], region))


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
