"""Which tips grow, where cracks can start, and the geometry of what is added."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
import shapely

from crackgrow.case.model import Crack
from crackgrow.fracture.advance import (
    CLEARANCE,
    STARTS,
    TIE,
    GrowingCrack,
    Segment,
    Start,
    advanced,
    advancing_sites,
    started,
    without_tip,
)
from crackgrow.fracture.meeting import CORNER
from crackgrow.fracture.sites import BESIDE, Site, StartRegions, start_sites

PLATE = shapely.box(-10.0, -10.0, 10.0, 10.0)


def growing(points: list[tuple[float, float]], steps: list[int] | None = None) -> GrowingCrack:
    crack = Crack("flaw", np.array(points, dtype=float), True, True, None, "rock")
    return GrowingCrack(crack, np.array(steps or [0] * len(points), dtype=np.int64))


LESS, MORE, FAR_MORE = 1.0 - 0.5 * TIE, 1.0 + 0.5 * TIE, 1.0 + 2.0 * TIE
LEAVING = [
    ("all", [1.2, 0.9, 1.0, 3.0], None, [3, 0, 2]),  # all that are critical, the most critical first
    ("all", [1.2, 3.0 * MORE, 1.2 * MORE, 3.0], None, [1, 3, 0, 2]),  # equal ones from left to right
    ("all", [1.0, LESS, 1.0 - 2.0 * TIE], None, [0, 1]),  # tied with a critical one
    ("all", [3.0, LESS], None, [0]),  # tied with nothing
    ("all", [0.999999, 0.3], None, []),
    ("most_critical", [0.999999, 0.3], None, []),
    ("in_turn", [0.999999, 0.3], None, []),
    ("all", [], None, []),
    ("most_critical", [], None, []),
    ("in_turn", [], None, []),
    ("most_critical", [1.2, 2.0, 1.9, 0.5], [0, 9, 0, 0], [1]),  # however often it has advanced
    ("most_critical", [0.4, 2.0, 2.0 * MORE], None, [1]),  # of equal ones the leftmost,
    ("most_critical", [0.4, 2.0, 2.0 * LESS], None, [1]),
    ("most_critical", [0.4, 2.0, 2.0 * MORE], [0, 3, 2], [2]),  # and before it the least advanced
    ("most_critical", [0.4, 2.0, 2.0 * LESS], [0, 3, 2], [2]),
    ("most_critical", [0.4, 2.0, 2.0 * FAR_MORE], [0, 3, 4], [2]),
    ("in_turn", [1.0, LESS], [1, 0], [1]),
    ("in_turn", [3.0, 1.1, 2.0], [2, 1, 1], [2]),  # the least advanced of those that are critical
    ("in_turn", [3.0, 0.9, 0.8], [2, 0, 0], [0]),
    ("in_turn", [2.0, 2.0], [1, 0], [1]),
    ("all", [1.1, 1.2, 1.3, 1.4], [3, 5, STARTS, STARTS], [1, 0, 3]),  # one crack starts, after the tips
    ("all", [1.1, 0.9, 1.3, 1.3], [3, 5, STARTS, STARTS], [0, 2, 3]),  # or equal ones
    ("all", [0.9, 0.5, 0.8, 0.9], [3, 5, STARTS, STARTS], []),
    *((way, [1.1, 1.2, 1.3, 1.4], [3, 5, STARTS, STARTS], [3]) for way in ("most_critical", "in_turn")),
    *((way, [1.0 + 0.1 * TIE, 0.5, 1.0], [STARTS, 5, 7], [2]) for way in ("most_critical", "in_turn")),  # equal tips
    *((way, [0.9, 0.5, 1.0, 1.0], [3, 5, STARTS, STARTS], [2]) for way in ("most_critical", "in_turn")),
]
"""How tips advance, their criticality from left to right, how often they have advanced, and which of them grow."""


@pytest.mark.parametrize(("way", "criticality", "n_advances", "expected"), LEAVING)
def test_which_tips_grow_and_where_cracks_start(
    way: Literal["most_critical", "in_turn", "all"],
    criticality: list[float],
    n_advances: list[int] | None,
    expected: list[int],
) -> None:
    counts = np.array(n_advances or [0] * len(criticality), dtype=np.int64)
    places = np.stack([np.arange(len(criticality), dtype=float), np.zeros(len(criticality))], axis=1)
    assert advancing_sites(np.array(criticality), counts, places, way).tolist() == expected


@pytest.mark.parametrize("kink_deg", [-70.5, 0.0, 45.0])
def test_the_new_vertex_lies_an_increment_on_turned_counter_clockwise(kink_deg: float) -> None:
    a, kink = np.deg2rad(130.0), np.deg2rad(kink_deg)
    direction = np.array([np.cos(a), np.sin(a)])
    before = growing([tuple(-2.0 * direction), tuple(direction)])
    for at_end, tip, outward in ((True, direction, a), (False, -2.0 * direction, a + np.pi)):
        after, met = advanced(before, at_end, Segment(kink, 0.5), 3, PLATE)
        assert met is None
        added = after.crack.points[-1 if at_end else 0]
        expected = tip + 0.5 * np.array([np.cos(outward + kink), np.sin(outward + kink)])
        np.testing.assert_allclose(added, expected, atol=1e-14)
        kept = after.crack.points[:-1] if at_end else after.crack.points[1:]
        np.testing.assert_array_equal(kept, before.crack.points)
        assert after.steps.tolist() == ([0, 0, 3] if at_end else [3, 0, 0])
        assert [after.n_advances(end) for end in (False, True)] == [not at_end, at_end]
        assert (after.crack.tip_at_start, after.crack.tip_at_end) == (True, True)


@pytest.mark.parametrize("at_end", [False, True])
def test_a_segment_that_would_leave_ends_on_the_outline_or_a_hole_without_a_tip(at_end: bool) -> None:
    holed = PLATE.difference(shapely.box(-9, -9, -8, -8)).difference(shapely.box(1.0, -1.0, 3.0, 1.0))
    number = next(k for k, hole in enumerate(holed.interiors) if hole.bounds[0] == 1.0)
    for points, way, place, expected in (
        (
            [(0.0, 5.0), (9.5, 5.0)],
            Segment(np.deg2rad(30.0), 2.0),
            [10.0, 5.0 + 0.5 * np.tan(np.deg2rad(30.0))],
            "outline",
        ),
        ([(-2.0, 0.0), (0.0, 0.0)], Segment(0.0, 5.0), [1.0, 0.0], "hole"),  # 5 would reach beyond the hole
    ):
        after, met = advanced(growing(points if at_end else points[::-1]), at_end, way, 1, holed)
        assert met is not None
        assert met.kind == expected
        assert expected == "outline" or met.number == number
        end = after.crack.points[-1 if at_end else 0]
        np.testing.assert_array_equal(end, met.point)
        np.testing.assert_allclose(end, place, atol=1e-12)
        assert [after.can_grow(False), after.can_grow(True)] == [at_end, not at_end]


FLAW = [(0.0, 0.0), (4.0, 0.0)]
"""Its end advances by 1 to (5, 0) unless it meets something."""


def across(x: float, low: float = -3.0, high: float = 3.0) -> list[tuple[float, float]]:
    return [(x, low), (x, high)]


Y = CORNER * CLEARANCE
ALONG = [(0.0, -0.05), (9.0, -0.05)]
ASIDE = [(4.0, -0.05), (2.0, -3.0)]

MEETINGS = {
    "the first that it would cross": ([across(4.8), across(4.5), across(4.9)], 0.0, (4.5, 0.0), 1, None),
    "just in front": ([across(4.03)], 0.0, (4.03, 0.0), 0, None),
    "ended in the clearance": ([across(5.0 + 0.99 * CLEARANCE)], 0.0, (5.0 + 0.99 * CLEARANCE, 0.0), 0, None),
    "the nearest point beside its end": ([[(3.0, 2.07), (7.0, -1.93)]], 0.0, (5.035, 0.035), 0, None),  # x + y = 5.07
    "a tip close to where it crosses": ([across(4.6, -0.08, 2.0)], 0.0, (4.6, -0.08), 0, False),
    "a tip far enough": ([across(4.6, -0.12, 2.0)], 0.0, (4.6, 0.0), 0, None),
    "a junction close to where it crosses": ([across(4.6), [(6.0, 1.0), (4.6, 0.06)]], 0.0, (4.6, 0.06), 1, True),
    "a near corner": ([[(4.7, -2.0), (4.6, 0.9 * Y), (4.7, 2.0)]], 0.0, (4.6, 0.9 * Y), 0, None),
    **{f"the tip {tip} that it passes": ([[tip, (tip[0] + 1.0, tip[1] * 20.0)]], 0.0, tip, 0, False)
       for tip in ((4.6, 0.08), (5.06, 0.05), (4.3, -0.09), (4.7, 0.0))},
    "the other tip": ([[(5.6, 1.6), (4.6, 0.08)]], 0.0, (4.6, 0.08), 0, True),
    **{f"a crack along it, into which it turns by {drop}": ([ALONG], -drop, None, 0, None) for drop in (0.03, 0.2)},
    "beyond the clearance": ([across(5.0 + 1.01 * CLEARANCE)], 0.0, (5.0, 0.0), None, None),
    **{f"along a crack or away from it by {kink}": ([ALONG], kink, (4.0 + np.sqrt(1.0 - kink**2), kink), None, None)
       for kink in (0.0, 0.02, 0.5 * np.sqrt(3.0), -0.01, -0.02)},
    **{f"a tip beside the tip {kink}": ([ASIDE], kink, (4.0 + np.sqrt(1.0 - kink**2), kink), None, None)
       for kink in (0.0, 0.02, 0.5 * np.sqrt(3.0))},
}  # fmt: skip
"""Other cracks, the kink (its sine), where the segment ends, on which crack (or none), and on which of its tips."""


@pytest.mark.parametrize("name", MEETINGS)
def test_a_segment_ends_on_what_it_crosses_or_comes_close_to_and_grows_on_along_it_or_away(name: str) -> None:
    others, kink, at, number, which = MEETINGS[name]
    cracks = [growing(points) for points in others]
    after, met = advanced(growing(FLAW), True, Segment(np.arcsin(kink), 1.0), 7, PLATE, cracks)
    assert (after.can_grow(False), after.can_grow(True)) == (True, met is None)
    assert all(crack.can_grow(end) for crack in cracks for end in (False, True))
    end = after.crack.points[-1]
    found = None if met is None else (met.kind, met.number, met.end)
    assert found == (None if number is None else ("crack", number, which))
    np.testing.assert_allclose(end[1:] if at is None else end, [-0.05] if at is None else at, atol=1e-15)


def test_a_crack_ends_on_its_own_older_path_or_other_tip() -> None:
    bend = [(4.0, 0.0), (4.0, 2.0), (2.0, 2.0)]
    for first, length, end, place, tips in (
        ((0.0, 0.0), 3.0, None, [2.0, 0.0], [True, False]),
        ((2.0, 0.05), 2.0, False, [2.0, 0.05], [False, False]),
    ):
        after, met = advanced(growing([first, *bend]), True, Segment(np.deg2rad(90.0), length), 1, PLATE)
        assert met is not None
        assert (met.kind, met.end) == ("own_path", end)
        np.testing.assert_allclose(after.crack.points[-1], place, atol=1e-15)
        assert [after.can_grow(end) for end in (False, True)] == tips
    short, met = advanced(growing([(0.0, 0.0), *bend]), True, Segment(np.deg2rad(90.0), 1.5), 1, PLATE)
    assert met is None  # stops short of the first segment
    np.testing.assert_allclose(short.crack.points[-1], [2.0, 0.5], atol=1e-14)


@pytest.mark.parametrize("kink_deg", [-120.0, -90.0, 70.5, 120.0])
@pytest.mark.parametrize("flaw_length", [0.1, 5.0])
def test_a_wing_leaves_its_own_flaw_and_meets_no_short_segment_that_it_goes_straight_on_from(
    kink_deg: float, flaw_length: float
) -> None:
    """A digitised trace has segments far shorter than an increment."""
    crack = growing([(-flaw_length, 0.0), (0.0, 0.0)])
    for step, (at_end, turn) in enumerate([(True, kink_deg), (False, kink_deg), (True, 0.0), (False, 0.0)], start=1):
        crack, met = advanced(crack, at_end, Segment(np.deg2rad(turn), 1.0), step, PLATE)
        assert met is None
    assert np.hypot(*np.diff(crack.crack.points, axis=0).T) == pytest.approx([1.0, 1.0, flaw_length, 1.0, 1.0])
    for last in (0.5, 0.02, 1e-6):
        trace = growing([(0.0, 0.0), (4.0, 0.0), (4.0 + last, 0.0)])
        longer, met = advanced(trace, True, Segment(np.deg2rad(30.0), 2.0), 1, PLATE)
        assert met is None
        assert np.hypot(*(longer.crack.points[-1] - longer.crack.points[-2])) == pytest.approx(2.0, rel=1e-12)


HOLED = PLATE.difference(shapely.Point(3.0, 3.0).buffer(1.5, quad_segs=3))


def wandering(rng: np.random.Generator) -> GrowingCrack:
    """A crack of one to three segments inside of the holed plate, that doesn't touch itself."""
    while True:
        turns = np.cumsum(rng.uniform(-1.2, 1.2, rng.integers(1, 4))) + rng.uniform(0.0, 2.0 * np.pi)
        steps = rng.choice([0.05, 0.6, 3.0], len(turns))[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        points = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)]) + rng.uniform(-9.0, 9.0, 2)
        line = shapely.LineString(points)
        if line.is_simple and HOLED.contains(line) and not shapely.dwithin(line, HOLED.boundary, 1e-3):
            return growing([tuple(point) for point in points])


