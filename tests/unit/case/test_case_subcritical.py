"""The law of subcritical growth in a case file: what it needs, and what does not go with it."""

from __future__ import annotations

from tests.slow_cracks import GROWTH, slow_cracks

LAW, CONSTANTS = "growth.law", "growth.subcritical"
VELOCITY, EXPONENT, THRESHOLD = (f"{CONSTANTS}.{key}" for key in ("velocity", "exponent", "threshold"))


def test_left_out_tips_grow_where_the_criterion_is_met() -> None:
    growth = slow_cracks(f"growth={{{GROWTH}}}").growth
    assert growth is not None
    assert growth.subcritical is None


def test_stages_and_histories_load_cracks_that_grow_slowly() -> None:
    assert slow_cracks("loading={history: [0.5, 1.0]}").growth is not None
    assert slow_cracks("loading={stages: [{factor: 0.5}, {factor: 1.0}]}").growth is not None
