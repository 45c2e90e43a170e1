"""Whether cracks meet at points only: themselves not at all, and others never with a tip."""

from __future__ import annotations

import numpy as np
import shapely

from crackgrow.arrays import Ints
from crackgrow.case.layout import Scene
from crackgrow.case.segments import MOST_PAIRS, Segments, close_segments, common_parts, places_between, segments_of


def check_meetings(scene: Scene, names: list[str], refused_tips: set[tuple[str, str]]) -> None:
    """Report cracks of these names that run along each other, or meet another one with a tip; none meets itself.

    refused_tips: crack and end of tips that have a fault already
    """
    if not names:
        return
    segments = segments_of([scene.cracks[name] for name in names])
    pairs = close_segments(segments, scene.tolerance)
    if len(pairs) > MOST_PAIRS:
        scene.report.fault(("cracks",), f"the cracks cross or touch more than {MOST_PAIRS} times")
        return
    lines = segments.lines[pairs]
    parts = common_parts(segments.ends[pairs[:, 0]], segments.ends[pairs[:, 1]], scene.tolerance)
    runs = ~np.isnan(parts[:, 0, 0])
    along: set[tuple[str, str]] = set()
    for index in np.flatnonzero(runs & (lines[:, 0] != lines[:, 1])).tolist():
        one, other = (names[line] for line in lines[index])
        if (one, other) not in along:
            along.add((one, other))
            shown = " to ".join(scene.point(end) for end in parts[index])
            message = f"runs along crack '{one}' from {shown}; cracks may meet at points only: shorten one of them"
            scene.report.fault(("cracks", other, "path"), message)
    _check_tips(scene, names, segments, along, refused_tips)


def meets_itself(scene: Scene, name: str) -> bool:
    """Whether a crack crosses, touches or lies on itself; reports the first place."""
    segments = segments_of([scene.cracks[name]])
    pairs = close_segments(segments, scene.tolerance)
    parts = common_parts(segments.ends[pairs[:, 0]], segments.ends[pairs[:, 1]], scene.tolerance)
    found = np.flatnonzero(~np.isnan(parts[:, 0, 0]) | (pairs[:, 1] - pairs[:, 0] > 1))
    if len(found):
        _refuse_itself(scene, segments, name, pairs[found[0]])
    return len(found) > 0


def _refuse_itself(scene: Scene, segments: Segments, name: str, pair: Ints) -> None:
    """Report that two segments of a crack cross, touch or lie on each other."""
    first, second = pair.tolist()
    if second - first == 1:
        where = scene.point(segments.ends[second, 0])
        message = f"folds back on itself at vertex {second} {where}; end it there"
    else:
        where = scene.point(places_between(segments, pair[None])[0])
        message = f"crosses or touches itself at {where}; give it as two cracks, which may meet there"
    scene.report.fault(("cracks", name, "path"), message)


def _check_tips(
    scene: Scene, names: list[str], segments: Segments, along: set[tuple[str, str]], refused: set[tuple[str, str]]
) -> None:
    """Report tips that lie on another crack, unless they are refused already or the two run along each other."""
    points = np.concatenate([scene.cracks[name][[0, -1]] for name in names])
    ends, others = segments.tree.query(shapely.points(points), predicate="dwithin", distance=scene.tolerance)
    hosts: dict[str, dict[str, str]] = {}
    for end, host in sorted(zip(ends.tolist(), segments.lines[others].tolist(), strict=True)):
        if end // 2 != host:
            hosts.setdefault(names[end // 2], {}).setdefault(("start", "end")[end % 2], names[host])
    for name, found in hosts.items():
        tips = [end for end in scene.tips_of(name) if (name, end) not in refused]
        left = " ".join(end for end in tips if end not in found) or "none"
        for end, host in found.items():
            if end in tips and not {(name, host), (host, name)} & along:
                where = scene.point(scene.cracks[name][0 if end == "start" else -1])
                message = f"the tip at the {end} {where} lies on crack '{host}', where it cannot grow"
                remedy = f"leave this end out of `tips`: `tips: {left}`"
                scene.report.fault(("cracks", name, "path"), f"{message}; {remedy}")