@pytest.mark.parametrize("seed", range(20))
def test_whatever_lies_around_a_segment_meets_at_most_what_it_ends_on(seed: int) -> None:
    """Cracks that don't touch grow at random: no segment ever crosses anything, and one that met nothing is whole."""
    rng = np.random.default_rng(seed)
    cracks: list[GrowingCrack] = []
    while len(cracks) < 12:
        crack = wandering(rng)
        if not any(shapely.dwithin(line_of(crack), line_of(other), 1e-3) for other in cracks):
            cracks.append(crack)
    kinds = []
    for step in range(1, 80):
        index, at_end = int(rng.integers(len(cracks))), bool(rng.integers(2))
        if not cracks[index].can_grow(at_end):
            continue
        others = [other for number, other in enumerate(cracks) if number != index]
        before, increment = cracks[index], float(rng.uniform(0.2, 2.0))
        after, met = advanced(before, at_end, Segment(rng.uniform(-1.3, 1.3), increment), step, HOLED, others)
        points = after.crack.points[::-1] if at_end else after.crack.points
        tip, inner = points[1], shapely.LineString(before.crack.points)
        length = np.hypot(*(points[0] - tip))
        if met is None:
            assert length == pytest.approx(increment, rel=1e-12)
            way, own = shapely.LineString(points[:2]), shapely.LineString([0.999 * tip + 0.001 * points[0], points[0]])
        else:
            kinds.append(met.kind)
            assert length <= (1.0 + CLEARANCE) * increment
            way = shapely.LineString([tip, 1e-5 * tip + (1.0 - 1e-5) * points[0]])
            own = shapely.LineString([0.999 * tip + 0.001 * points[0], way.coords[1]])
            is_rim = met.kind in ("outline", "hole")
            there = HOLED.boundary if is_rim else line_of(others[met.number]) if met.kind == "crack" else inner
            assert shapely.distance(shapely.Point(points[0]), there) < 1e-13
        assert not any(shapely.intersects(way, line_of(other)) for other in others)
        assert not shapely.intersects(own, inner)
        assert HOLED.covers(way)
        cracks[index] = after
        if met is not None and met.kind == "crack" and met.end is not None:
            other = next(number for number, other in enumerate(cracks) if other is others[met.number])
            cracks[other] = without_tip(others[met.number], met.end)
    assert len(kinds) > 5


