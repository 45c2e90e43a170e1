"""Laws of contact, toughness, where cracks start, and the loads of steps: histories, critical loads and stages."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.model import CoulombContact, CriticalLoad, LoadHistory, Stages
from crackgrow.case.toughness import averaging_radius, shear_radius
from crackgrow.errors import CaseError
from tests.unit.case.scenes import (
    COMPRESSION,
    EVERYTHING,
    compression,
    edited,
    faults_of,
    load,
    reread,
    same,
    two_blocks,
)

# --- laws of contact -------------------------------------------------------------------------------------------------

BRIEF = {"friction": 0.6, "cohesion": 2}
FULL = {**BRIEF, "residual_friction": 0.4, "cohesion_after_slip": "kept", "dilation_angle": "5 deg"}


@pytest.mark.parametrize("kind", ["cracks", "interfaces", "supports"])
@pytest.mark.parametrize(("law", "residual", "kept", "dilation"), [(FULL, 0.4, True, 5.0), (BRIEF, 0.6, False, 0.0)])
def test_law_with_every_key_and_with_defaults(
    kind: str, law: dict[str, Any], residual: float, kept: bool, dilation: float, tmp_path: Path
):
    scene = copy.deepcopy(EVERYTHING)
    scene[kind]["flaw" if kind == "cracks" else 0]["contact"] = law
    case = load(tmp_path, scene)
    contact = {"cracks": case.cracks, "interfaces": case.interfaces, "supports": case.supports}[kind][0].contact
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
    assert shear_radius_of(load_case(tough(tmp_path))) is None


@pytest.mark.parametrize(
    ("settings", "direction"),
    [
        (["growth.criterion=max_hoop_stress"], "implicit"),
        (["growth.criterion=directional_strength"], "explicit"),
        (["growth.criterion=max_hoop_stress", "growth.direction=explicit"], "explicit"),
    ],
)
def test_direction_that_is_left_out_is_corrected_where_K_decides_all(
    settings: list[str], direction: str, tmp_path: Path
):
    assert load_case(tough(tmp_path), settings).growth.direction == direction
    assert compression(*settings).growth.direction == "explicit"  # as ever without a toughness


def test_toughness_in_shear_is_taken_where_K_decides_all_but_where_cracks_start(tmp_path: Path):
    by_K = "growth.criterion=max_hoop_stress"
    (fault,) = faults_of(sheared(tmp_path), [by_K])
    assert "unless cracks start in shear" in fault.message
    assert shear_radius_of(load_case(sheared(tmp_path), [by_K, "growth.initiation=ends"])) is not None


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


# --- where cracks start ----------------------------------------------------------------------------------------------

AT, SPACING = "growth.initiation.at", "growth.initiation.spacing"


@pytest.mark.parametrize("at", ["tips", "ends", "cracks", "outlines", "anywhere"])
def test_a_word_alone_says_where_cracks_start(at: str):
    assert dump_case(compression(f"growth.initiation={at}")) == dump_case(compression(f"{AT}={at}"))


def test_a_word_alone_takes_an_override_of_a_key_inside():
    wanted = compression(f"{AT}=outlines", f"{SPACING}=5")
    assert (wanted.growth.initiation.at, wanted.growth.initiation.spacing) == ("outlines", 5e-3)
    for settings in (["growth.initiation=outlines"], ["growth.initiation=ends", f"{AT}=outlines"]):
        assert dump_case(compression(*settings, f"{SPACING}=5")) == dump_case(wanted)


def test_a_critical_load_needs_no_tip_where_cracks_may_start():
    no_tips = ["cracks.flaw.tips=none", "loading=critical"]
    assert compression(*no_tips, f"{AT}=outlines").growth is not None
    with pytest.raises(CaseError) as caught:  # a misspelt place is the only fault
        compression(*no_tips, "growth.initiation=outline")
    assert [found.key for found in caught.value.faults] == [AT]


# --- the loads of steps ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "factors", "increments"),
    [
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
    ],
)
@pytest.mark.parametrize("before", ["", "\nloading: critical\n"])
def test_history_or_critical_load(
    settings: list[str], factors: tuple[float, ...] | None, increments: int | str | None, before: str, tmp_path: Path
):
    (tmp_path / "scene.yaml").write_text(COMPRESSION + before, encoding="utf-8")
    loading = load_case(tmp_path / "scene.yaml", settings).loading
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
    again = reread(case, tmp_path)
    assert same(case, again)
    assert dump_case(again) == dump_case(case)
