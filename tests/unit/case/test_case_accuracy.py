"""Presets of the numerical settings and the automatic spacing: what is listed, what wins, what the rule says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.accuracy import REFINED_AT, TARGETS, automatic_spacing, cells_along
from crackgrow.case.features import Length
from crackgrow.plan.overview import overview
from tests.scenes import shipped_case

CASES = Path(__file__).parents[3] / "cases"
FILE = Path(__file__).parent / "compression30.yaml"
NAMES = sorted(path.stem for path in CASES.glob("*.yaml"))
WIDE = Length("width", 20.0, "wide")


def numerics(case: Case) -> dict[str, Any]:
    found: Any = case.resolved["numerics"]
    return dict(found)


def shipped(name: str, *overrides: str) -> Case:
    return shipped_case(name, overrides)


def given(*overrides: str) -> Case:
    return load_case(FILE, overrides)


def without_numerics(tmp_path: Path, *lines: str) -> Path:
    """compression30 whose numerics are these lines alone."""
    text = FILE.read_text(encoding="utf-8")
    assert text.count("  spacing: 1.5") == 1
    path = tmp_path / "scene.yaml"
    path.write_text(text[: text.index("  spacing: 1.5")] + "".join(f"  {line}\n" for line in lines), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("lengths", "spacing", "rule"),
    [
        ([Length("tip", 10.0, "crack a"), Length("tip", 2.0, "crack b"), WIDE], 1.0, "crack b / 2"),
        ([Length("tip", 10.0, "crack a"), WIDE, Length("width", 5.0, "thin")], 0.5, "thin / 10"),
        ([Length("tip", 10.0, "crack a"), WIDE, Length("increment", 0.5, "increment")], 0.5, "increment / 1"),
        ([WIDE, Length("increment", 1.0, "increment"), Length("radius", 0.25, "radius")], 0.5, "radius / 0.5"),
        ([WIDE], 2.0, "wide / 10"),
        ([WIDE, Length("feature", 4.0, "hole")], 0.5, "hole / 8"),
        (
            [WIDE, Length("bridge", 4.5, "rock"), Length("support", 8.0, "foot"), Length("load", 5.0, "strip")],
            1.5,
            "rock / 3",
        ),
    ],
)
def test_smallest_length_rules_where_no_cells_are_halved(lengths: list[Length], spacing: float, rule: str):
    assert automatic_spacing("standard", lengths) == (spacing, rule)


def test_lengths_at_which_cells_are_refined_count_by_the_smallest_cells():
    lengths = [WIDE, Length("tip", 0.05, "crack"), Length("width", 10.0, "thin")]
    assert automatic_spacing("standard", lengths, REFINED_AT["tips"]) == (1.0, "thin / 10")
    tiny = [*lengths, Length("tip", 0.0002, "tiny")]
    assert automatic_spacing("standard", tiny, REFINED_AT["tips"]) == (0.4096, "tiny / 2 x 2^12")
    assert automatic_spacing("standard", tiny, REFINED_AT["corners"]) == (0.0001, "tiny / 2")


@pytest.mark.parametrize(("target", "part"), [(0.2, 0.6), (0.03, 0.6), (0.0125, 0.8), (0.01, 1.0), (0.004, 2.0)])
def test_cells_to_begin_with_follow_the_target_within_limits(target: float, part: float):
    assert cells_along("width", target) == pytest.approx(10.0 * part)


@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_case_has_an_automatic_spacing_that_presets_refine(name: str):
    spacings = [
        shipped(name, "numerics.spacing=auto", f"numerics.accuracy={word}").numerics.spacing for word in TARGETS
    ]
    assert spacings[0] > spacings[1] > spacings[2]


UNIFORM = ("barton_bandis", "rough_joint_sheared", "09_wear")
"""Blocks of uniform stress, which two cells across them carry exactly."""


@pytest.mark.parametrize(
    "name", [name for name in NAMES if shipped(name).numerics.auto_rule is None and name not in UNIFORM]
)
def test_where_no_cells_are_halved_the_spacings_of_shipped_cases_lie_between_draft_and_fine_or_are_coarser(name: str):
    uniform = ["numerics.spacing=auto", "numerics.refine={tips: 0, kinks: 0, corners: 0}"]
    draft, fine = (shipped(name, *uniform, f"numerics.accuracy={word}").numerics for word in ("draft", "fine"))
    given = shipped(name).numerics.spacing
    assert draft.spacing > 0.5 * given
    assert fine.spacing < given or shipped(name).numerics.refine.tips > 0  # small cells at tips alone
    assert (fine.refine.tips, fine.refine.kinks, fine.refine.corners) == (0, 0, 0)


@pytest.mark.parametrize("word", list(TARGETS))
def test_preset_is_listed_in_the_resolved_case(word: str, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {word}"))
    listed = numerics(case)
    assert (listed["accuracy"], listed["support"], listed["quadrature"]) == (word, 2.0, 3)
    assert listed["contact"]["spacing"] == 1.25
    assert listed["spacing"] == pytest.approx(0.031 / cells_along("width", word), rel=1e-12)
    assert listed["auto_rule"].startswith("smaller side of body 'rock' / ")
    assert f"(auto, {word}: smaller side of body 'rock' / " in overview(case)
    assert listed["refine"] == {"tips": "auto", "kinks": "auto", "corners": "auto", "rings": 2.0}


@pytest.mark.parametrize("word", list(TARGETS))
def test_without_small_cells_the_spacing_resolves_what_they_would(word: str, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {word}", "refine: {tips: 0, kinks: 0, corners: 0}"))
    expected = {
        "length of crack 'flaw'": 0.010 / cells_along("tip", word),
        "growth.increment": 0.002 / cells_along("increment", word),
        "growth.tip_stress.radius": 0.001 / cells_along("radius", word),
        "smaller side of body 'rock'": 0.031 / cells_along("width", word),
    }
    least = min(expected, key=lambda what: expected[what])
    assert case.numerics.spacing == pytest.approx(expected[least], rel=1e-12)
    assert str(case.numerics.auto_rule).startswith(f"{least} / ")


def test_a_given_spacing_halves_no_cells_unless_told():
    refine = given().numerics.refine
    assert (refine.tips, refine.kinks, refine.corners) == (0, 0, 0)
    asked = given("numerics.refine={tips: auto}").numerics.refine
    assert (asked.tips, asked.kinks, asked.corners) == ("auto", 0, 0)


def test_explicit_keys_win(tmp_path: Path):
    path = without_numerics(
        tmp_path, "accuracy: fine", "spacing: 2.5", "support: 1.5", "quadrature: 3", "contact: {spacing: 2}"
    )
    listed = numerics(load_case(path))
    assert (listed["accuracy"], listed["spacing"], listed["support"], listed["quadrature"]) == ("fine", 0.0025, 1.5, 3)
    assert listed["contact"]["spacing"] == 2.0
    assert "auto_rule" not in listed


def test_overview_tells_that_a_given_spacing_is_not_the_presets():
    assert "spacing 1.5 mm, support" in overview(given())
    assert "spacing 1.5 mm (given, not that of fine), support" in overview(given("numerics.accuracy=fine"))


def test_one_explicit_key_leaves_the_others_to_the_preset(tmp_path: Path):
    whole = numerics(load_case(without_numerics(tmp_path, "accuracy: draft")))
    part = numerics(load_case(without_numerics(tmp_path, "accuracy: draft", "support: 3")))
    assert part == {**whole, "support": 3.0}


def test_resolved_automatic_case_reads_back_and_keeps_its_rule(tmp_path: Path):
    case = given("numerics.spacing=auto")
    path = tmp_path / "compression30.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    again = load_case(path)
    assert again.resolved == case.resolved
    assert again.numerics.auto_rule == case.numerics.auto_rule is not None
    assert load_case(path, ["numerics.spacing=0.001"]).numerics.auto_rule is None  # not the rule's number any more
    assert load_case(path, ["bodies.rock.shape.rectangle.width=0.032"]).numerics.auto_rule is None


@pytest.mark.parametrize("text", ["1 %", "1%", "0.01", "1e-2"])
def test_an_error_of_K_can_be_asked_for(text: str, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {text}"))
    assert case.numerics.target == 0.01
    assert numerics(case)["accuracy"] == 0.01


@pytest.mark.parametrize(("word", "target"), TARGETS.items())
def test_names_are_targets(word: str, target: float, tmp_path: Path):
    numerics = load_case(without_numerics(tmp_path, f"accuracy: {word}")).numerics
    assert (numerics.target, numerics.measured) == (target, True)


def test_cells_by_hand_are_not_measured_but_for_a_target_in_percent(tmp_path: Path):
    by_hand = load_case(without_numerics(tmp_path, "accuracy: fine", "spacing: 2"))
    assert not by_hand.numerics.measured
    asked = load_case(without_numerics(tmp_path, "accuracy: 1 %", "spacing: 2")).numerics
    assert (asked.measured, asked.refine.tips) == (True, "auto")