def line_of(growing: GrowingCrack) -> shapely.LineString:
    return shapely.LineString(growing.crack.points)


@pytest.mark.parametrize(("link", "met"), [(CLEARANCE, False), (0.5, True)])
def test_a_segment_links_up_with_a_crack_that_it_heads_for_within_the_link_distance(link: float, met: bool) -> None:
    """It would end 0.3 of its length in front of the other crack; outlines are reached at the clearance."""
    wall = growing([(-3.0, 1.3), (3.0, 1.3)])
    after, meeting = advanced(growing([(0.0, -2.0), (0.0, 0.0)]), True, Segment(0.0, 1.0, link), 1, PLATE, [wall])
    assert (meeting is not None) == met
    assert after.crack.points[-1, 1] == pytest.approx(1.3 if met else 1.0)
    after, meeting = advanced(growing([(0.0, 7.0), (0.0, 8.7)]), True, Segment(0.0, 1.0, link), 1, PLATE)
    assert meeting is None
    assert after.crack.points[-1, 1] == pytest.approx(9.7)


def start_on_the_flaw(both_ways: bool = False) -> Start:
    """Half way along a flaw, upwards."""
    new = replace(growing(FLAW).crack, name="new1")
    return Start(new, 0, False, np.zeros(2), 0.5 * np.pi, both_ways, "crack 'flaw'")


