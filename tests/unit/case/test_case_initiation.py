"""Where a case lets cracks start, and how near to each other they link up."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow.case import load_case
from crackgrow.case.dump import dump_case
from crackgrow.case.model import Initiation
from crackgrow.errors import CaseError
from tests.scenes import shipped_case

CASE = "compression30"
AT = "growth.initiation.at"
SPACING = "growth.initiation.spacing"


def test_left_out_cracks_go_on_at_tips_alone() -> None:
    growth = shipped_case(CASE).growth
    assert growth is not None
    assert (growth.initiation, growth.link_distance) == (Initiation("tips", None), None)


@pytest.mark.parametrize("at", ["tips", "ends", "cracks", "outlines", "anywhere"])
def test_a_word_alone_says_where(at: str) -> None:
    short, long = (shipped_case(CASE, [setting]) for setting in (f"growth.initiation={at}", f"{AT}={at}"))
    assert dump_case(short) == dump_case(long)


def test_a_word_alone_takes_an_override_of_a_key_inside() -> None:
    short, long = (shipped_case(CASE, [f"{key}=outlines", f"{SPACING}=5"]) for key in ("growth.initiation", AT))
    assert short.growth is not None
    assert (short.growth.initiation.at, short.growth.initiation.spacing) == ("outlines", 5e-3)
    assert dump_case(short) == dump_case(long)
    changed = shipped_case(CASE, ["growth.initiation=ends", f"{AT}=outlines", f"{SPACING}=5"])
    assert dump_case(changed) == dump_case(long)


def test_a_place_that_is_misspelt_is_the_only_fault() -> None:
    with pytest.raises(CaseError) as caught:
        shipped_case(CASE, ["cracks.flaw.tips=none", "loading=critical", "growth.initiation=outline"])
    assert [fault.key for fault in caught.value.faults] == [AT]


def test_a_critical_load_needs_no_tip_where_cracks_may_start() -> None:
    no_tips = ["cracks.flaw.tips=none", "loading=critical"]
    assert shipped_case(CASE, [*no_tips, f"{AT}=outlines"]).growth is not None
    with pytest.raises(CaseError, match="needs a tip that can grow"):
        shipped_case(CASE, no_tips)


def test_rock_without_strength_has_nowhere_to_start(tmp_path: Path) -> None:
    path = tmp_path / "plate.yaml"
    path.write_text(
        """
title: a plate
units: {length: mm, stress: MPa}
bodies: {rock: {shape: {rectangle: {center: [0, 0], width: 40, height: 40}}, material: {young: 1, poisson: 0.2}}}
supports: minimal
loads: [{on: {body: rock, edge: top}, traction: [0, 1]}, {on: {body: rock, edge: bottom}, traction: [0, -1]}]
plane: strain
growth:
  {steps: 1, increment: 2, advance: all, criterion: strength, tip_stress: {radius: 1}, initiation: {at: outlines}}
numerics: {spacing: 4}
""",
        encoding="utf-8",
    )
    with pytest.raises(CaseError, match="no body has a strength, and cracks start only where the rock has one"):
        load_case(path)
