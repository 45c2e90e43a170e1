"""Contact problems at random: each is solved, or linear programming confirms that contact does not hold it."""

from __future__ import annotations

from collections import Counter

from tests.stability.contact_at_random import drawn, ended


def test_each_is_solved_or_a_limit_state() -> None:
    ends = {seed: ended(drawn(seed))[0] for seed in range(200)}
    assert {seed: end for seed, end in ends.items() if end not in ("solved", "limit state")} == {}
    assert Counter(ends.values())["limit state"] >= 3