def test_a_new_crack_leaves_the_one_that_it_starts_on() -> None:
    flaw = growing([(-1.0, 0.0), (1.0, 0.0)])
    new, met = started(replace(start_on_the_flaw(), in_shear=True), Segment(-0.2, 0.5, 0.5), 4, PLATE, [flaw])
    assert met == []
    np.testing.assert_allclose(new.crack.points, [[0.0, 0.0], [0.5 * np.sin(0.2), 0.5 * np.cos(0.2)]], atol=1e-15)
    assert new.steps.tolist() == [4, 4]
    assert (new.can_grow(False), new.can_grow(True)) == (False, True)
    assert (new.parent, new.in_shear, new.n_advances(True)) == (0, True, 0)
    longer, _ = advanced(new, True, Segment(0.0, 0.5), 5, PLATE, [flaw])
    assert (longer.parent, longer.in_shear, longer.n_advances(True)) == (0, True, 1)


def test_a_new_crack_ends_on_what_it_meets_and_goes_both_ways_in_the_rock() -> None:
    flaw, above, below = (growing([(-1.0, y), (1.0, y)]) for y in (0.0, 0.3, -0.2))
    new, met = started(start_on_the_flaw(), Segment(0.0, 0.5), 1, PLATE, [flaw, above])
    assert [(at_end, found.kind, found.number) for at_end, found in met] == [(True, "crack", 1)]
    assert not new.can_grow(True)
    np.testing.assert_allclose(new.crack.points[-1], [0.0, 0.3], atol=1e-15)
    new, met = started(start_on_the_flaw(both_ways=True), Segment(0.0, 1.0), 1, PLATE, [below])
    np.testing.assert_allclose(new.crack.points, [[0.0, -0.2], [0.0, 0.0], [0.0, 0.5]], atol=1e-15)
    assert [(at_end, found.kind) for at_end, found in met] == [(False, "crack")]
    assert (new.can_grow(False), new.can_grow(True)) == (False, True)


