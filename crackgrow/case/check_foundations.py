"""Whether rigid foundations lie where nothing else holds the rock by contact."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.case.layout import Scene
from crackgrow.case.model import EdgeRegion
from crackgrow.case.regions import SAME_PLACE, ends_of


def check_foundations(scene: Scene) -> None:
    """Report foundations under a boundary that two bodies share, and two foundations in one place."""
    seen: list[tuple[int, EdgeRegion]] = []
    for index, _ in scene.items("supports", "contact"):
        key = ("supports", index, "on")
        region = scene.regions.get(key)
        if region is None:
            continue
        for pair in scene.shared:
            if region.body in pair and _lies_on(scene, region, pair):
                other = pair[1 - pair.index(region.body)]
                message = f"a rigid foundation cannot lie where body '{region.body}' touches body '{other}'"
                scene.report.fault(key, message)
        for earlier, its_region in seen:
            if _overlap(region, its_region):
                scene.report.fault(key, f"lies partly on the foundation of supports.{earlier}")
        seen.append((index, region))


def _lies_on(scene: Scene, region: EdgeRegion, pair: tuple[str, str]) -> bool:
    """Whether a part of positive length of a region lies on the boundary shared by two bodies."""
    sides = shapely.linestrings(ends_of(scene.bodies[region.body], region))
    shared = shapely.multilinestrings([shapely.linestrings(line) for line in scene.shared[pair]])
    near = shared.buffer(2 * scene.tolerance)
    # A line that only touches the shared one runs inside of the buffer for a few tolerances.
    return bool(np.any(shapely.length(shapely.intersection(sides, near)) > 100 * scene.tolerance))


def _overlap(first: EdgeRegion, second: EdgeRegion) -> bool:
    """Whether two regions have a part of a side in common."""
    if first.body != second.body:
        return False
    return any(
        side == other and min(limits[1], its_limits[1]) - max(limits[0], its_limits[0]) > SAME_PLACE
        for side, limits in zip(first.sides, first.limits, strict=True)
        for other, its_limits in zip(second.sides, second.limits, strict=True)
    )
