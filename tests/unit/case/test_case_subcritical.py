"""The law of subcritical growth in a case file: what it needs, and what does not go with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow.case import load_case
from crackgrow.case.dump import dump_case
from crackgrow.case.model import Subcritical
from crackgrow.errors import CaseError
from tests.slow_cracks import GROWTH, slow_cracks

LAW, CONSTANTS = "growth.law", "growth.subcritical"
VELOCITY, EXPONENT, THRESHOLD = (f"{CONSTANTS}.{key}" for key in ("velocity", "exponent", "threshold"))
WITHOUT = "{tension: 5, cohesion: 20, friction_angle: 40}"


def test_left_out_tips_grow_where_the_criterion_is_met() -> None:
    growth = slow_cracks(f"growth={{{GROWTH}}}").growth
    assert growth is not None
    assert growth.subcritical is None


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [("0.01", 0.01), ("10 mm/s", 0.01), ("1 cm/s", 0.01), ("3 nm/s", 3e-9), ("86.4 mm/day", 1e-6)],
)
def test_law_reads_back(velocity: str, expected: float, tmp_path: Path) -> None:
    case = slow_cracks(f"{VELOCITY}={velocity}", f"{THRESHOLD}=0.2")
    assert case.growth is not None
    assert case.growth.subcritical == Subcritical(expected, 10.0, 0.2)
    path = tmp_path / "again.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    assert dump_case(load_case(path)) == dump_case(case)


def test_stages_and_histories_load_cracks_that_grow_slowly() -> None:
    assert slow_cracks("loading={history: [0.5, 1.0]}").growth is not None
    assert slow_cracks("loading={stages: [{factor: 0.5}, {factor: 1.0}]}").growth is not None


@pytest.mark.parametrize(
    ("settings", "key", "words"),
    [
        ([f"{LAW}=slow"], LAW, "'slow' is not one of critical | subcritical"),
        ([f"{LAW}=critical"], CONSTANTS, "is for law: subcritical"),
        ([f"growth={{{GROWTH}, law: subcritical}}"], CONSTANTS, "missing: {velocity: v_max, exponent: n}"),
        ([f"{CONSTANTS}=10"], CONSTANTS, "wanted: a mapping of velocity, exponent, threshold"),
        ([f"{CONSTANTS}.rate=1"], f"{CONSTANTS}.rate", "unknown key"),
        ([f"{CONSTANTS}={{exponent: 3}}"], VELOCITY, "missing"),
        ([f"{CONSTANTS}={{velocity: 1}}"], EXPONENT, "missing"),
        ([f"{VELOCITY}=0"], VELOCITY, "out of range"),
        ([f"{VELOCITY}=-1 mm/s"], VELOCITY, "out of range"),
        ([f"{VELOCITY}=.inf"], VELOCITY, "is not finite"),
        ([f"{VELOCITY}=3 mm"], VELOCITY, "has a unit of length"),
        ([f"{VELOCITY}=3 mm/h"], VELOCITY, "a bare number means m/s"),
        ([f"{EXPONENT}=-1"], EXPONENT, "out of range"),
        ([f"{EXPONENT}=201"], EXPONENT, "out of range"),
        ([f"{EXPONENT}=.nan"], EXPONENT, "is not finite"),
        ([f"{THRESHOLD}=1"], THRESHOLD, "out of range"),
        ([f"{THRESHOLD}=-0.1"], THRESHOLD, "out of range"),
        (["growth.advance=most_critical"], "growth.advance", "wanted with law: subcritical: all"),
        (["growth.advance=in_turn"], "growth.advance", "wanted with law: subcritical: all"),
        (["growth.initiation.at=outlines"], "growth.initiation.at", "wanted with law: subcritical: tips"),
        (["loading=critical"], "loading", "a history of loads, or stages"),
        (["loading=strength_reduction"], "loading", "leave out `growth`"),
        (
            [f"bodies.rock.strength={WITHOUT}", "growth.tip_stress.radius=1"],
            LAW,
            "bodies.rock.strength has no toughness; give it one",
        ),
    ],
)
def test_faults(settings: list[str], key: str, words: str) -> None:
    with pytest.raises(CaseError) as caught:
        slow_cracks(*settings)
    found = [fault for fault in caught.value.faults if fault.key == key]
    assert any(words in fault.message for fault in found), caught.value.faults
