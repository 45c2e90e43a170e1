"""Stages: what each of them says with what it leaves out, and every fault."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from crackgrow.case import dump_case
from crackgrow.case.model import Stages
from tests.unit.case.scenes import fault, load
from tests.unit.case.test_case_bodies import two_blocks
from tests.unit.case.test_case_load import reread, same

LOADS: list[dict[str, Any]] = [
    {"on": {"body": "low", "edge": "right"}, "traction": [1, 0]},
    {"on": {"body": "top", "edge": "right"}, "traction": [1, 0], "name": "push"},
    {"on": {"body": "top", "edge": "left"}, "traction": [-1, 0], "name": "push"},
    {"body": "low", "stress": [0, -1, 0], "held": True, "name": "rest"},
    {"body": "low", "stress": [0, -1, 0], "held": True, "name": "mixed"},
    {"body": "low", "stress": [0, -1, 0], "name": "mixed"},
]


def staged(*stages: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return {**two_blocks(), "loads": LOADS, "loading": {"stages": list(stages)}, **changes}


def test_a_stage_has_what_the_one_before_has_unless_it_says_otherwise(tmp_path: Path) -> None:
    case = load(
        tmp_path,
        staged(
            {"name": "first"},
            {"loads": {"push": 0.5, "rest": 0.25}, "factor": 2},
            {"excavate": "top", "release": 0.3},
            {"loads": {"rest": 0}},
            {"release": 1},
        ),
    )
    loading = case.loading
    assert isinstance(loading, Stages)
    assert dict(loading.before.loads) == {"push": 0.0, "rest": 1.0}
    told = [(s.name, s.factor, dict(s.loads), dict(s.excavated)) for s in loading.stages]
    assert told == [
        ("first", 1.0, {"push": 0.0, "rest": 1.0}, {}),
        ("stage 1", 2.0, {"push": 0.5, "rest": 0.25}, {}),
        ("stage 2", 2.0, {"push": 0.5, "rest": 0.25}, {"top": 0.3}),
        ("stage 3", 2.0, {"push": 0.5, "rest": 0.0}, {"top": 0.3}),
        ("stage 4", 2.0, {"push": 0.5, "rest": 0.0}, {"top": 1.0}),
    ]
    assert case.last_step == 4
    again = reread(case, tmp_path)
    assert same(case, again)
    assert dump_case(again) == dump_case(case)


def test_a_step_of_growth_goes_through_all_stages(tmp_path: Path) -> None:
    growth = {
        "steps": 1, "increment": 1, "advance": "all", "criterion": "max_hoop_stress", "unload_between_steps": False
    }  # fmt: skip
    flaw = {"flaw": {"path": {"points": [[1, 0.5], [3, 0.5]]}, "contact": "none"}}
    scene = staged({}, growth=growth, cracks=flaw)
    scene["bodies"]["low"]["strength"] = {
        "tension": 1, "cohesion": 1, "friction_angle": 30, "toughness": "1 MPa sqrt(m)"
    }  # fmt: skip
    where, message = fault(tmp_path, scene)
    assert where == "growth.unload_between_steps"
    assert "Every step goes through all stages" in message
