"""Laws, toughness, starts and loads of steps; accuracy, and the automatic spacing that lengths of a scene give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.accuracy import REFINED_AT, TARGETS, cells_along
from crackgrow.case.model import CoulombContact, CriticalLoad, LoadHistory, Stages
from crackgrow.case.sizing import Length, automatic_spacing
from crackgrow.case.toughness import averaging_radius, shear_radius
from crackgrow.errors import CaseError
from crackgrow.plan.text import overview
from tests.unit.case.scenes import (
    COMPRESSION,
    EVERYTHING,
    compression,
    edited,
    load,
    reread,
    same,
    two_blocks,
)

# --- laws of contact -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("keys", "residual", "kept", "dilation"), [
    ("residual_friction: 0.4, cohesion_after_slip: kept, dilation_angle: 5 deg", 0.4, True, 5.0), ("", 0.6, False, 0.0)
])  # fmt: skip
def test_cracks_interfaces_and_foundations_have_the_same_laws(
    keys: str, residual: float, kept: bool, dilation: float, tmp_path: Path
):
    places = ("cracks.flaw", "interfaces.0", "supports.0")
    case = load(tmp_path, EVERYTHING, *(f"{at}.contact={{friction: 0.6, cohesion: 2, {keys}}}" for at in places))
    for contact in (case.cracks[0].contact, case.interfaces[0].contact, case.supports[0].contact):
        assert isinstance(contact, CoulombContact)
        assert (contact.friction, contact.cohesion, contact.residual_friction) == (0.6, 2e6, residual)
        assert (contact.cohesion_kept, contact.dilation_angle) == (kept, dilation)


# --- toughness, and the averaging radius that follows from it --------------------------------------------------------

RADIUS = ("  tip_stress:\n    radius: 1 ", "#")


def tough(folder: Path, toughness: str = "0.04 MPa sqrt(m)", *edits: tuple[str, str]) -> Path:
    """compression30 with a toughness in place of its radius."""
    return edited(folder, ("tension: 0.5", f"toughness: {toughness}\n      tension: 0.5"), RADIUS, *edits)


def sheared(folder: Path, shear_toughness: str = "0.06 MPa sqrt(m)") -> Path:
    """compression30 with a toughness in shear beside that in tension."""
    return tough(folder, f"0.04 MPa sqrt(m)\n      shear_toughness: {shear_toughness}")


def radius_of(case: Case) -> float:
    return averaging_radius(case.growth, case.bodies[0].strength)


def shear_radius_of(case: Case) -> float | None:
    return shear_radius(case.growth, case.bodies[0].strength)


def test_radii_follow_from_strengths_and_toughnesses(tmp_path: Path):
    case = load_case(sheared(tmp_path))
    assert case.growth.tip_radius is None
    assert radius_of(case) == pytest.approx((2.0 * 0.04 / 0.5) ** 2 / (2.0 * np.pi), rel=1e-14)
    cohesion = case.bodies[0].strength.cohesion
    assert shear_radius_of(case) == pytest.approx((2.0 * 0.06e6 / cohesion) ** 2 / (2.0 * np.pi), rel=1e-14)
    assert dump_case(reread(case, tmp_path)) == dump_case(case)
    by_K = ["growth.criterion=max_hoop_stress", "growth.initiation=ends"]  # where K decides all but starts
    assert shear_radius_of(load_case(sheared(tmp_path), by_K)) is not None
    assert shear_radius_of(load_case(tough(tmp_path))) is None


def test_direction_that_is_left_out_is_corrected_where_K_decides_all(tmp_path: Path):
    by_K, given = "growth.criterion=max_hoop_stress", "growth.direction=explicit"
    found = [load_case(tough(tmp_path), settings).growth.direction for settings in ([by_K], [], [by_K, given])]
    assert found == ["implicit", "explicit", "explicit"]
    assert compression(by_K).growth.direction == "explicit"  # as ever without a toughness


def test_automatic_spacing_resolves_the_radii_that_are_averaged_over(tmp_path: Path):
    automatic = ["numerics.spacing=auto", "numerics.refine.tips=0"]
    case = load_case(sheared(tmp_path, "0.2 MPa sqrt(m)"), [*automatic, "numerics.refine.kinks=0"])
    assert case.numerics.spacing == pytest.approx(2.0 * (shear_radius_of(case) or 0.0))  # half a spacing wide at least
    assert "shear toughness of body 'rock'" in str(case.numerics.auto_rule)
    path = tough(tmp_path, "0.01 MPa sqrt(m)")
    case = load_case(path, [*automatic, "growth.criterion=strength"])
    assert case.numerics.spacing == pytest.approx(2.0 * radius_of(case))
    assert "toughness of body 'rock'" in str(case.numerics.auto_rule)
    case = load_case(path, [*automatic, "growth.criterion=max_hoop_stress"])
    assert "toughness" not in str(case.numerics.auto_rule)  # nothing is averaged


def test_a_critical_load_needs_no_tip_where_cracks_may_start():
    no_tips = ["cracks.flaw.tips=none", "loading=critical"]
    assert compression(*no_tips, "growth.initiation.at=outlines").growth is not None
    with pytest.raises(CaseError, match="did you mean 'outlines'") as caught:  # the only fault
        compression(*no_tips, "growth.initiation=outline")
    assert len(caught.value.faults) == 1


# --- the loads of steps ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("settings", "factors", "increments"), [
    (["loading.history=[1, 0, -1]"], (1.0, 0.0, -1.0), None),
    (["loading={history: [0.5, 0.5, 1e-1]}"], (0.5, 0.5, 0.1), None),
    (["loading.history=[0]"], (0.0,), None),
    (["loading={}"], (1.0,), None),
    (["loading.follow=events"], (1.0,), "events"),
    (["loading.follow=auto"], (1.0,), None),
    (["loading.follow=8"], (1.0,), 8),
    # a history takes the place of a word
    (["loading=critical", "loading.history=[2, 3]", "loading.history.1=4"], (2.0, 4.0), None),
    (["loading=critical"], None, None),
    (["loading.history=[1]", "loading=critical"], None, None),
])  # fmt: skip
def test_history_or_critical_load(settings: list[str], factors: tuple[float, ...] | None, increments: int | str | None):
    loading = compression(*settings).loading
    if factors is None:
        assert isinstance(loading, CriticalLoad)
    else:
        assert isinstance(loading, LoadHistory)
        assert (loading.factors, loading.increments) == (factors, increments)


# --- stages ----------------------------------------------------------------------------------------------------------

LOADS: list[dict[str, Any]] = [
    {"on": {"body": "low", "edge": "right"}, "traction": [1, 0]},
    {"on": {"body": "top", "edge": "right"}, "traction": [1, 0], "name": "push"},
    {"on": {"body": "top", "edge": "left"}, "traction": [-1, 0], "name": "push"},
    {"body": "low", "stress": [0, -1, 0], "held": True, "name": "rest"},
]


def test_a_stage_has_what_the_one_before_has_unless_it_says_otherwise(tmp_path: Path):
    stages = [
        {"name": "first"},
        {"loads": {"push": 0.5, "rest": 0.25}, "factor": 2},
        {"excavate": "top", "release": 0.3},
        {"loads": {"rest": 0}},
        {"release": 1},
    ]
    case = load(tmp_path, {**two_blocks(), "loads": LOADS, "loading": {"stages": stages}})
    assert isinstance(case.loading, Stages)
    assert dict(case.loading.before.loads) == {"push": 0.0, "rest": 1.0}
    told = [(s.name, s.factor, dict(s.loads), dict(s.excavated)) for s in case.loading.stages]
    assert told == [
        ("first", 1.0, {"push": 0.0, "rest": 1.0}, {}),
        ("stage 1", 2.0, {"push": 0.5, "rest": 0.25}, {}),
        ("stage 2", 2.0, {"push": 0.5, "rest": 0.25}, {"top": 0.3}),
        ("stage 3", 2.0, {"push": 0.5, "rest": 0.0}, {"top": 0.3}),
        ("stage 4", 2.0, {"push": 0.5, "rest": 0.0}, {"top": 1.0}),
    ]
    assert case.last_step == 4
    assert same(case, reread(case, tmp_path))


# --- the rule --------------------------------------------------------------------------------------------------------

WIDE = Length("width", 20.0, "wide")
THIN = [WIDE, Length("tip", 0.05, "crack"), Length("width", 10.0, "thin")]
TINY = [*THIN, Length("tip", 0.0002, "tiny")]


@pytest.mark.parametrize(("lengths", "refined", "spacing", "rule"), [
    ([Length("tip", 10.0, "crack a"), Length("tip", 2.0, "crack b"), WIDE], None, 1.0, "crack b / 2"),
    ([Length("tip", 10.0, "crack a"), WIDE, Length("width", 5.0, "thin")], None, 0.5, "thin / 10"),
    ([Length("tip", 10.0, "crack a"), WIDE, Length("increment", 0.5, "step")], None, 0.5, "step / 1"),
    ([WIDE, Length("increment", 1.0, "step"), Length("radius", 0.25, "radius")], None, 0.5, "radius / 0.5"),
    ([WIDE], None, 2.0, "wide / 10"),
    ([WIDE, Length("feature", 4.0, "hole")], None, 0.5, "hole / 8"),
    ([WIDE, Length("bridge", 4.5, "rock"), Length("support", 8.0, "foot")], None, 1.5, "rock / 3"),
    ([WIDE, Length("support", 2.0, "foot")], None, 0.5, "foot / 4"),
    ([WIDE, Length("load", 1.0, "strip")], None, 0.5, "strip / 2"),
    # where cells are refined, a length counts by the smallest of them
    (THIN, "tips", 1.0, "thin / 10"),
    (TINY, "tips", 0.4096, "tiny / 2 x 2^12"),
    (TINY, "corners", 0.0001, "tiny / 2"),
])  # fmt: skip
def test_the_smallest_length_rules(lengths: list[Length], refined: str | None, spacing: float, rule: str):
    at = (REFINED_AT[refined],) if refined else ()
    assert automatic_spacing("standard", lengths, *at) == (spacing, rule)


# --- presets and targets ---------------------------------------------------------------------------------------------


def without_numerics(folder: Path, *lines: str) -> Path:
    """compression30 whose numerics are these lines alone."""
    text = COMPRESSION[: COMPRESSION.index("  spacing: 1.5")] + "".join(f"  {line}\n" for line in lines)
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    return folder / "scene.yaml"


@pytest.mark.parametrize(("word", "target"), TARGETS.items())
def test_a_preset_is_a_target_and_is_listed_in_the_resolved_case(word: str, target: float, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {word}"))
    assert (case.numerics.target, case.numerics.measured) == (target, True)
    listed = case.to_dict()["numerics"]
    assert (listed["accuracy"], listed["support"], listed["quadrature"]) == (word, 2.0, 3)
    assert listed["spacing"] == pytest.approx(0.031 / cells_along("width", word), rel=1e-12)
    assert listed["auto_rule"].startswith("smaller side of body 'rock' / ")
    assert f"(auto, {word}: smaller side of body 'rock' / " in overview(case)
    assert listed["refine"] == {"tips": "auto", "kinks": "auto", "corners": "auto", "rings": 2.0}


def test_explicit_keys_win_and_leave_the_others_to_the_preset(tmp_path: Path):
    listed = load_case(without_numerics(tmp_path, "accuracy: fine", "spacing: 2.5")).to_dict()["numerics"]
    assert (listed["accuracy"], listed["spacing"], "auto_rule" in listed) == ("fine", 0.0025, False)
    whole = load_case(without_numerics(tmp_path, "accuracy: draft")).to_dict()["numerics"]
    part = load_case(without_numerics(tmp_path, "accuracy: draft", "support: 3")).to_dict()["numerics"]
    assert part == {**whole, "support": 3.0}
    assert "spacing 1.5 mm, support" in overview(compression())
    told = overview(compression("numerics.accuracy=fine"))
    assert "spacing 1.5 mm (given, not that of fine), support" in told


def test_resolved_automatic_case_reads_back_and_keeps_its_rule(tmp_path: Path):
    case = compression("numerics.spacing=auto")
    assert reread(case, tmp_path).numerics.auto_rule == case.numerics.auto_rule is not None
    for setting in ("numerics.spacing=0.001", "bodies.rock.shape.rectangle.width=0.032"):  # not the rule's any more
        assert load_case(tmp_path / "compression30.yaml", [setting]).numerics.auto_rule is None


@pytest.mark.parametrize(("settings", "measured", "refine"), [
    # a given spacing halves no cells unless told, and is not measured but for a target in percent
    ([], False, (0, 0, 0)),
    (["numerics.refine={tips: auto}"], False, ("auto", 0, 0)),
    (["numerics.accuracy=fine"], False, (0, 0, 0)),
    (["numerics.accuracy=1 %"], True, ("auto", "auto", "auto")),
])  # fmt: skip
def test_cells_by_hand(settings: list[str], measured: bool, refine: tuple[object, ...]):
    numerics = compression(*settings).numerics
    assert numerics.measured == measured
    assert (numerics.refine.tips, numerics.refine.kinks, numerics.refine.corners) == refine


@pytest.mark.parametrize("text", ["1 %", "1%", "0.01", "1e-2"])
def test_an_error_of_K_can_be_asked_for(text: str):
    assert compression(f"numerics.accuracy={text}").numerics.target == 0.01
