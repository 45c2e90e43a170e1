"""What is said of a run while it goes: a line a step, and its warnings, one sentence a cause."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from crackgrow.case.model import Case, Stage, Stages
from crackgrow.results.gathered import MOST_PLACES, Gathered
from crackgrow.results.log import Progress, step_line, told_line
from crackgrow.run.caution import Cause, Caution
from crackgrow.run.result import StartResult, StepResult
from tests.unit.results.synthetic import make_case, make_result

GROWS = ", criticality 1.2, grows at K 1.67 MPa sqrt(m), "
STILL = ", criticality 0.2, no tip advanced, "
START = "most critical start at (0 m, -20 mm) (tension), criticality 0.871"


@pytest.mark.parametrize(("step", "tips", "told"), [
    (1, [0, 1], {GROWS}),
    (1, [0], {STILL, START}),
    (2, [0], {START}),  # the last step: no tip was to advance
    (1, [], {START}),
])  # fmt: skip
def test_a_step_tells_how_critical_its_tips_are_or_the_place_where_a_crack_may_start(
    step: int, tips: list[int], told: set[str]
) -> None:
    result = make_result(step, start=StartResult(np.array([8e-17, -0.02]), "tension", 0.8712))
    result = replace(result, tips=tuple(result.tips[number] for number in tips))
    line = told_line(result, make_case(), 0.0)
    assert {words for words in (GROWS, STILL, START) if words in line} == told
    assert ("criticality" in line.replace(START, "")) == bool(tips)
    logged = step_line(result, 3)
    assert {words for words in (GROWS, START) if words in logged} == told - {STILL}


def said_of(case: Case, *results: StepResult) -> list[list[str]]:
    """Parts of the lines of the steps."""
    said: list[str] = []
    progress = Progress(case, lambda text, end: said.append(text), width=None)
    for result in results:
        progress.show(result)
    return [text.split(", ") for text in said if text.startswith("step")]


def test_the_lines_of_a_run_keep_the_unit_of_K_while_K_falls() -> None:
    tip = replace(make_result(0).tips[1], K_II=0.0)
    lines = said_of(make_case(), *(make_result(0, tips=(replace(tip, K_I=K),)) for K in (114.0, 1.1e6, 0.9e6)))
    told = [part.partition("K_I ")[2] for line in lines for part in line if " K_I " in part]
    assert told == ["114 K_II 0 Pa sqrt(m)", "1.10 K_II 0.00 MPa sqrt(m)", "0.900 K_II 0.000 MPa sqrt(m)"]


def test_a_stage_is_told_by_its_name() -> None:
    stages = Stages(Stage("", 0.0, (), ()), tuple(Stage(name, 1.0, (), ()) for name in ("at rest", "excavated")))
    results = (make_result(0, load_factor=factor) for factor in (1.0, 2.0, 1.5))
    lines = said_of(replace(make_case(), loading=stages), *results)
    assert [line[1] for line in lines] == ["stage 'at rest'", "stage 'excavated'", "load factor 1.5"]


def overlap(name: str, percent: float) -> Caution:
    return Caution(Cause.OVERLAP, f"'{name}' overlaps by {percent:g} %", f"'{name}'", percent)


CLOSE = Caution(Cause.RIPPLE, "close", "tip")


@pytest.mark.parametrize(("cautions", "sentences"), [
    (  # a cause tells its worst place and lists the others
        {step: [overlap("a", 5), overlap("b", 30 if step == 7 else 6), *[overlap("c", 1)] * (step == 14)]
         for step in range(3, 15)},
        ["steps 3 to 14, worst 7: 'b' overlaps by 30 %; likewise 'a', 'c'"],
    ),
    (  # the important ones come first
        {0: [Caution(Cause.LEFT_OUT, "left out"), Caution(Cause.SAWING, "saw")],
         1: [Caution(Cause.UNBALANCED, "unbalanced")]},
        ["step 1: unbalanced", "step 0: saw", "step 0: left out"],
    ),
    ({step: [CLOSE] for step in (0, 2, 3, 4, 9)}, ["steps 0, 2 to 4, 9: close"]),
    (  # notes that differ in numbers alone are one
        {1: [Caution(Cause.NOTE, "left K_II at 0.12 of K"), Caution(Cause.NOTE, "another method")],
         2: [Caution(Cause.NOTE, "left K_II at 3e-05 of K")]},
        ["steps 1 to 2: left K_II at 0.12 of K", "step 1: another method"],
    ),
])  # fmt: skip
def test_a_cause_of_warnings_is_one_sentence(cautions: dict[int, list[Caution]], sentences: list[str]) -> None:
    gathered = Gathered()
    for step, each in cautions.items():
        gathered.add(step, each)
    assert gathered.sentences() == sentences
    assert gathered.sentences(with_steps=False) == [text.split(": ", 1)[1] for text in sentences]


def test_of_many_places_some_are_named() -> None:
    gathered = Gathered()
    gathered.add(0, [overlap(f"f{k}", 100.0 - k) for k in range(MOST_PLACES + 4)])
    assert [text.endswith("'f6', 3 more") for text in gathered.sentences()] == [True]


def test_only_what_is_new_is_news_and_records_bring_it_all_back() -> None:
    gathered = Gathered()
    assert gathered.add(0, [overlap("a", 5.0), Caution(Cause.JUMP, "no room", "tip", math.inf)]) == [
        "'a' overlaps by 5 %", "no room"
    ]  # fmt: skip
    again = Gathered.of(json.loads(json.dumps(gathered.records())))
    for each in (gathered, again):
        assert each.add(1, [overlap("a", 9.0), overlap("b", 1.0)]) == ["'b' overlaps by 1 %"]
    assert again.sentences() == gathered.sentences()
    assert again.records() == gathered.records()
