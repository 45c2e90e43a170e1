"""A crack at a bond stops, turns or crosses by what it takes, and tells it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.crack_at_bond import TOUGHNESS, crack_at_bond
from tests.solving import whole_run

pytestmark = pytest.mark.physics

DRAFT = "numerics.accuracy=draft"
LOADED = "loading={history: [3.8]}"  # G straight on is 0.957 of the toughness of the rock
NO_STRENGTH = "bodies.right={shape: {polygon: [[0, -200], [200, -200], [200, 200], [0, 200]]}, material: " + (
    "{young: 20 GPa, poisson: 0.25}}"
)


def toughness(share: float) -> str:
    """That of the bond, as a share of the rock's."""
    return f"interfaces.0.toughness={share * TOUGHNESS}"


def test_it_stops_below_both_toughnesses() -> None:
    results, end = whole_run(crack_at_bond(LOADED, toughness(0.28)))
    assert (len(results), end.status, [event.kind for event in end.events]) == (1, "arrested", ["stop"])
    assert "stops at interface 'left/right' (G/G_c of 0.9" in end.events[0].words


def test_it_turns_to_both_sides_where_they_are_equal_and_goes_on_along_the_bond() -> None:
    results, end = whole_run(crack_at_bond(LOADED, toughness(0.24)))
    assert end.status == "completed"
    (event,) = results[1].events
    assert "crack 'flaw' (end) turns along interface 'left/right'" in event.words
    assert [tip.advanced for tip in results[1].interface_tips] == [True, True]
    for step, result in enumerate(results[1:], 1):
        found = sorted(float(tip.point[1]) for tip in result.interface_tips)
        np.testing.assert_allclose(found, [-1e-3 * step, 1e-3 * step], atol=1e-9)
        first, second = (tip.G for tip in result.interface_tips)
        assert first == pytest.approx(second, rel=1e-4)


def test_it_does_not_cross_into_rock_whose_strength_is_not_known() -> None:
    """At the load at which it turns, however large that is."""
    results, _ = whole_run(crack_at_bond(NO_STRENGTH, toughness(1.0), "growth.steps=1"))
    (event,) = results[1].events
    assert event.kind == "deflection"
    assert "unknown straight on" in event.met
    assert max(tip.criticality for tip in results[1].interface_tips) == pytest.approx(1.0)


def test_under_a_pressure_that_is_held_the_load_at_which_it_goes_on_rises_by_that() -> None:
    """By superposition: pressure and loads are the same but for their sign. The crack is closed at first."""
    factors = [
        whole_run(crack_at_bond(NO_STRENGTH, toughness(0.3), "growth.steps=1", DRAFT, pressed=pressed))[0][
            0
        ].load_factor
        for pressed in (0.0, 2.0, 5.0)
    ]
    np.testing.assert_allclose(np.subtract(factors, factors[0]), [0.0, 2.0, 5.0], atol=5e-3 * factors[0])


def test_it_goes_on_in_the_other_body_as_its_crack() -> None:
    results, _ = whole_run(crack_at_bond(toughness(0.4)))
    assert [event.kind for event in results[1].events] == ["crossing"]
    new = results[-1].cracks[-1]
    assert new.name == "new1"
    np.testing.assert_allclose(new.points, [[0, 0], [1e-3, 0], [2e-3, 0]], atol=1e-5)


def test_equal_cracks_go_on_together_and_the_step_is_that_of_their_load() -> None:
    """Every step has the load factor at which something just grows: G of what grows is that of the toughness."""
    two = {name: f"{{path: [[-30, {y}], [0, {y}]], contact: none, tips: none}}" for name, y in (("b", 7), ("a", -7))}
    both = f"cracks={{{', '.join(f'{name}: {crack}' for name, crack in two.items())}}}"
    case = crack_at_bond(both, toughness(0.1), "numerics.accuracy=draft", "growth.increment=2", "growth.steps=1")
    results, _ = whole_run(case)
    assert [(event.kind, event.crack) for event in results[1].events] == [("deflection", "a"), ("deflection", "b")]
    one, other = results[1].cracks
    assert len(results[1].interface_tips) == 4
    G = np.sort([tip.G for tip in results[1].interface_tips if np.isfinite(tip.G)])
    np.testing.assert_allclose(G, 0.1 * TOUGHNESS, rtol=1e-6)
    assert len(one.points) == len(other.points) == 2
    assert results[0].load_factor == pytest.approx(results[1].load_factor, rel=0.05)
