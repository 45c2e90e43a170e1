"""Which tips grow, and the geometry of what is added."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.case.model import Crack
from crackgrow.errors import GeometryError
from crackgrow.fracture.advance import TIE, GrowingCrack, advanced, growing_tips

PLATE = shapely.box(-10.0, -10.0, 10.0, 10.0)
NONE_YET = np.zeros(4, dtype=np.int64)


def growing(points: list[tuple[float, float]], steps: list[int] | None = None) -> GrowingCrack:
    crack = Crack("flaw", np.array(points, dtype=float), True, True, None, "rock")
    return GrowingCrack(crack, np.array(steps or [0] * len(points), dtype=np.int64))


def test_all_critical_tips_grow_with_all() -> None:
    assert growing_tips(np.array([1.2, 0.9, 1.0, 3.0]), NONE_YET, "all").tolist() == [0, 2, 3]


@pytest.mark.parametrize("advance", ["most_critical", "in_turn", "all"])
def test_no_tip_grows_below_the_criterion(advance: str) -> None:
    assert growing_tips(np.array([0.999999, 0.3]), NONE_YET[:2], advance).tolist() == []
    assert growing_tips(np.array([]), NONE_YET[:0], advance).tolist() == []


def test_the_most_critical_tip_grows_however_often_it_has() -> None:
    criticality = np.array([1.2, 2.0, 1.9, 0.5])
    assert growing_tips(criticality, np.array([0, 9, 0, 0]), "most_critical").tolist() == [1]


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_of_equally_critical_tips_the_first_grows_whatever_the_round_off(sign: float) -> None:
    criticality = np.array([0.4, 2.0, 2.0 * (1.0 + sign * 0.5 * TIE)])
    assert growing_tips(criticality, NONE_YET[:3], "most_critical").tolist() == [1]
    clear = np.array([0.4, 2.0, 2.0 * (1.0 + 2.0 * TIE)])
    assert growing_tips(clear, NONE_YET[:3], "most_critical").tolist() == [2]


def test_in_turn_takes_the_critical_tip_that_has_advanced_least() -> None:
    assert growing_tips(np.array([3.0, 1.1, 2.0]), np.array([2, 1, 1]), "in_turn").tolist() == [2]
    assert growing_tips(np.array([3.0, 0.9, 0.8]), np.array([2, 0, 0]), "in_turn").tolist() == [0]  # not critical
    assert growing_tips(np.array([2.0, 2.0]), np.array([1, 0]), "in_turn").tolist() == [1]


@pytest.mark.parametrize("kink_deg", [-70.5, 0.0, 45.0])
@pytest.mark.parametrize("turn_deg", [0.0, 130.0])
def test_the_new_vertex_lies_an_increment_on_turned_counter_clockwise(turn_deg: float, kink_deg: float) -> None:
    a, kink = np.deg2rad(turn_deg), np.deg2rad(kink_deg)
    direction = np.array([np.cos(a), np.sin(a)])
    before = growing([tuple(-2.0 * direction), tuple(direction)])
    for at_end, tip, outward in ((True, direction, a), (False, -2.0 * direction, a + np.pi)):
        after, left = advanced(before, at_end, kink, 0.5, 3, PLATE)
        assert not left
        added = after.crack.points[-1 if at_end else 0]
        expected = tip + 0.5 * np.array([np.cos(outward + kink), np.sin(outward + kink)])
        np.testing.assert_allclose(added, expected, atol=1e-14)
        kept = after.crack.points[:-1] if at_end else after.crack.points[1:]
        np.testing.assert_array_equal(kept, before.crack.points)
        assert after.steps.tolist() == ([0, 0, 3] if at_end else [3, 0, 0])
        assert (after.crack.tip_at_start, after.crack.tip_at_end) == (True, True)


def test_advancing_changes_nothing_of_the_crack_before() -> None:
    before = growing([(0.0, 0.0), (1.0, 0.0)])
    points, steps = before.crack.points.copy(), before.steps.copy()
    advanced(before, True, 0.3, 0.5, 1, PLATE)
    np.testing.assert_array_equal(before.crack.points, points)
    np.testing.assert_array_equal(before.steps, steps)


def test_two_opposite_kinks_at_both_ends_keep_point_symmetry() -> None:
    crack, _ = advanced(growing([(-1.0, -0.5), (1.0, 0.5)]), True, 0.8, 0.7, 1, PLATE)
    crack, _ = advanced(crack, False, 0.8, 0.7, 2, PLATE)
    np.testing.assert_allclose(crack.crack.points, -crack.crack.points[::-1], atol=1e-14)
    assert crack.steps.tolist() == [2, 0, 0, 1]


def test_advances_are_counted_end_by_end() -> None:
    crack = growing([(0.0, 0.0), (1.0, 0.0), (2.0, 0.3)])
    assert [crack.n_advances(end) for end in (False, True)] == [0, 0]
    for step, at_end in enumerate([True, True, False, True], start=1):
        crack, _ = advanced(crack, at_end, 0.05, 0.4, step, PLATE)
    assert [crack.n_advances(end) for end in (False, True)] == [1, 3]
    assert crack.steps.tolist() == [3, 0, 0, 0, 1, 2, 4]


@pytest.mark.parametrize("at_end", [False, True])
def test_a_segment_that_would_leave_ends_on_the_boundary_without_a_tip(at_end: bool) -> None:
    points = [(0.0, 1.0), (9.5, 1.0)]
    before = growing(points if at_end else points[::-1])
    after, left = advanced(before, at_end, np.deg2rad(30.0), 2.0, 1, PLATE)
    assert left
    end = after.crack.points[-1 if at_end else 0]
    np.testing.assert_allclose(end, [10.0, 1.0 + 0.5 * np.tan(np.deg2rad(30.0))], atol=1e-12)
    assert (after.crack.tip_at_start, after.crack.tip_at_end) == (at_end, not at_end)


def test_a_crack_is_refused_that_would_cross_itself() -> None:
    hook = growing([(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0)])
    with pytest.raises(GeometryError, match="crack 'flaw' would meet itself"):
        advanced(hook, True, np.deg2rad(90.0), 3.0, 1, PLATE)
    short, left = advanced(hook, True, np.deg2rad(90.0), 1.5, 1, PLATE)  # stops short of the first segment
    assert not left
    np.testing.assert_allclose(short.crack.points[-1], [2.0, 0.5], atol=1e-14)


@pytest.mark.parametrize("last", [0.5, 0.02, 1e-6])
def test_a_short_last_segment_is_not_met_by_straight_growth(last: float) -> None:
    """A digitised trace has segments far shorter than an increment."""
    trace = growing([(0.0, 0.0), (4.0, 0.0), (4.0 + last, 0.0)])
    longer, left = advanced(trace, True, np.deg2rad(30.0), 2.0, 1, PLATE)
    assert not left
    np.testing.assert_allclose(np.hypot(*(longer.crack.points[-1] - longer.crack.points[-2])), 2.0, rtol=1e-12)


def test_a_crack_is_refused_that_would_come_too_close_to_another() -> None:
    wall = growing([(5.1, -3.0), (5.1, 3.0)])
    flaw = growing([(0.0, 0.0), (4.0, 0.0)])
    with pytest.raises(GeometryError, match=r"step 7: crack 'flaw' would meet crack 'flaw' near \(5\.1, 0\)"):
        advanced(flaw, True, 0.0, 1.0, 7, PLATE, [wall])
    assert not advanced(flaw, True, 0.0, 0.9, 7, PLATE, [wall])[1]
