"""Contact problems at random: each is solved, or linear programming confirms that contact does not hold it."""

from __future__ import annotations

from collections import Counter

from tests.stability.contact_at_random import drawn, ended


def test_each_is_solved_or_a_limit_state() -> None:
    ends = {seed: ended(drawn(seed))[0] for seed in range(200)}
    assert {seed: end for seed, end in ends.items() if end not in ("solved", "limit state")} == {}
    assert Counter(ends.values())["limit state"] >= 3


def test_there_are_all_kinds() -> None:
    problems = [drawn(seed).problem for seed in range(200)]
    kinds = {drawn(seed).kind for seed in range(200)}
    assert kinds == {f"{kind}{graded}" for kind in ("faces", "blocks", "random") for graded in ("", ", graded")}
    for some in (
        [problem.friction.max() > 4.0 for problem in problems],
        [(problem.cohesion > 0.0).any() for problem in problems],
        [(problem.dilation > 0.0).any() for problem in problems],
        [problem.slipped.any() for problem in problems],
        [problem.n_motions == 12 for problem in problems],
        [problem.motions is not None and not problem.motions.pull.any() for problem in problems],
    ):
        assert 5 < sum(some) < 195