APART = 0.5
BENT = [(2.0, 6.1), (6.05, 6.1), (8.05, 6.1 + 2.0 * np.sqrt(3.0))]  # turns by 60 degrees
GENTLE = [(2.0, 6.1), (6.05, 6.1), (10.05, 7.1)]
WALL, GUEST = [(6.05, 2.0), (6.05, 10.0)], [(2.0, 6.1), (6.05, 6.1)]
KINK = (6.05, 6.1)
SLIGHT = np.rad2deg(np.arctan(0.25)) / 2  # half of the turn of GENTLE


def looked(on_cracks: bool = False, on_rims: bool = False, in_rock: bool = False) -> StartRegions:
    return StartRegions(on_cracks, on_rims, in_rock, 2.0, (APART,))


def sites(sample, where: StartRegions, began=()) -> list[Site]:
    """Sites with their places as those of the sample, whose spacing is 1."""
    cover, origin = sample.cover, sample.lattice.to_lattice(np.zeros(2))
    found = start_sites(cover, [0] * len(cover.cracks), [place + origin for place in began], where)
    return [replace(site, point=site.point - origin) for site in found]


def plate(build, *cracks):
    given = [build.crack(np.array(path), (path[0][0] > 0.0, True)) for path in cracks]
    return build.sample((0.0, 0.0), (12.0, 12.0), given, support=2.0, spacing=1.0)


