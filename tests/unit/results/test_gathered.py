"""Warnings of a run: one sentence a cause, the important ones first, with places and steps."""

from __future__ import annotations

import json
import math

from crackgrow.results.gathered import MOST_PLACES, Gathered
from crackgrow.run.caution import Cause, Caution


def overlap(name: str, percent: float) -> Caution:
    return Caution(Cause.OVERLAP, f"'{name}' overlaps by {percent:g} %", f"'{name}'", percent)


def test_a_cause_is_one_sentence_that_tells_its_worst_place_and_lists_the_others() -> None:
    gathered = Gathered()
    for step in range(3, 15):
        gathered.add(step, [overlap("a", 5.0), overlap("b", 30.0 if step == 7 else 6.0)])
    gathered.add(14, [overlap("c", 1.0)])
    assert gathered.sentences() == ["steps 3 to 14, worst 7: 'b' overlaps by 30 %; likewise 'a', 'c'"]
    assert gathered.sentences(with_steps=False) == ["'b' overlaps by 30 %; likewise 'a', 'c'"]


def test_important_causes_come_first() -> None:
    gathered = Gathered()
    gathered.add(0, [Caution(Cause.LEFT_OUT, "left out"), Caution(Cause.SAWING, "saw")])
    gathered.add(1, [Caution(Cause.UNBALANCED, "unbalanced")])
    assert gathered.sentences() == ["step 1: unbalanced", "step 0: saw", "step 0: left out"]


def test_steps_with_gaps_and_single_steps() -> None:
    gathered = Gathered()
    for step in (0, 2, 3, 4, 9):
        gathered.add(step, [Caution(Cause.RIPPLE, "close", "tip")])
    assert gathered.sentences() == ["steps 0, 2 to 4, 9: close"]


def test_of_many_places_some_are_named() -> None:
    gathered = Gathered()
    gathered.add(0, [overlap(f"f{k}", 100.0 - k) for k in range(MOST_PLACES + 4)])
    (told,) = gathered.sentences()
    assert told.endswith("'f6', 3 more")


def test_only_what_is_new_is_news() -> None:
    gathered = Gathered()
    assert gathered.add(0, [overlap("a", 5.0)]) == ["'a' overlaps by 5 %"]
    assert gathered.add(1, [overlap("a", 9.0), overlap("b", 1.0)]) == ["'b' overlaps by 1 %"]


def test_notes_that_differ_in_numbers_alone_are_one() -> None:
    gathered = Gathered()
    gathered.add(1, [Caution(Cause.NOTE, "left K_II at 0.12 of K"), Caution(Cause.NOTE, "another method")])
    gathered.add(2, [Caution(Cause.NOTE, "left K_II at 3e-05 of K")])
    assert gathered.sentences() == ["steps 1 to 2: left K_II at 0.12 of K", "step 1: another method"]


def test_records_are_json_and_bring_it_all_back() -> None:
    gathered = Gathered()
    gathered.add(0, [overlap("a", 5.0), Caution(Cause.JUMP, "no room", "tip", math.inf)])
    again = Gathered.of(json.loads(json.dumps(gathered.records())))
    for each in (gathered, again):
        each.add(1, [overlap("a", 6.0)])
    assert again.sentences() == gathered.sentences()
    assert again.records() == gathered.records()
