"""The table of targets: what it counts, and that it is that of what was measured."""

from __future__ import annotations

from tests.benchmarks.target_scenes import SCENES
from tests.benchmarks.targets import TEXT, Pair, read, summary_of, text_of


def pair(error: float, expected: float, told: int = 0) -> Pair:
    return Pair("cross", 0.01, error, 2.0 * expected, expected, told, 100, 1.0, 1.5)


def test_the_text_is_that_of_the_numbers() -> None:
    assert TEXT.read_text() == text_of(read())


def test_sixty_pairs_and_more_of_every_kind_are_measured() -> None:
    kinds = {SCENES[pair.scene].kind for pair in read() if pair.unknowns}
    assert len(read()) >= 60
    assert {"straight", "grown", "young", "kinked", "branched", "crossed", "two interacting", "edge", "disk"} <= kinds


def test_pairs_are_counted_by_what_came_of_them() -> None:
    """Within the target; beyond it, told and silently; an error that the truth is not good enough to judge."""
    pairs = [pair(0.005, 0.006), pair(0.02, 0.009, told=1), pair(0.02, 0.05), pair(1e-5, 0.005)]
    text = summary_of(pairs)
    numbers = {line.split("|")[1].strip(): line.split("|")[2].strip() for line in text.splitlines()[2:]}
    assert numbers["true error within the target"] == "2"
    assert numbers["beyond the target without a warning"] == "1"
    assert numbers["true error within the bound, but for that of the truth"] == "3"
    assert numbers["pairs whose truth is good enough to judge what is expected"] == "3"
    assert numbers["of them within a half and twice"] == "33 %"
    assert numbers["cost in the median"] == "1.50"
