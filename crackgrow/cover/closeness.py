"""What lies so close together that a cover does not resolve what is between; by the names of users."""

from __future__ import annotations

from collections.abc import Sequence

import shapely

from crackgrow.cover.cover import Cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.geometry.tolerance import ON_LINE


def ends_on(crack: CrackGeometry, cracks: Sequence[CrackGeometry]) -> list[str]:
    """The cracks that one with a tip at its other end ends on."""
    if crack.tip_at_start == crack.tip_at_end:
        return []
    end = shapely.Point(crack.seen_from(not crack.tip_at_end)[0])
    lines = [(other, shapely.LineString(other.points)) for other in cracks if other is not crack]
    return [other.name.words for other, line in lines if shapely.dwithin(line, end, ON_LINE)]


def close_pairs(cover: Cover, interfaces: Sequence[CrackGeometry], within: float) -> list[tuple[str, str]]:
    """Pairs of cracks, and tips and what they lie near, that are closer than `within`, in cells as there are there.

    Cracks that meet are close to each other there: of them only tips count.
    """
    lines = [shapely.LineString(crack.points) for crack in cover.cracks]
    names = [crack.name.words for crack in cover.cracks]
    largest = within * float(cover.sizes.max())
    found = cover.crack_tree.query(cover.crack_tree.geometries, predicate="dwithin", distance=largest).T.tolist()
    near = sorted((i, j) for i, j in found if j < i)
    meeting = [pair for pair in near if shapely.dwithin(lines[pair[0]], lines[pair[1]], ON_LINE)]
    apart = sorted(set(near) - set(meeting))
    apart = [(i, j) for i, j in apart if _near(cover, i, lines[j], within) or _near(cover, j, lines[i], within)]
    pairs = [(names[i], names[j]) for i, j in apart]
    outline = shapely.multilinestrings(shapely.linestrings(cover.elements.outlines.points))
    for tip, (index, at_end) in zip(cover.tips, cover.tip_ends, strict=True):
        name, place, reach = cover.cracks[index].name.end(at_end), shapely.Point(tip.point), within * tip.size
        others = [i if j == index else j for i, j in meeting if index in (i, j)]
        pairs.extend((name, names[other]) for other in others if shapely.dwithin(lines[other], place, reach))
        if shapely.dwithin(outline, place, reach):
            there = [x.name.words for x in interfaces if shapely.dwithin(shapely.LineString(x.points), place, reach)]
            pairs.append((name, there[0] if there else "the outline"))
    return pairs


def _near(cover: Cover, crack: int, line: shapely.LineString, within: float) -> bool:
    """Whether any part of a crack is closer to a line than `within` of the cells beside it."""
    edges, reach = cover.surfaces[crack].edges, within * cover.surfaces[crack].sizes
    return bool(shapely.dwithin(shapely.linestrings(edges.points), line, reach + ON_LINE).any())