CORNERS = [
    ([BENT], [], [(0, 120.0, 30.0), (0, 300.0, 90.0)]),  # a corner of rock on either side of a kink
    ([GENTLE], [], []),
    ([GENTLE], [KINK], [(0, 90.0 + SLIGHT, 60.0 - SLIGHT), (0, 270.0 + SLIGHT, 60.0 + SLIGHT)]),  # where growth began
    ([GUEST], [KINK], []),  # an end of a crack
    ([WALL, GUEST], [], [(1, 0.0, 60.0), (1, 135.0, 15.0), (1, 225.0, 15.0)]),  # behind WALL the guest may go on
]


@pytest.mark.parametrize(("cracks", "began", "ways"), CORNERS)
def test_starts_on_cracks_are_the_corners_of_rock(build, cracks: list, began: list, ways: list) -> None:
    """Crack, direction and half width in degrees of the corners at the kink or junction."""
    found = sites(plate(build, *cracks), looked(on_cracks=True), [np.array(place) for place in began])
    assert len(found) == len(ways)
    for site in found:
        assert site.kind == "crack"
        np.testing.assert_allclose(site.point, KINK, atol=1e-8)
    degrees = [(site.crack, np.rad2deg(site.direction) % 360.0, np.rad2deg(site.half_width)) for site in found]
    np.testing.assert_allclose(np.reshape(sorted(degrees), (-1, 3)), np.reshape(ways, (-1, 3)), atol=1e-6)


def test_starts_on_rims_look_into_the_rock_and_keep_clear_of_cracks(build) -> None:
    found = sites(plate(build, [(0.0, 6.0), (4.0, 6.0)]), looked(on_rims=True))
    points = np.array([site.point for site in found])
    inward = np.array([[np.cos(site.direction), np.sin(site.direction)] for site in found])
    assert ((points + 0.1 * inward > 0.0) & (points + 0.1 * inward < 12.0)).all()
    np.testing.assert_allclose([site.half_width for site in found], 0.5 * np.pi - BESIDE, rtol=1e-12)
    assert np.hypot(*(points - [0.0, 6.0]).T).min() > APART
    assert {tuple(point) for point in points.tolist()} >= {(2.0, 0.0), (12.0, 4.0), (0.0, 4.0), (0.0, 8.0)}


def test_points_of_the_rock_keep_clear_of_rims_and_cracks(build) -> None:
    """Rock without strength has no starts at all."""
    found = sites(plate(build, [(2.0, 5.0), (10.0, 5.0)]), looked(in_rock=True))
    points = np.array([site.point for site in found])
    assert points.min() >= APART
    assert points.max() <= 12.0 - APART
    across = np.maximum(np.maximum(2.0 - points[:, 0], points[:, 0] - 10.0), 0.0)
    assert np.hypot(across, points[:, 1] - 5.0).min() > APART
    assert sites(plate(build, BENT), StartRegions(True, True, True, 2.0, (None,))) == []
