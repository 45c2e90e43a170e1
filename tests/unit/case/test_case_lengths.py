"""Accuracy and the automatic spacing: lengths that a lattice must resolve, and what they and presets give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from crackgrow.case import dump_case, load_case
from crackgrow.case.accuracy import REFINED_AT, TARGETS, cells_along
from crackgrow.case.dump import written
from crackgrow.case.sizing import Length, automatic_spacing
from crackgrow.plan.text import overview
from tests.unit.case.scenes import COMPRESSION, MATERIAL, compression, fault, load

# --- the rule --------------------------------------------------------------------------------------------------------

WIDE = Length("width", 20.0, "wide")
THIN = [WIDE, Length("tip", 0.05, "crack"), Length("width", 10.0, "thin")]
TINY = [*THIN, Length("tip", 0.0002, "tiny")]


@pytest.mark.parametrize(
    ("lengths", "refined", "spacing", "rule"),
    [
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
    ],
)
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
    assert listed["contact"]["spacing"] == 1.25
    assert listed["spacing"] == pytest.approx(0.031 / cells_along("width", word), rel=1e-12)
    assert listed["auto_rule"].startswith("smaller side of body 'rock' / ")
    assert f"(auto, {word}: smaller side of body 'rock' / " in overview(case)
    assert listed["refine"] == {"tips": "auto", "kinks": "auto", "corners": "auto", "rings": 2.0}


def test_explicit_keys_win_and_leave_the_others_to_the_preset(tmp_path: Path):
    own = ["spacing: 2.5", "support: 1.5", "quadrature: 3", "contact: {spacing: 2}"]
    listed = load_case(without_numerics(tmp_path, "accuracy: fine", *own)).to_dict()["numerics"]
    assert (listed["accuracy"], listed["spacing"], listed["support"], listed["quadrature"]) == ("fine", 0.0025, 1.5, 3)
    assert listed["contact"]["spacing"] == 2.0
    assert "auto_rule" not in listed
    whole = load_case(without_numerics(tmp_path, "accuracy: draft")).to_dict()["numerics"]
    part = load_case(without_numerics(tmp_path, "accuracy: draft", "support: 3")).to_dict()["numerics"]
    assert part == {**whole, "support": 3.0}
    assert "spacing 1.5 mm, support" in overview(compression())
    told = overview(compression("numerics.accuracy=fine"))
    assert "spacing 1.5 mm (given, not that of fine), support" in told


def test_resolved_automatic_case_reads_back_and_keeps_its_rule(tmp_path: Path):
    case = compression("numerics.spacing=auto")
    path = tmp_path / "compression30.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    again = load_case(path)
    assert written(again) == written(case)
    assert again.numerics.auto_rule == case.numerics.auto_rule is not None
    assert load_case(path, ["numerics.spacing=0.001"]).numerics.auto_rule is None  # not the rule's number any more
    assert load_case(path, ["bodies.rock.shape.rectangle.width=0.032"]).numerics.auto_rule is None


@pytest.mark.parametrize("text", ["1 %", "1%", "0.01", "1e-2"])
def test_an_error_of_K_can_be_asked_for(text: str, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {text}"))
    assert case.numerics.target == 0.01
    assert case.to_dict()["numerics"]["accuracy"] == 0.01


@pytest.mark.parametrize(
    ("settings", "measured", "refine"),
    [
        # a given spacing halves no cells unless told, and is not measured but for a target in percent
        ([], False, (0, 0, 0)),
        (["numerics.refine={tips: auto}"], False, ("auto", 0, 0)),
        (["numerics.accuracy=fine"], False, (0, 0, 0)),
        (["numerics.accuracy=1 %"], True, ("auto", "auto", "auto")),
    ],
)
def test_cells_by_hand(settings: list[str], measured: bool, refine: tuple[object, ...]):
    numerics = compression(*settings).numerics
    assert numerics.measured == measured
    assert (numerics.refine.tips, numerics.refine.kinks, numerics.refine.corners) == refine


# --- lengths of a scene ----------------------------------------------------------------------------------------------


def pressed(width: float, holes: list[Any], loads: list[Any]) -> dict[str, Any]:
    half = width / 2
    shape = {"rectangle": {"center": [0, 0], "width": width, "height": width}, "holes": holes}
    return {
        "title": "a block",
        "units": {"length": "m", "stress": "MPa"},
        "plane": "strain",
        "bodies": {"rock": {"shape": shape, "material": dict(MATERIAL)}},
        "supports": [
            {"at": [-half, -half], "displacement": {"x": 0, "y": 0}},
            {"at": [half, -half], "displacement": {"y": 0}},
        ],
        "loads": loads,
        "numerics": {"spacing": "auto"},
    }


def in_situ(sigma_h: float, sigma_v: float) -> list[dict[str, Any]]:
    tractions = {"left": [sigma_h, 0], "right": [-sigma_h, 0], "bottom": [0, sigma_v], "top": [0, -sigma_v]}
    return [{"on": {"body": "rock", "edge": edge}, "traction": traction} for edge, traction in tractions.items()]


def test_spacing_that_is_too_fine_tells_what_forces_it_and_a_way_out(tmp_path: Path):
    scene = pressed(40.0, [{"disk": {"center": [0, 0], "radius": 0.05}}], in_situ(10, 20))
    _, message = fault(tmp_path, scene, "numerics.refine={corners: 0}")
    assert "(auto: width of hole0 of body 'rock' / 8)" in message
    assert "give a spacing by hand, of 0.021 m or more, or a smaller body" in message
    load(tmp_path, scene, "numerics.spacing=0.021")
    assert load(tmp_path, scene).numerics.spacing == 4.0  # small cells at the hole alone
